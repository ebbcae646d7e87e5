//! `dualarm simulate`

mod controller;
mod experiment;
mod monitor;
mod outcome;
mod output;
mod page;
mod source;

use std::path::PathBuf;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::fmus::FmuFolder;
use super::instruments::InstrumentsChoice;
use super::process::{self, TIME_TO_END};
use super::progress::Progress;
use super::{Failure, json, numbers, print, print_error, report};
use crate::grasp;
use crate::grasp::scenarios::BUILT_IN;
use crate::report::html::rows::Rows;
use controller::ControllerName;
pub use experiment::grid;
use fmi2_cosim::master::{Coupling, Master, MasterError, check_steps};
use fmi2_cosim::run::Run;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::system::{System, is_tolerance};
use monitor::{MonitorName, Watch};
use outcome::Outcome;
use output::Output;

const AFTER_HELP: &str = "\
What to run: a scenario's name (see --list), a scenario file (.toml), a system in one file (.ssp; a variant in it as \
FILE.ssp#VARIANT.ssd), or FMUs (.fmu). FMUs run in the order given, each \
input connected to the output of the same name of another FMU. What the options leave open, the scenario says, or else \
the first FMU's default experiment.

Examples:
  dualarm simulate                               the paper's NABFC case
  dualarm simulate --controller pd -o pd.csv     with another controller
  dualarm simulate -c results/tuned-pid.toml     with gains of `dualarm tune`
  dualarm simulate preload                       a scenario that is built in
  dualarm simulate my-grasp.toml -o out.csv      a scenario of your own
  dualarm simulate dist/DualArmGrasp-PD.ssp      a system in one file
  dualarm simulate friction --report page.html   a page with the arms in motion
  dualarm simulate --instruments noise,delay     noisy sensors, late commands
  dualarm simulate --set EI1=0.12                in every FMU that has EI1
  dualarm simulate --set DualArmPlant.EI1=0.12   in the plant only
  dualarm simulate a.fmu b.fmu --stop 2 -o -     any FMUs; rows to the terminal";

/// Arguments of `dualarm simulate`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scenario, SSP or FMUs [default: nabfc]
    #[arg(value_name = "SCENARIO|SSP|FMU")]
    what: Vec<PathBuf>,
    /// List the built-in scenarios
    #[arg(long, conflicts_with_all = ["what", "controller", "fmus", "coupling", "step", "start", "stop", "tolerance",
          "settings", "output", "report", "interval"])]
    list: bool,
    /// Run this controller, in a scenario instead of its own: a name, a preset or scenario (.toml) with its controller and gains,
    /// or a controller FMU (.fmu)
    #[arg(long, short, value_name = "NAME", value_parser = ControllerName)]
    controller: Option<String>,
    #[command(flatten)]
    instruments: InstrumentsChoice,
    #[command(flatten)]
    folder: FmuFolder,
    /// How signals are exchanged [default: gauss-seidel]
    #[arg(long, value_enum)]
    coupling: Option<CouplingName>,
    /// Communication step size in s
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    step: Option<f64>,
    /// Start time in s
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    start: Option<f64>,
    /// Stop time in s
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    stop: Option<f64>,
    /// Relative tolerance for FMUs that solve equations numerically [default: each FMU's own]
    #[arg(long, value_name = "NUMBER", value_parser = numbers::number, allow_hyphen_values = true)]
    tolerance: Option<f64>,
    /// Set a parameter or a free input before the start; repeatable
    #[arg(long = "set", value_name = "[COMPONENT.]NAME=VALUE", allow_hyphen_values = true)]
    settings: Vec<Setting>,
    /// Write all outputs to this file, as Parquet if it ends in .parquet, as CSV if in .csv (- for CSV
    /// on standard output); missing folders are created
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write a page with animation, curves, metrics and parameters to this file (.html); missing folders are
    /// created
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Time in s between two rows of the output; 0 for every step [default: 1e-3]
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    interval: Option<f64>,
    /// Follow functions of the controller's proof and say whether the bound holds; they are further columns of the output,
    /// with a figure beside it, and curves of the page
    #[arg(long, value_enum, value_name = "WHAT")]
    monitor: Option<MonitorName>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// [`Coupling`] as an argument.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CouplingName(Coupling);

impl ValueEnum for CouplingName {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: &[CouplingName] = &[CouplingName(Coupling::ALL[0]), CouplingName(Coupling::ALL[1])];
        ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.summary()))
    }
}

