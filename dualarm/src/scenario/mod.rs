//! Scenario files: which FMUs run together, with which values, for how long.
//!
//! ```
//! use dualarm::scenario::Scenario;
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
//! # Ok::<(), dualarm::scenario::ScenarioError>(())
//! ```
//!
//! The reference of all keys is `docs/tool.md`. Some files are [built in](BUILT_IN).

mod file;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::fmi::{Causality, Fmu, FmuError, Variable};
use crate::grasp::{CONTROLLERS, Controller};
use crate::settings::{self, Setting};
use crate::signal::Signal;
use crate::system::{Experiment, Located, System};

/// A scenario as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// What it is, in a few words.
    pub title: String,
    /// What it shows.
    pub description: String,
    /// The FMU files as written, in the order in which they run.
    pub fmus: Vec<PathBuf>,
    /// How to run it.
    pub experiment: Experiment,
    /// Start values, from `[parameters]`.
    pub settings: Vec<Located<Setting>>,
    /// Inputs that keep one value, from `[inputs]`.
    pub held: Vec<Located<Setting>>,
    /// Inputs that change over time.
    pub inputs: Vec<Located<(String, Signal)>>,
    /// The folder of its file; `None` for a built-in one.
    folder: Option<PathBuf>,
}

/// Why there is no scenario.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// A value stands in the wrong table.
    #[error("{place}: {name} is {problem}: it belongs under [{table}]")]
    Table {
        /// File and line.
        place: String,
        /// The variable as written.
        name: String,
        /// What it is.
        problem: &'static str,
        /// Where it belongs.
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
        /// What is wrong there.
        message: String,
    },
    /// There is no built-in scenario of this name.
    #[error(
        "there is no scenario \"{name}\"{}; `dualarm simulate --list` lists them, a file of your own ends in .toml",
        settings::suggestion(.similar)
    )]
    Unknown {
        /// What the user wrote.
        name: String,
        /// Names that come close.
        similar: Vec<String>,
    },
    /// An FMU is at none of the places where it may be.
    #[error("there is no {file} in {}; `dualarm package` makes the FMUs, --fmus says where they are", .searched.join(" or "))]
    NoFmu {
        /// The file as written in the scenario.
        file: String,
        /// The folders.
        searched: Vec<String>,
    },
    /// The scenario has no controller that another one could replace.
    #[error("--controller: this scenario runs none of {}", .known.join(", "))]
    NoController {
        /// The controllers that can be replaced.
        known: Vec<&'static str>,
    },
    /// An FMU cannot be opened.
    #[error(transparent)]
    Fmu(#[from] FmuError),
}

/// A scenario file that is compiled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltIn {
    /// The file's stem: what a user types.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
}

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        &[$(BuiltIn { name: $name, text: include_str!(concat!("../../../scenarios/", $name, ".toml")) }),*]
    };
}

/// The files of the folder `scenarios`, so that the tool has them wherever it runs; the paper's three come first.
pub const BUILT_IN: &[BuiltIn] = built_in![
    "nabfc",
    "pds",
    "pd",
    "nabfc-fast",
    "preload",
    "unknown-mass",
    "friction",
    "viscous-damping",
    "saturation",
    "raw-dead-zone",
    "disturbance-pulse",
    "loss-of-contact",
    "change-of-reference",
    "stiff-arms",
    "wrong-stiffness",
];

impl BuiltIn {
    /// The built-in scenario of that name.
    ///
    /// # Errors
    /// When there is none.
    pub fn find(name: &str) -> Result<Self, ScenarioError> {
        let names = || BUILT_IN.iter().map(|built_in| built_in.name);
        BUILT_IN.iter().find(|built_in| built_in.name == name).copied().ok_or_else(|| ScenarioError::Unknown {
            name: name.to_owned(),
            similar: settings::closest(name, names()).into_iter().map(str::to_owned).collect(),
        })
    }

