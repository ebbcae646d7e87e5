//! `dualarm compare`, the main job.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use serde::Serialize;

use super::fmus::Job;
use super::instruments::InstrumentsChoice;
use super::json::{self, ExperimentDocument, MetricsDocument};
use super::matrix::{self, MatrixChoice};
use super::progress::Progress;
use super::simulate::{CouplingName, grid};
use super::{Failure, print, width};
use crate::grasp::matrix::Matrix;
use crate::grasp::metrics::Metrics;
use crate::grasp::scenarios::BuiltIn;
use crate::grasp::{self, Controller};
use crate::report;
use crate::report::figures::{self, NamedFigure, Outcome, pdf, raster};
use crate::report::html::{self, Page, rows, rows::Rows};
use crate::report::matrix::CellDocument;
use crate::report::parameters::ModelParameters;
use fmi2_cosim::files::{FileSet, NewFile};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Coupling, Master};
use fmi2_cosim::record::{Every, Pick, Table};
use fmi2_import::Fmu;

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
    #[arg(long, default_value_t = STEP, value_name = "SECONDS", allow_hyphen_values = true)]
    step: f64,
    /// Stop time in s
    #[arg(long, default_value_t = STOP, value_name = "SECONDS", allow_hyphen_values = true)]
    stop: f64,
    #[command(flatten)]
    matrix: MatrixChoice,
    /// Also write the figures without titles, as SVG and PDF, to figures/untitled: for papers, whose captions say what they show
    #[arg(long)]
    untitled: bool,
    /// Write the page to this file [default: report.html in the folder for the results]
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What `--json` prints; `docs/tool.md` describes the keys.
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
/// Between two rows of a CSV file, in s. Metrics and figures use every step.
const CSV_INTERVAL: f64 = 1e-3;

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
    arguments.job.package(quiet)?;
    let begin = Instant::now();
    // If a comparison is interrupted, the previous results stay complete.
    let results = FileSet::new();
    let runs = if arguments.matrix.is_alone() { Vec::new() } else { simulate_all(arguments, &grid, &results, quiet)? };
    let matrix = matrix::run(&arguments.matrix, &arguments.job.folder.fmus, quiet)?;
    if let Some(matrix) = &matrix {
        matrix::write(matrix, &arguments.job.out, &results)?;
    }
    if runs.is_empty() {
        return finish_alone(arguments, &grid, matrix.as_ref(), results, begin, quiet);
    }
    let (runs, masters): (Vec<_>, Vec<_>) =
        runs.into_iter().map(|(outcome, rows, master)| ((outcome, rows), master)).unzip();
    let (outcomes, rows): (Vec<_>, Vec<_>) = runs.into_iter().unzip();
    let figures = figures::all(&outcomes);
    write_results(arguments, &grid, &outcomes, &figures, matrix.as_ref(), &results, quiet)?;
    let report = arguments.report.clone().unwrap_or_else(|| arguments.job.out.join("report.html"));
    let runs: Vec<_> = outcomes.iter().zip(rows).map(|(outcome, rows)| shown(outcome, rows)).collect();
    let page = Page {
        title: "Grasping with two flexible arms".into(),
        lead: LEAD.into(),
        runs: &runs,
        setup: setup(arguments, &grid),
        rows: rows::sentence(&grid),
        matrix: matrix.as_ref(),
        figures: &figures,
        files: if arguments.report.is_none() { files(matrix.is_some()) } else { Vec::new() },
        ..Page::default()
    };
    results.write(&report, page.to_html())?;
    results.appear()?;
    for master in masters {
        master.finish()?;
    }
    let seconds = begin.elapsed().as_secs_f64();
    if arguments.json {
        let case = |Outcome { scenario, metrics, .. }: &Outcome| Case {
            name: scenario.key,
            title: scenario.title,
            metrics: metrics.into(),
            data: arguments.job.out.join(format!("{}.csv", scenario.key)),
        };
        return json::print(&Document {
            command: "compare",
            version: env!("CARGO_PKG_VERSION"),
            experiment: ExperimentDocument::new(&grid, arguments.coupling.into(), CSV_INTERVAL),
            wall_time: seconds,
            cases: outcomes.iter().map(case).collect(),
            matrix: matrix.as_ref().map(report::matrix::documents).unwrap_or_default(),
            report: &report,
        });
    }
    if !quiet {
        let (forces, efforts) = report::tables(&outcomes);
        let out = arguments.job.out.display();
        if let Some(matrix) = &matrix {
            print(&format!("{}\n", report::matrix::table(matrix).to_terminal(width())));
        }
        print(&format!(
            "{}\n{}\n{out}/report.html to play with, {out}/report.md with {} figures, in {seconds:.1} s\n",
            forces.to_terminal(width()),
            efforts.to_terminal(width()),
            figures.len()
        ));
    }
    Ok(())
}

