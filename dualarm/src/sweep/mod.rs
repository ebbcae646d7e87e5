//! `dualarm sweep`: one system, many runs.
//!
//! ```text
//! study file ─ study ─┐
//! table ── points ────┴─ sample ── plan ──┬── bench: FMUs opened once, a run → a row
//!                                         │     ^
//!                                         │   pool: threads, or worker processes that can crash and hang
//!                                         v     v
//!                            table, summary ← journal: rows as they come
//! ```
//!
//! A [`plan`] defines each run, from the study alone. A [`bench`](mod@bench) holds the FMUs and makes the [`Row`] of a run.
//! A [`pool`] distributes runs to threads or worker processes. Rows arrive in any order, go to the [`journal`], and from
//! there in the order of runs to the [`table`], so the result does not depend on the number of workers or on interruptions.

pub mod bench;
pub mod figures;
pub mod journal;
pub mod plan;
pub mod points;
pub mod pool;
pub mod process;
pub mod sample;
pub mod study;
pub mod summary;
pub mod table;

use std::path::PathBuf;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::grasp::matrix::CellError;
use crate::grasp::matrix::contender::ContenderError;
use crate::grasp::scenarios::UnknownScenario;
use fmi2_cosim::files::WriteError;
use fmi2_cosim::scenario::ScenarioError;
use fmi2_cosim::ssp::SspError;
use fmi2_cosim::system::SystemError;
use fmi2_import::FmuError;

/// The status of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It went to its end.
    Ok,
    /// An FMU ended the simulation early; the figures are those of the completed part.
    Ended,
    /// An FMU refused something or failed.
    Failed,
    /// The process of the run ended: an FMU crashed or called `exit`.
    Crashed,
    /// The run was not done in time, and its process was ended.
    Timeout,
}

impl Status {
    /// As results have it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Ended => "ended",
            Self::Failed => "failed",
            Self::Crashed => "crashed",
            Self::Timeout => "timeout",
        }
    }
}

/// The result of a run. The [`plan`] has its input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The run.
    pub run: u64,
    /// Its status.
    pub status: Status,
    /// Why it is not `ok`.
    pub error: Option<String>,
    /// One value for each figure, `None` if it does not exist, such as the settling time of a run that never settles.
    pub figures: Vec<Option<Figure>>,
}

impl Row {
    /// A run without figures.
    #[must_use]
    pub fn without_figures(run: u64, status: Status, error: impl Into<String>) -> Self {
        Self { run, status, error: Some(error.into()), figures: Vec::new() }
    }

    /// A figure by its place; `None` if it does not exist.
    #[must_use]
    pub fn figure(&self, place: usize) -> Option<f64> {
        self.figures.get(place).copied().flatten().map(|figure| figure.0)
    }
}

/// A number that is written with the fewest digits that read back exactly: JSON has no NaN, and its readers round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure(pub f64);

impl Serialize for Figure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for Figure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map(Self).map_err(serde::de::Error::custom)
    }
}

/// Why a study ends early. A failure of a single run is the content of its row.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The study file is not valid.
    #[error(transparent)]
    Study(#[from] study::StudyError),
    /// The points cannot be had.
    #[error(transparent)]
    Sample(#[from] sample::SampleError),
    /// The points cannot be read.
    #[error(transparent)]
    Points(#[from] points::PointsError),
    /// There is no such system.
    #[error("system: {0}")]
    System(#[from] UnknownScenario),
    /// There is no such controller.
    #[error("controllers: {0}")]
    Contender(#[from] ContenderError),
    /// The scenario cannot be used.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The SSP cannot be used.
    #[error(transparent)]
    Ssp(#[from] SspError),
    /// An FMU cannot be used.
    #[error("{0}; `dualarm package` makes the project's FMUs, --fmus says where they are")]
    Fmu(#[from] FmuError),
    /// The controllers have no place in the system.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// A value cannot be set in any run.
    #[error("{}{source}", .controller.as_ref().map(|controller| format!("with {controller}: ")).unwrap_or_default())]
    Setting {
        /// In runs with this controller.
        controller: Option<String>,
        /// Why not.
        source: Box<SystemError>,
    },
    /// The system does not have the variables that the study names.
    #[error("{0}")]
    Usage(String),
    /// The journal belongs to another study.
    #[error(
        "{} belongs to another study: its {what} differs; delete it to begin anew, or name another one with --state",
        path.display()
    )]
    OtherStudy {
        /// The file.
        path: PathBuf,
        /// The difference.
        what: String,
    },
    /// The journal cannot be used.
    #[error("cannot use the state {}: {source}", path.display())]
    State {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A result cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Worker processes do not start.
    #[error("a worker process {0}")]
    Worker(String),
}

impl SweepError {
    /// Whether the request was wrong, as opposed to a failure during the work.
    #[must_use]
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Study(study::StudyError::Content { .. })
            | Self::Sample(_)
            | Self::System(_)
            | Self::Usage(_)
            | Self::Setting { .. } => true,
            Self::Scenario(error) | Self::Cell(CellError::Scenario(error)) => {
                matches!(error, ScenarioError::Content { .. } | ScenarioError::Table { .. })
            }
            Self::Contender(error) => matches!(error, ContenderError::Unknown { .. }),
            _ => false,
        }
    }
}