impl From<CouplingName> for Coupling {
    fn from(name: CouplingName) -> Self {
        name.0
    }
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    if arguments.list {
        return list(arguments.json);
    }
    let to_stdout = arguments.output.as_deref().is_some_and(output::is_standard_output);
    if arguments.json && to_stdout {
        return Err(Failure::usage("--json and -o - both want standard output"));
    }
    if let Some(tolerance) = arguments.tolerance.filter(|tolerance| !is_tolerance(*tolerance)) {
        return Err(Failure::usage(format!("the tolerance must be a positive number, not {tolerance}")));
    }
    Output::check(arguments.output.as_deref(), &[])?;
    let mut system = source::system(&arguments.what, arguments.controller.as_deref(), &arguments.folder.fmus)?;
    arguments.instruments.put_into(&mut system, &arguments.folder.fmus)?;
    system.experiment.tolerance = arguments.tolerance.or(system.experiment.tolerance);
    let inputs = source::inputs(&arguments.what, &system);
    Output::check(arguments.output.as_deref(), &inputs)?;
    if let Some(page) = &arguments.report {
        report::check(page, &inputs)?;
    }
    let run = experiment::run(arguments, &system)?;
    system.overrides.clone_from(&arguments.settings);
    let components = || system.components.iter().map(|(name, fmu)| (name.as_str(), fmu));
    check_steps(components().map(|(name, fmu)| (name, fmu.description())), &run.grid)?;
    // Their files are removed in the end, which is no matter of the FMUs. Thousands of names and texts are not: the memory of a process that
    // ends is given back as a whole.
    let files: Vec<_> = components().map(|(_, fmu)| fmu.files()).collect();
    components().for_each(|(_, fmu)| std::mem::forget(fmu.shared_description()));
    let mut master = system.master(run.coupling)?;
    let result = simulate(arguments, quiet, &system, &run, &mut master);

    // Everything is reported before this point: code of FMUs may fail, hang or exit from here on.
    let names: Vec<_> = components().map(|(name, _)| name).collect();
    let complaint = match &result {
        Ok(()) => format!("{} did not end within {TIME_TO_END:?}; the results are complete", names.join(" or ")),
        Err(failure) => failure.message.clone(),
    };
    let ended = process::within(TIME_TO_END, complaint, move || {
        let log = if result.is_ok() { master.finish() } else { Ok(Vec::new()) };
        drop(system);
        result.map(|()| log)
    });
    drop(files);
    let log = ended?.map_err(|error| Failure::failed(format!("{error}; the results are complete")))?;
    if !quiet {
        outcome::print_warnings(&outcome::complaints(&log));
    }
    Ok(())
}

/// Runs the system and shows the results.
fn simulate(
    arguments: &Arguments,
    quiet: bool,
    system: &System,
    run: &Run,
    master: &mut Master,
) -> Result<(), Failure> {
    let columns = master.record(|_| true);
    // Before the simulation: an unwritable place should not cost the time of a run.
    let watch = Watch::new(arguments.monitor, &columns, run)?;
    let output = Output::new(arguments.output.as_deref(), &watch.columns(&columns))?;
    let mut rows = watch.rows(output, &columns);
    let mut watch = page::Watch::new(watch, arguments.report.as_ref().map(|_| Rows::new(&run.grid, &columns)));
    let bar = Progress::new(quiet).bar("simulating", run.grid.steps());
    let result = run.execute(system, master, &columns, &mut rows, &mut watch, &mut |done| bar.set_position(done));
    bar.finish_and_clear();
    let (output, kept) = rows.parts();
    let results = match result {
        Err(MasterError::Record(error)) => return Err(output.failure(error)),
        result => result?,
    };
    let page::Watch { others: Watch { grasp: watch, lyapunov }, rows: shown, models } = watch;
    let (output, monitored) = monitor::complete(lyapunov, output, kept, arguments.output.as_deref())?;
    let (monitored, verdict) = monitored.unzip();
    let metrics = watch.metrics();
    let controller = grasp::controller(&system.components, master.wires()).map(str::to_owned);
    let to_stdout = output.is_pipe();
    let file = arguments.output.clone().filter(|_| !to_stdout);
    let mut outcome = Outcome::new(system, master, run, &columns, results, metrics.as_ref(), file);
    outcome.warn(&master.take_log());
    outcome.monitor.clone_from(&verdict);
    output.finish()?;
    if let (Some(path), Some(rows)) = (&arguments.report, shown) {
        let rows = page::with_columns(rows.into_table(), monitored.as_ref());
        let metrics = metrics.as_ref().ok();
        let controller = controller.as_deref();
        let page = page::Made { system, run, rows, metrics, models, master, controller, verdict: verdict.as_deref() };
        page.write(path)?;
        outcome.report = Some(path.clone());
    }
    if arguments.json {
        return outcome.print_json();
    }
    if !quiet {
        let summary = outcome.summary(controller.as_deref(), metrics.as_ref());
        if to_stdout {
            print_error(&summary);
        } else {
            print(&summary);
        }
        outcome::print_warnings(&outcome.warnings);
    }
    Ok(())
}

/// `--list`
fn list(as_json: bool) -> Result<(), Failure> {
    let scenarios = BUILT_IN.iter().map(|built_in| Ok((built_in.name, built_in.scenario()?)));
    let scenarios = scenarios.collect::<Result<Vec<_>, Failure>>()?;
    if as_json {
        let scenarios = scenarios.iter().map(|(name, scenario)| ListedScenario {
            name,
            title: &scenario.title,
            description: &scenario.description,
        });
        return json::print(&ListDocument {
            command: "simulate --list",
            version: env!("CARGO_PKG_VERSION"),
            scenarios: scenarios.collect(),
        });
    }
    let width = scenarios.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    for (name, scenario) in &scenarios {
        print(&format!("{name:<width$}  {}\n", scenario.title));
    }
    Ok(())
}

/// The document of `--list --json`; `docs/tool.md` describes the keys.
#[derive(Serialize)]
struct ListDocument<'a> {
    command: &'static str,
    version: &'static str,
    scenarios: Vec<ListedScenario<'a>>,
}

#[derive(Serialize)]
struct ListedScenario<'a> {
    name: &'a str,
    title: &'a str,
    description: &'a str,
}