/// What the page is about.
const LEAD: &str = "Two elastic arms squeeze an object between their tips, and no sensor measures the force. Three controllers try \
                    to hold it at its target: watch them, scrub through time, zoom into the first milliseconds.";

/// A result as the page shows it.
fn shown(outcome: &Outcome, rows: Table) -> html::Run {
    html::Run {
        key: outcome.scenario.key.into(),
        title: outcome.scenario.title.into(),
        paper: outcome.scenario.paper.into(),
        rows,
        metrics: Some(outcome.metrics.clone()),
        notes: Vec::new(),
        models: outcome.models.clone(),
    }
}

/// What lies beside the page.
fn files(has_matrix: bool) -> Vec<(String, String)> {
    let mut files = vec![("report.md", "the same as Markdown"), ("metrics.csv", "the metrics in all digits")];
    if has_matrix {
        files.extend([("matrix.md", "controllers and cases as a table"), ("matrix.csv", "every cell in all digits")]);
    }
    let data = grasp::PAPER.map(|controller| (format!("{}.csv", controller.key), "all outputs of that run".to_owned()));
    files.into_iter().map(|(file, what)| (file.to_owned(), what.to_owned())).chain(data).collect()
}

/// The end of a comparison without the paper's runs.
fn finish_alone(
    arguments: &Arguments,
    grid: &TimeGrid,
    matrix: Option<&Matrix>,
    results: FileSet,
    begin: Instant,
    quiet: bool,
) -> Result<(), Failure> {
    if let Some(path) = &arguments.report {
        let page = Page {
            title: "Controllers in many cases".into(),
            lead: "Each controller FMU with the plant in each case: who settles, and when.".into(),
            matrix,
            ..Page::default()
        };
        results.write(path, page.to_html())?;
    }
    results.appear()?;
    let seconds = begin.elapsed().as_secs_f64();
    let report = arguments.report.clone().unwrap_or_else(|| arguments.job.out.join("matrix.md"));
    if arguments.json {
        return json::print(&Document {
            command: "compare",
            version: env!("CARGO_PKG_VERSION"),
            experiment: ExperimentDocument::new(grid, arguments.coupling.into(), CSV_INTERVAL),
            wall_time: seconds,
            cases: Vec::new(),
            matrix: matrix.map(report::matrix::documents).unwrap_or_default(),
            report: &report,
        });
    }
    if let Some(matrix) = matrix.filter(|_| !quiet) {
        let table = report::matrix::table(matrix).to_terminal(width());
        let out = arguments.job.out.display();
        print(&format!("{table}\n{out}/matrix.md, .csv, .json, .svg and .png, in {seconds:.1} s\n"));
    }
    Ok(())
}

/// What came out of a run, the rows of the page, and what ran.
type Run = (Outcome, Table, Master);

