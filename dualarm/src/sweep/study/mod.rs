//! Study files: which system runs how often, what is drawn for each run, and what is looked at.
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

use fmi2_cosim::files::read_text;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::system::{Located, RunOptions, SourceLine};
pub use range::{Range, Varied};

/// A study as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// What it is, in a few words.
    pub title: String,
    /// What it shows.
    pub description: String,
    /// What is run.
    pub system: Source,
    /// The controllers that each draw is run with; none: the system as it is.
    pub entrants: Vec<Entrant>,
    /// How points are chosen.
    pub method: Method,
    /// How many points; `None` where the method says.
    pub draws: Option<u64>,
    /// Of all random numbers.
    pub seed: u64,
    /// The file with the points of [`Method::Table`].
    pub points: Option<PathBuf>,
    /// What the numbers of that file are.
    pub coordinates: Coordinates,
    /// How to run, where the study has its own mind.
    pub experiment: RunOptions,
    /// Values that all runs have in common.
    pub parameters: Vec<Located<Setting>>,
    /// What differs from draw to draw.
    pub vary: Vec<Varied>,
    /// Outputs whose last, smallest, largest, mean and rms value each run reports.
    pub outputs: Vec<String>,
    /// What a run has to reach to be a success.
    pub success: Vec<Bound>,
    /// The folder of its file; `None` if it was read from a text.
    pub folder: Option<PathBuf>,
}

/// What is run.
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
    /// What tables call it, instead of its own title.
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

/// What the numbers of a table of points are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// The parameters' values.
    #[default]
    Values,
    /// Numbers from 0 to 1, from one end of each range to the other.
    Unit,
}

/// What a figure of a run may be at most and must be at least.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// The figure's name.
    pub figure: String,
    /// At least.
    pub min: Option<f64>,
    /// At most.
    pub max: Option<f64>,
    /// Where it stands, for messages.
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
        /// What is wrong there.
        message: String,
    },
}

impl Study {
    /// Reads a study file.
    ///
    /// # Errors
    /// When it cannot be read or is no study; says where and what.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        let text = read_text(path).map_err(|source| StudyError::Read { path: path.to_owned(), source })?;
        let study = Self::parse(&path.display().to_string(), &text)?;
        Ok(Self { folder: Some(path.parent().unwrap_or(Path::new("")).to_owned()), ..study })
    }

    /// Reads the text of a study file; `file` is its name in messages.
    ///
    /// # Errors
    /// When it is no study; says where and what.
    pub fn parse(file: &str, text: &str) -> Result<Self, StudyError> {
        file::parse(file, text)
    }

    /// A path that the study names: relative to the folder of its file, if there is such a file, or else as written.
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
