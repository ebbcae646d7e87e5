//! Scenario files: which FMUs run together, with which values, for how long.
//!
//! ```
//! use fmi2_cosim::scenario::Scenario;
//!
//! let scenario = Scenario::parse(
//!     "grasp.toml",
//!     r#"
//!     title = "A heavy object, pushed aside"
//!     fmus = ["DualArmPlant.fmu", "NabfcController.fmu"]
//!     [experiment]
//!     stop = 2
//!     [parameters]
//!     M = 0.6                                                     # kg
//!     [inputs]
//!     delta_F.steps = [[0, 0], [1, 0.05], [1.1, 0]]               # N
//!     lambda1_ref.linear = [[0, -0.5], [0.5, -0.5], [1, -0.6]]    # N
//!     "#,
//! )?;
//! assert_eq!((scenario.experiment.stop, scenario.inputs.len()), (Some(2.0), 2));
//! # Ok::<(), fmi2_cosim::scenario::ScenarioError>(())
//! ```
//!
//! The reference of all keys is `docs/tool.md`.

mod file;

use std::io;
use std::path::{Path, PathBuf};

use crate::files::read_text;
use crate::settings::Setting;
use crate::signal::Signal;
use crate::system::{Located, RunOptions, System};
use fmi2_import::{Causality, Fmu, FmuError, Variable};

/// A scenario as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// A short title.
    pub title: String,
    /// A description of what it shows.
    pub description: String,
    /// The FMU files as written, in the order in which they run.
    pub fmus: Vec<PathBuf>,
    /// How to run it.
    pub experiment: RunOptions,
    /// Start values, from `[parameters]`.
    pub settings: Vec<Located<Setting>>,
    /// Inputs that keep one value, from `[inputs]`.
    pub held: Vec<Located<Setting>>,
    /// Inputs that change over time.
    pub inputs: Vec<Located<(String, Signal)>>,
    /// The folder of its file; `None` if it was read from a text.
    folder: Option<PathBuf>,
}

/// Why there is no scenario.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// A value is in the wrong table.
    #[error("{place}: {name} is {problem}: it belongs under [{table}]")]
    Table {
        /// File and line.
        place: String,
        /// The variable as written.
        name: String,
        /// Its kind.
        problem: &'static str,
        /// The table in which it belongs.
        table: &'static str,
    },
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is no scenario.
    #[error("{file}:{line}:{column}: {message}")]
    Content {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The fault.
        message: String,
    },
    /// An FMU is in none of the searched folders.
    #[error("there is no {file} in {}", .searched.join(" or "))]
    NoFmu {
        /// The file as written in the scenario.
        file: String,
        /// The folders.
        searched: Vec<String>,
    },
    /// An FMU cannot be opened.
    #[error(transparent)]
    Fmu(#[from] FmuError),
}

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// When it cannot be read or is not a scenario; the error names the place and the fault.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        Ok(Self::read_with_text(path)?.0)
    }

    /// Reads a scenario file, and returns its text, too.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_with_text(path: &Path) -> Result<(Self, String), ScenarioError> {
        let text = read_text(path).map_err(|source| ScenarioError::Read { path: path.to_owned(), source })?;
        let scenario = Self::parse(&path.display().to_string(), &text)?;
        let folder = Some(path.parent().unwrap_or(Path::new("")).to_owned());
        Ok((Self { folder, ..scenario }, text))
    }

    /// Reads the text of a scenario file; `file` is its name in messages.
    ///
    /// # Errors
    /// When it is not a scenario; the error names the place and the fault.
    pub fn parse(file: &str, text: &str) -> Result<Self, ScenarioError> {
        file::parse(file, text)
    }

    /// Unpacks its FMUs from their [paths](Scenario::paths).
    ///
    /// # Errors
    /// When one is missing or cannot be used.
    pub fn system(&self, fmus: &Path) -> Result<System, ScenarioError> {
        self.system_of(&Fmu::unpack_all(&self.paths(fmus)?)?)
    }

    /// Where its FMUs are: each where the file says, relative to the file's folder, or else in the folder `fmus`.
    ///
    /// # Errors
    /// When one is not there.
    pub fn paths(&self, fmus: &Path) -> Result<Vec<PathBuf>, ScenarioError> {
        let folders: Vec<&Path> = self.folder.as_deref().into_iter().chain([fmus]).collect();
        let find = |file: &PathBuf| {
            let found = folders.iter().map(|folder| folder.join(file)).find(|path| path.exists());
            found.ok_or_else(|| ScenarioError::NoFmu {
                file: file.display().to_string(),
                searched: folders.iter().map(|folder| shown(folder)).collect(),
            })
        };
        self.fmus.iter().map(find).collect()
    }

    /// The system with these FMUs, one for each that it names.
    ///
    /// # Errors
    /// When a table of the file has something that belongs into another one.
    pub fn system_of(&self, fmus: &[Fmu]) -> Result<System, ScenarioError> {
        let system = System::of_fmus(fmus);
        self.check_tables(&system)?;
        Ok(System {
            title: Some(self.title.clone()),
            description: self.description.clone(),
            settings: [&self.settings[..], &self.held].concat(),
            inputs: self.inputs.clone(),
            experiment: self.experiment,
            ..system
        })
    }

    /// Checks that `[inputs]` has only inputs and `[parameters]` has none.
    fn check_tables(&self, system: &System) -> Result<(), ScenarioError> {
        for (table, other, settings) in [("parameters", "inputs", &self.settings), ("inputs", "parameters", &self.held)]
        {
            for Located { item, place } in settings {
                let mut meant = system.variables(&item.target).peekable();
                // A name that no component has is reported with suggestions when it is applied.
                let is_known = meant.peek().is_some();
                let belongs = |variable: &Variable| (variable.causality == Causality::Input) == (table == "inputs");
                if is_known && !meant.any(belongs) {
                    return Err(ScenarioError::Table {
                        place: place.as_ref().map(ToString::to_string).unwrap_or_default(),
                        name: item.target.clone(),
                        problem: if table == "inputs" { "no input" } else { "an input" },
                        table: other,
                    });
                }
            }
        }
        Ok(())
    }
}

/// A folder in a message.
fn shown(folder: &Path) -> String {
    if folder.as_os_str().is_empty() { "this folder".into() } else { folder.display().to_string() }
}