/// Runs the scenarios, each in a thread of its own with its own instances.
fn simulate_all(arguments: &Arguments, grid: &TimeGrid, results: &FileSet, quiet: bool) -> Result<Vec<Run>, Failure> {
    let progress = Progress::new(quiet);
    let bars = grasp::PAPER.map(|controller| progress.bar(controller.title, grid.steps()));
    thread::scope(|scope| {
        let runs: Vec<_> = grasp::PAPER
            .iter()
            .zip(&bars)
            .map(|(controller, bar)| scope.spawn(move || simulate(controller, arguments, grid, results, bar)))
            .collect();
        runs.into_iter().map(|run| run.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    })
}

fn simulate(
    controller: &Controller,
    arguments: &Arguments,
    grid: &TimeGrid,
    results: &FileSet,
    bar: &ProgressBar,
) -> Result<Run, Failure> {
    let fmus = &arguments.job.folder.fmus;
    let mut system = BuiltIn::find(controller.key)?.scenario()?.system(fmus)?;
    arguments.instruments.put_into(&mut system, fmus)?;
    // Instruments and actuators come behind the component whose signals they take, so the plant stays the first.
    let controls = |(_, fmu): &(String, Fmu)| fmu.path().file_name().is_some_and(|name| name == controller.fmu);
    let place = system.components.iter().position(controls).unwrap_or(1);
    let mut master = system.master(arguments.coupling.into())?;
    master.initialize(grid)?;
    let limits = grasp::actuator_limits(master.instance(0));
    let models = [ModelParameters::of(master.instance(0))?, ModelParameters::of(master.instance(place))?].into();
    let columns = master.record(|_| true);
    // Every step of the signals that are drawn and judged; everything else only as often as the CSV file wants it.
    let mut drawn = Pick::new(&columns, |name| figures::SIGNALS.contains(&name));
    let mut shown = Rows::new(grid, &columns);
    let mut all = Every::new(CSV_INTERVAL, grid.stop(), Table::new(columns));
    master.run(grid, 0.0, &mut ((&mut drawn, &mut shown), &mut all), &mut |done| bar.set_position(done))?;
    bar.finish();

    let rows = NewFile::create(arguments.job.out.join(format!("{}.csv", controller.key)))?;
    results.add(all.sink.to_csv(rows)?)?;
    let metrics = Metrics::of(&drawn.sink, limits)
        .map_err(|obstacle| Failure::failed(format!("{} with {}: {obstacle}", grasp::PLANT, controller.fmu)))?;
    Ok((Outcome { scenario: *controller, table: drawn.sink, metrics, models }, shown.into_table(), master))
}

fn write_results(
    arguments: &Arguments,
    grid: &TimeGrid,
    outcomes: &[Outcome],
    figures: &[NamedFigure],
    matrix: Option<&Matrix>,
    results: &FileSet,
    quiet: bool,
) -> Result<(), Failure> {
    let out = &arguments.job.out;
    let metrics = outcomes.iter().map(|outcome| (outcome.scenario.title, &outcome.metrics));
    results.write(out.join("metrics.csv"), report::metrics_csv(metrics))?;
    results.write(out.join("metrics.md"), report::metrics_markdown(outcomes))?;
    draw_all(&out.join("figures"), figures, arguments.untitled, results, quiet)?;
    results.write(out.join("report.md"), report::report(outcomes, figures, &setup(arguments, grid), matrix))?;
    Ok(())
}

/// How the runs were made, in sentences.
fn setup(arguments: &Arguments, grid: &TimeGrid) -> String {
    let coupling = Coupling::from(arguments.coupling).title();
    format!(
        "DualArmPlant.fmu with each of the three controller FMUs, co-simulated by dualarm {} through their FMI 2.0 \
         interface: step {} ms, {coupling} coupling, {} s. Plant, PDS and PD have the parameters of the paper (Section IV); \
         the gains of NABFC are this project\u{2019}s own, for the paper gives none.{}",
        env!("CARGO_PKG_VERSION"),
        grid.step() * 1e3,
        grid.stop(),
        arguments.instruments.sentence()
    )
}

/// Draws all figures as SVG and PNG, on all processors.
fn draw_all(
    folder: &Path,
    figures: &[NamedFigure],
    untitled: bool,
    results: &FileSet,
    quiet: bool,
) -> Result<(), Failure> {
    let bar = Progress::new(quiet).bar("figures", figures.len() as u64);
    let next = AtomicUsize::new(0);
    let failure = Mutex::new(None);
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, NonZero::get) {
            scope.spawn(|| {
                while let Some(figure) = figures.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let Err(error) = draw(folder, figure, untitled, results) {
                        failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error);
                        return;
                    }
                    bar.inc(1);
                }
            });
        }
    });
    bar.finish_and_clear();
    failure.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).map_or(Ok(()), Err)
}

fn draw(folder: &Path, figure: &NamedFigure, untitled: bool, results: &FileSet) -> Result<(), Failure> {
    let failure = |reason| Failure::failed(format!("cannot draw {}: {reason}", figure.name));
    let svg = figure.figure.to_svg();
    let png = raster::to_png(&svg).map_err(failure)?;
    results.write(folder.join(format!("{}.svg", figure.name)), svg)?;
    results.write(folder.join(format!("{}.png", figure.name)), png)?;
    if untitled {
        let svg = figure.figure.to_untitled_svg();
        let pdf = pdf::to_pdf(&svg).map_err(failure)?;
        let folder = folder.join("untitled");
        results.write(folder.join(format!("{}.svg", figure.name)), svg)?;
        results.write(folder.join(format!("{}.pdf", figure.name)), pdf)?;
    }
    Ok(())
}
