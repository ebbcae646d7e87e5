//! `dualarm compare`, the main job.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::fmus::Job;
use super::instruments::InstrumentsChoice;
use super::json::{self, ExperimentDocument, MetricsDocument};
use super::matrix::{self, MatrixChoice};
use super::progress::Progress;
use super::simulate::{CouplingName, grid};
use super::{Failure, numbers, print, width};
use crate::comparison::{self, CSV_INTERVAL, ComparisonError, Runs, Setup, Wanted};
use crate::grasp::matrix::{Lab, Matrices};
use crate::report;
use crate::report::figures::PaperRun;
use crate::report::matrix::CellDocument;
use fmi2_cosim::files::FileSet;

/// Arguments of `dualarm compare`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    job: Job,
    #[command(flatten)]
    instruments: InstrumentsChoice,
    /// How signals are exchanged
    #[arg(long, value_enum, default_value_t)]
    coupling: CouplingName,
    /// Communication step size in s
    #[arg(long, default_value_t = STEP, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    step: f64,
    /// Stop time in s
    #[arg(long, default_value_t = STOP, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    stop: f64,
    #[command(flatten)]
    matrix: MatrixChoice,
    /// Also write the figures without titles, as SVG and PDF, to figures/untitled: for papers, whose captions say what they show
    #[arg(long)]
    untitled: bool,
    /// Write the page to this file (.html); missing folders are created [default: report.html in the folder for the results]
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// The document of `--json`; `docs/tool.md` describes the keys.
#[derive(Serialize)]
struct Document<'a> {
    command: &'static str,
    version: &'static str,
    experiment: ExperimentDocument,
    /// In s.
    wall_time: f64,
    cases: Vec<Case>,
    /// Controllers in many cases; empty without them.
    matrix: Vec<CellDocument<'a>>,
    /// The same of grasps that can open.
    contact: Vec<CellDocument<'a>>,
    report: &'a Path,
}

#[derive(Serialize)]
struct Case {
    name: &'static str,
    title: &'static str,
    metrics: MetricsDocument,
    data: PathBuf,
}

const STEP: f64 = 1e-4;
/// Twice the time PD needs to settle.
const STOP: f64 = 8.0;

impl Default for Arguments {
    fn default() -> Self {
        Self {
            job: Job::default(),
            instruments: InstrumentsChoice::default(),
            coupling: CouplingName::default(),
            step: STEP,
            stop: STOP,
            matrix: MatrixChoice::default(),
            untitled: false,
            report: None,
            json: false,
        }
    }
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    let grid = grid(0.0, arguments.stop, arguments.step)?;
    if let Some(page) = &arguments.report {
        super::report::check(page, &[])?;
    }
    let setup = Setup {
        fmus: &arguments.job.folder.fmus,
        out: &arguments.job.out,
        grid: &grid,
        coupling: arguments.coupling.into(),
        instruments: arguments.instruments.profiles(),
    };
    let chosen = arguments.matrix.chosen()?;
    arguments.job.package(quiet)?;
    let begin = Instant::now();
    let progress = Progress::new(quiet);
    // If a comparison is interrupted, the previous results stay complete.
    let results = FileSet::new();
    let lab = Lab::new(setup.fmus);
    if let Some(chosen) = &chosen {
        chosen.check(&lab)?;
    }
    let mut runs =
        if arguments.matrix.is_alone() { None } else { Some(Runs::simulate(&setup, &lab, &results, &progress)?) };
    let matrix = chosen.map(|chosen| chosen.run(&lab, quiet)).transpose()?;
    if let Some(matrix) = &matrix {
        comparison::files::write_matrices(matrix, setup.out, &results)?;
    }
    let wanted = Wanted { page: arguments.report.clone(), untitled: arguments.untitled };
    let report = match (&mut runs, &matrix, &wanted.page) {
        (Some(runs), matrix, _) => runs.write(&setup, matrix.as_ref(), &wanted, &results, &progress)?,
        (None, Some(matrix), Some(page)) => {
            results.write(page, comparison::page::of_matrix(matrix).to_html())?;
            page.clone()
        }
        _ => setup.out.join("matrix.md"),
    };
    results.appear()?;
    let figures = runs.as_ref().map_or(0, |runs| runs.figures.len());
    let runs = runs.map(Runs::finish).transpose()?.unwrap_or_default();
    let seconds = begin.elapsed().as_secs_f64();
    if arguments.json {
        print_json(&setup, &runs, matrix.as_ref(), &report, seconds)?;
    } else if !quiet {
        print_tables(arguments, &runs, matrix.as_ref(), figures, seconds);
    }
    matrix.as_ref().map_or(Ok(()), matrix::complete)
}

fn print_json(
    setup: &Setup,
    runs: &[PaperRun],
    matrix: Option<&Matrices>,
    report: &Path,
    wall_time: f64,
) -> Result<(), Failure> {
    let case = |PaperRun { scenario, metrics, .. }: &PaperRun| Case {
        name: scenario.key,
        title: scenario.title,
        metrics: metrics.into(),
        data: setup.out.join(format!("{}.csv", scenario.key)),
    };
    json::print(&Document {
        command: "compare",
        version: env!("CARGO_PKG_VERSION"),
        experiment: ExperimentDocument::new(setup.grid, setup.coupling, CSV_INTERVAL),
        wall_time,
        cases: runs.iter().map(case).collect(),
        matrix: matrix.map(|matrix| report::matrix::documents(&matrix.closed)).unwrap_or_default(),
        contact: matrix.and_then(|matrix| matrix.contact.as_ref()).map(report::matrix::documents).unwrap_or_default(),
        report,
    })
}

fn print_tables(arguments: &Arguments, runs: &[PaperRun], matrix: Option<&Matrices>, figures: usize, seconds: f64) {
    let out = arguments.job.out.display();
    if let Some(matrix) = matrix {
        for matrix in [Some(&matrix.closed), matrix.contact.as_ref()].into_iter().flatten() {
            print(&format!("{}\n", report::matrix::table(matrix).to_terminal(width())));
            for (title, meaning, table) in report::matrix::contact::tables(matrix) {
                print(&format!("{title}: {meaning}\n{}\n", table.to_terminal(width())));
            }
        }
    }
    if runs.is_empty() {
        let contact = matrix.and_then(|matrix| matrix.contact.as_ref()).map_or("", |_| ", contact.* likewise");
        print(&format!("{out}/matrix.md, .csv, .json, .svg and .png{contact}, in {seconds:.1} s\n"));
        return;
    }
    let (forces, efforts) = report::tables(runs);
    print(&format!(
        "{}\n{}\n{out}/report.html to play with, {out}/report.md with {figures} figures, in {seconds:.1} s\n",
        forces.to_terminal(width()),
        efforts.to_terminal(width()),
    ));
}

impl comparison::Progress for Progress {
    fn begins(&self, title: &str, length: u64) -> Box<dyn Fn(u64) + Send + Sync> {
        let bar = self.bar(title, length);
        Box::new(move |done| {
            bar.set_position(done);
            if done == length {
                bar.finish();
            }
        })
    }
}

impl From<ComparisonError> for Failure {
    fn from(error: ComparisonError) -> Self {
        match error {
            ComparisonError::Unknown(error) => error.into(),
            ComparisonError::Scenario(error) => error.into(),
            ComparisonError::System(error) => error.into(),
            ComparisonError::Instruments(error) => error.into(),
            error => Self::failed(error),
        }
    }
}
