//! Study files: the system, the number of runs, the values that are drawn for each run, and the recorded outputs.
//!
//! ```
//! use dualarm::sweep::study::Study;
//!
//! let study = Study::parse(
//!     "heavy.toml",
//!     r#"
//!     title = "Objects that nobody has weighed"
//!     system = "nabfc"
//!     controllers = ["nabfc-r", "pid"]
//!     method = "latin-hypercube"
//!     draws = 100
//!     [vary]
//!     M = { low = 0.1, high = 10, scale = "log" }                           # kg
//!     m = { mean = 0.1, sd = 0.02, low = 0.05, names = ["m1", "m2"] }       # kg
//!     [success]
//!     settling = 2                                                          # s at most
//!     "#,
//! )?;
//! assert_eq!((study.entrants.len(), study.vary.len()), (2, 2));
//! # Ok::<(), dualarm::sweep::study::StudyError>(())
//! ```
//!
//! The reference of all keys is `docs/studies.md`.

mod file;
mod range;

use std::io;
use std::path::{Path, PathBuf};

use crate::grasp::kind::Kind;
use fmi2_cosim::files::read_text;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::system::{Located, RunOptions, SourceLine};
pub use range::{Range, Varied};

/// A study as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// A short title.
    pub title: String,
    /// A description of its purpose.
    pub description: String,
    /// The system.
    pub system: Source,
    /// The controllers with which each draw is run; empty: the system unchanged.
    pub entrants: Vec<Entrant>,
    /// How points are chosen.
    pub method: Method,
    /// Number of points; `None` if the method determines it.
    pub draws: Option<u64>,
    /// Of all random numbers.
    pub seed: u64,
    /// The file with the points of [`Method::Table`].
    pub points: Option<PathBuf>,
    /// The kind of the numbers in that file.
    pub coordinates: Coordinates,
    /// How to run, where the study has its own mind.
    pub experiment: RunOptions,
    /// Values that all runs have in common.
    pub parameters: Vec<Located<Setting>>,
    /// The parameters that are drawn.
    pub vary: Vec<Varied>,
    /// Outputs whose last, smallest, largest, mean and rms value each run reports.
    pub outputs: Vec<String>,
    /// The conditions for the success of a run.
    pub success: Vec<Bound>,
    /// The folder of its file; `None` if it was read from a text.
    pub folder: Option<PathBuf>,
}

/// The system of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// A built-in scenario or case, a scenario file, or an SSP, as written.
    Named(String),
    /// FMUs, connected by equal names.
    Fmus(Vec<PathBuf>),
}

/// A controller that takes part.
#[derive(Debug, Clone, PartialEq)]
pub struct Entrant {
    /// As for `compare --controllers`: a name, a preset (.toml), or an FMU.
    pub name: String,
    /// Its title in tables, instead of its own.
    pub title: Option<String>,
    /// Communication step in s instead of the study's.
    pub step: Option<f64>,
    /// Values for runs with it.
    pub parameters: Vec<Located<Setting>>,
}

/// How points are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Every combination.
    Grid,
    /// As many strata per parameter as there are draws, each of them hit once.
    LatinHypercube,
    /// A scrambled Sobol sequence.
    Sobol,
    /// Independent random numbers.
    Random,
    /// The rows of a file.
    Table,
}

/// The kind of the numbers in a table of points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// The parameters' values.
    #[default]
    Values,
    /// Numbers from 0 to 1, from one end of each range to the other.
    Unit,
}

/// The smallest and the largest allowed value of a figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// The figure's name.
    pub figure: String,
    /// At least.
    pub min: Option<f64>,
    /// At most.
    pub max: Option<f64>,
    /// Its place, for messages.
    pub place: SourceLine,
}

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is no study.
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
}

impl Study {
    /// Reads a study file.
    ///
    /// # Errors
    /// When it cannot be read or is not a study; the error names the place and the fault.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        let text = read_text(path).map_err(|source| StudyError::Read { path: path.to_owned(), source })?;
        let study = Self::parse(&path.display().to_string(), &text).map_err(|error| match error {
            StudyError::Content { file, line, column, .. } if Kind::of(&text) == Some(Kind::Scenario) => {
                StudyError::Content { message: Kind::Scenario.remedy(&file), file, line, column }
            }
            other => other,
        })?;
        Ok(Self { folder: Some(path.parent().unwrap_or(Path::new("")).to_owned()), ..study })
    }

    /// Reads the text of a study file; `file` is its name in messages.
    ///
    /// # Errors
    /// When it is not a study; the error names the place and the fault.
    pub fn parse(file: &str, text: &str) -> Result<Self, StudyError> {
        file::parse(file, text)
    }

    /// A path in the study: relative to the folder of its file, if there is such a file, otherwise as written.
    #[must_use]
    pub fn path(&self, written: &Path) -> PathBuf {
        let beside = self.folder.as_ref().map(|folder| folder.join(written));
        beside.filter(|path| path.exists()).unwrap_or_else(|| written.to_owned())
    }

    /// How many runs each draw makes.
    #[must_use]
    pub fn runs_per_draw(&self) -> u64 {
        self.entrants.len().max(1) as u64
    }
}

impl Bound {
    /// Whether a figure is within it; one that is missing, such as a settling time of never, is not.
    #[must_use]
    pub fn holds(&self, figure: Option<f64>) -> bool {
        let Some(value) = figure else { return false };
        self.min.is_none_or(|min| value >= min) && self.max.is_none_or(|max| value <= max)
    }
}
