//! The main command: the paper's runs, one with each of its three controllers, and the files made from them and from the
//! matrix.
//!
//! * [`Runs::simulate`] makes the runs;
//! * [`files`] are the tables, figures and data of the results' folder;
//! * [`page`] is `report.html`.

pub mod files;
pub mod page;
mod parallel;
mod run;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::grasp::instruments::{InstrumentsError, Profile};
use crate::grasp::matrix::{Lab, Matrices};
use crate::grasp::scenarios::UnknownScenario;
use crate::grasp::{self, PLANT};
use crate::report::figures::{self, Drawn, PaperRun};
use crate::report::html;
use charts::chart::Signals;
use fmi2_cosim::files::{FileSet, WriteError};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Coupling, Master, MasterError};
use fmi2_cosim::scenario::ScenarioError;
use fmi2_cosim::system::SystemError;
use fmi2_import::CallError;
use grasp_merit::metrics::MetricsObstacle;

/// Between two rows of a run's CSV file \[s\]. Metrics and figures use every step.
pub const CSV_INTERVAL: f64 = 1e-3;

/// How the runs are made.
#[derive(Debug, Clone)]
pub struct Setup<'a> {
    /// Folder of the FMUs.
    pub fmus: &'a Path,
    /// Folder of the results.
    pub out: &'a Path,
    /// Communication points.
    pub grid: &'a TimeGrid,
    /// How signals are exchanged.
    pub coupling: Coupling,
    /// The instruments and actuators between plant and controller; may be empty.
    pub instruments: Vec<&'static Profile>,
}

/// Receives the progress of the work.
pub trait Progress: Sync {
    /// An activity of this length begins; the returned function is called with the completed part.
    fn begins(&self, title: &str, length: u64) -> Box<dyn Fn(u64) + Send + Sync>;
}

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ComparisonError {
    /// A scenario is not there.
    #[error(transparent)]
    Unknown(#[from] UnknownScenario),
    /// A scenario cannot be read, or lacks an FMU.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Its FMUs make no system.
    #[error(transparent)]
    System(#[from] SystemError),
    /// Sensors and actuators do not fit.
    #[error(transparent)]
    Instruments(#[from] InstrumentsError),
    /// The co-simulation failed.
    #[error(transparent)]
    Master(#[from] MasterError),
    /// An FMU does not return its parameters.
    #[error(transparent)]
    Call(#[from] CallError),
    /// A run cannot be judged.
    #[error("{PLANT} with {controller}: {source}")]
    Metrics {
        /// File name of the controller.
        controller: &'static str,
        /// Why.
        source: MetricsObstacle,
    },
    /// A figure cannot be turned into pixels or PDF.
    #[error("cannot draw {name}: {reason}")]
    Draw {
        /// Which one.
        name: String,
        /// Why.
        reason: String,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// The paper's runs and their results.
pub struct Runs {
    /// In the order of [`grasp::PAPER`].
    pub runs: Vec<PaperRun>,
    /// All figures, once they are [written](Runs::write).
    pub figures: Vec<Drawn>,
    /// The rows of the page, by run.
    rows: Vec<html::Packed>,
    masters: Vec<Master>,
}

impl Runs {
    /// Runs the paper's three scenarios with the FMUs of the lab, each with separate instances, on all processors. Their data
    /// go to `results` at once.
    ///
    /// # Errors
    /// When an FMU is missing or refuses, or a file cannot be written.
    pub fn simulate(
        setup: &Setup,
        lab: &Lab,
        results: &FileSet,
        progress: &impl Progress,
    ) -> Result<Self, ComparisonError> {
        let bars = grasp::PAPER.map(|controller| progress.begins(controller.title, setup.grid.steps()));
        parallel::give_back_from_now_on();
        let made =
            parallel::each(bars.len(), |index| run::simulate(&grasp::PAPER[index], setup, lab, results, &bars[index]))?;
        // The rows of the page are packed.
        parallel::give_back();
        let (mut runs, mut rows, mut masters) = (Vec::new(), Vec::new(), Vec::new());
        let times = Arc::new(setup.grid.times());
        for made in made {
            let run::Made { scenario, drawn, metrics, models, rows: of_page, master } = made;
            let drawn = drawn.into_iter().map(|signal| (signal.column.name, signal.values, signal.last));
            runs.push(PaperRun { scenario, signals: Signals::new(Arc::clone(&times), drawn), metrics, models });
            rows.push(of_page);
            masters.push(master);
        }
        Ok(Self { runs, figures: Vec::new(), rows, masters })
    }

    /// Writes tables, figures and the page; they appear with the other `results`.
    ///
    /// # Errors
    /// When a figure cannot be drawn or a file cannot be written.
    pub fn write(
        &mut self,
        setup: &Setup,
        matrix: Option<&Matrices>,
        wanted: &Wanted,
        results: &FileSet,
        progress: &impl Progress,
    ) -> Result<PathBuf, ComparisonError> {
        let sentence = page::setup(setup);
        let sketches = figures::all(&self.runs);
        self.figures = files::draw_all(&setup.out.join("figures"), &sketches, wanted.untitled, results, progress)?;
        // The figures were the last to need every step.
        drop(sketches);
        self.runs.iter_mut().for_each(|run| run.signals = Signals::default());
        files::write(setup.out, self, &sentence, matrix, results)?;
        let rows = std::mem::take(&mut self.rows);
        let shown: Vec<html::Run> = self.runs.iter().zip(rows).map(|(run, rows)| page::shown(run, rows)).collect();
        let beside = wanted.page.is_none();
        let page = page::page(&shown, &self.figures, setup.grid, sentence, matrix, beside);
        let path = wanted.page.clone().unwrap_or_else(|| setup.out.join("report.html"));
        results.write(&path, page.to_html())?;
        Ok(path)
    }

    /// Ends the FMUs.
    ///
    /// # Errors
    /// When one of them refuses.
    pub fn finish(self) -> Result<Vec<PaperRun>, ComparisonError> {
        for master in self.masters {
            master.finish()?;
        }
        Ok(self.runs)
    }
}

/// The requested files besides the usual ones.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// The path of the page; by default `report.html` in the folder of the results.
    pub page: Option<PathBuf>,
    /// Also figures without titles.
    pub untitled: bool,
}