    /// What it says.
    ///
    /// # Errors
    /// None in a released tool: a test reads all of them.
    pub fn scenario(&self) -> Result<Scenario, ScenarioError> {
        Scenario::parse(&format!("scenarios/{}.toml", self.name), self.text)
    }
}

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// When it cannot be read or is no scenario; says where and what.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let text = fs::read_to_string(path).map_err(|source| ScenarioError::Read { path: path.to_owned(), source })?;
        let scenario = Self::parse(&path.display().to_string(), &text)?;
        Ok(Self { folder: Some(path.parent().unwrap_or(Path::new("")).to_owned()), ..scenario })
    }

    /// Reads the text of a scenario file; `file` is its name in messages.
    ///
    /// # Errors
    /// When it is no scenario; says where and what.
    pub fn parse(file: &str, text: &str) -> Result<Self, ScenarioError> {
        file::parse(file, text)
    }

    /// Runs another controller in the place of the one it names.
    ///
    /// # Errors
    /// When it names none.
    pub fn with_controller(mut self, controller: &Controller) -> Result<Self, ScenarioError> {
        let is_controller = |file: &&mut PathBuf| {
            CONTROLLERS.iter().any(|known| file.file_name().is_some_and(|name| name == known.fmu))
        };
        let Some(replaced) = self.fmus.iter_mut().find(is_controller) else {
            let mut known: Vec<_> = CONTROLLERS.iter().map(|known| known.fmu).collect();
            known.dedup();
            return Err(ScenarioError::NoController { known });
        };
        replaced.set_file_name(controller.fmu);
        self.title = format!("{} ({})", self.title, controller.title);
        self.settings.splice(0..0, controller.settings().map(Located::nowhere));
        Ok(self)
    }

    /// Opens its FMUs: each where the file says, relative to the file's folder, or else in the folder `fmus`.
    ///
    /// # Errors
    /// When one is not there or cannot be used.
    pub fn system(&self, fmus: &Path) -> Result<System, ScenarioError> {
        let folders: Vec<&Path> = self.folder.as_deref().into_iter().chain([fmus]).collect();
        let find = |file: &PathBuf| {
            let found = folders.iter().map(|folder| folder.join(file)).find(|path| path.exists());
            found.ok_or_else(|| ScenarioError::NoFmu {
                file: file.display().to_string(),
                searched: folders.iter().map(|folder| shown(folder)).collect(),
            })
        };
        let paths = self.fmus.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        let opened = paths.iter().map(Fmu::open).collect::<Result<Vec<_>, _>>()?;
        let system = System::of_fmus(&opened);
        self.check_tables(&system)?;
        Ok(System {
            title: Some(self.title.clone()),
            settings: [&self.settings[..], &self.held].concat(),
            inputs: self.inputs.clone(),
            experiment: self.experiment,
            ..system
        })
    }

    /// What stands under `[parameters]` are no inputs, and what stands under `[inputs]` are.
    fn check_tables(&self, system: &System) -> Result<(), ScenarioError> {
        for (table, other, settings) in [("parameters", "inputs", &self.settings), ("inputs", "parameters", &self.held)]
        {
            for Located { item, place } in settings {
                let mut meant = system.variables(&item.target).peekable();
                // A name nobody has is reported with suggestions when it is applied.
                let is_known = meant.peek().is_some();
                let belongs = |variable: &Variable| (variable.causality == Causality::Input) == (table == "inputs");
                if is_known && !meant.any(belongs) {
                    return Err(ScenarioError::Table {
                        place: place.clone().unwrap_or_default(),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_folder_is_built_in_and_says_what_it_is() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
        let mut files: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
            .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
            .collect();
        let mut names: Vec<_> = BUILT_IN.iter().map(|built_in| built_in.name).collect();
        files.sort();
        names.sort_unstable();
        assert_eq!(files, names);
        for built_in in BUILT_IN {
            let scenario = built_in.scenario().unwrap();
            assert!(scenario.title.chars().count() <= 60, "{}: one line", built_in.name);
            assert!(scenario.description.len() > 80, "{}: says what it shows", built_in.name);
        }
    }

    #[test]
    fn every_controller_has_the_papers_case() {
        for controller in CONTROLLERS {
            let scenario = BuiltIn::find(controller.key).unwrap().scenario().unwrap();
            assert_eq!(scenario.fmus, [Path::new(crate::grasp::PLANT), Path::new(controller.fmu)]);
            let settings: Vec<_> = scenario.settings.iter().map(|setting| setting.item.clone()).collect();
            assert_eq!(settings, controller.settings().collect::<Vec<_>>());
        }
    }

    #[test]
    fn unknown_names_are_answered_with_known_ones() {
        let message = BuiltIn::find("pre-load").unwrap_err().to_string();
        assert!(message.contains("no scenario \"pre-load\"; did you mean preload?"), "{message}");
    }

    #[test]
    fn another_controller_takes_the_place_of_the_first() {
        let scenario = BuiltIn::find("preload").unwrap().scenario().unwrap();
        let fast = scenario.clone().with_controller(&crate::grasp::NABFC_FAST).unwrap();
        assert_eq!(fast.fmus[1], Path::new("NabfcController.fmu"));
        assert_eq!(fast.settings[0].item, Setting::new("preset", "fast"));
        assert_eq!(fast.settings[1..], scenario.settings[..]);
        let alone = Scenario { fmus: vec!["DualArmPlant.fmu".into()], ..scenario };
        let message = alone.with_controller(&crate::grasp::PD).unwrap_err().to_string();
        assert_eq!(
            message,
            "--controller: this scenario runs none of NabfcController.fmu, PdsController.fmu, PdController.fmu"
        );
    }
}
