//! `dualarm simulate`

mod experiment;
mod outcome;
mod output;
mod source;

use std::io;
use std::path::PathBuf;
use std::time::Instant;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};

use super::fmus::FmuFolder;
use super::progress::Progress;
use super::{Failure, print, print_error};
use crate::grasp::metrics::{self, Metrics};
use crate::grasp::scenarios::BUILT_IN;
use crate::grasp::{self, CONTROLLERS};
use experiment::Run;
pub use experiment::grid;
use fmi2_cosim::master::{Coupling, MasterError};
use fmi2_cosim::record::{Every, Last, Pick};
use fmi2_cosim::settings::Setting;
use outcome::{Findings, Outcome};
use output::Output;

const AFTER_HELP: &str = "\
What to run: a scenario's name (see --list), a scenario file (.toml), a system in one file (.ssp; a variant in it as \
FILE.ssp#VARIANT.ssd), or FMUs (.fmu). FMUs run in the order given, each \
input connected to the output of the same name of another FMU. What the options leave open, the scenario says, or else \
the first FMU's default experiment.

Examples:
  dualarm simulate                               the paper's NABFC case
  dualarm simulate --controller pd -o pd.csv     with another controller
  dualarm simulate preload                       a scenario that is built in
  dualarm simulate my-grasp.toml -o out.csv      a scenario of your own
  dualarm simulate dist/DualArmGrasp-PD.ssp      a system in one file
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
    #[arg(long, exclusive = true)]
    list: bool,
    /// Run this controller, in a scenario instead of its own
    #[arg(long, short, value_name = "NAME",
          value_parser = PossibleValuesParser::new(CONTROLLERS.iter().map(|controller| controller.key)))]
    controller: Option<String>,
    #[command(flatten)]
    folder: FmuFolder,
    /// How signals are exchanged [default: gauss-seidel]
    #[arg(long, value_enum)]
    coupling: Option<CouplingName>,
    /// Communication step size in s
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    step: Option<f64>,
    /// Start time in s
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    start: Option<f64>,
    /// Stop time in s
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    stop: Option<f64>,
    /// Set a parameter or a free input before the start; repeatable
    #[arg(long = "set", value_name = "[COMPONENT.]NAME=VALUE", allow_hyphen_values = true)]
    settings: Vec<Setting>,
    /// Write all outputs to this file, as Parquet if it ends in .parquet, else as CSV (- for CSV on
    /// standard output); missing folders are created
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Time in s between two rows of the output; 0 for every step [default: 1e-3]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    interval: Option<f64>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// [`Coupling`] by name.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum CouplingName {
    /// All exchange at once: every signal arrives one step late
    Jacobi,
    /// One after the other with the newest signals: a controller answers without delay
    #[default]
    GaussSeidel,
}

impl From<CouplingName> for Coupling {
    fn from(name: CouplingName) -> Self {
        match name {
            CouplingName::Jacobi => Self::Jacobi,
            CouplingName::GaussSeidel => Self::GaussSeidel,
        }
    }
}

pub fn run(arguments: Arguments, quiet: bool) -> Result<(), Failure> {
    if arguments.list {
        return list();
    }
    if arguments.json && arguments.output.as_ref().is_some_and(|path| path.as_os_str() == "-") {
        return Err(Failure::usage("--json and -o - both want standard output"));
    }
    let system = source::system(&arguments.what, arguments.controller.as_deref(), &arguments.folder.fmus)?;
    let run = Run::of(&arguments, &system)?;
    let mut master = system.master(run.coupling)?;
    for setting in &arguments.settings {
        master.apply(setting).map_err(Failure::usage)?;
    }
    let columns = master.record(|_| true);
    // Before the simulation: an unwritable place should not cost the time of a run.
    let output = Output::new(arguments.output.clone(), &columns)?;
    let mut rows = Every::new(run.interval, run.grid.stop(), output);
    let mut measured = Pick::new(&columns, |name| metrics::SIGNALS.contains(&name));
    let mut last = Last::default();
    // Metrics are made of every step, however few of them are written.
    let is_grasp = measured.sink.columns().iter().any(|column| column.name == metrics::CONTACT_FORCE);
    let recorded = if is_grasp { 0.0 } else { run.interval };

    master.initialize(&run.grid)?;
    let mut remarks = system.remarks.clone();
    remarks.extend(run.remarks(&master));
    let limits = (0..system.components.len()).map(|index| grasp::actuator_limits(master.instance(index)));
    let limits = limits.reduce(|limits, others| if limits == [None; 3] { others } else { limits });
    let bar = Progress::new(quiet).bar("simulating", run.grid.steps());
    let begin = Instant::now();
    let mut sinks = (&mut rows, (&mut measured, &mut last));
    let result = master.run(&run.grid, recorded, &mut sinks, &mut |done| bar.set_position(done));
    let duration = begin.elapsed();
    bar.finish_and_clear();
    let output = rows.sink;
    match result {
        Ok(()) => {}
        // A reader that has seen enough (`| head`) is no failure.
        Err(MasterError::Record(error)) if output.is_pipe() && error.kind() == io::ErrorKind::BrokenPipe => {
            return Ok(());
        }
        Err(MasterError::Record(error)) => return Err(output.failure(error)),
        Err(error) => return Err(error.into()),
    }
    let limits = limits.unwrap_or_default();
    let metrics = Metrics::of(&measured.sink, limits);
    remarks.extend(metrics::saturations(&measured.sink, limits));
    let controller = grasp::controller(&system.components, master.wires()).map(str::to_owned);
    let file = arguments.output.filter(|_| !output.is_pipe());
    let findings = Findings { duration, columns: &columns, last: &last.values, metrics: metrics.clone(), output: file };
    let mut outcome = Outcome::new(&system, &master, &run, findings);
    outcome.warn(remarks, &master.finish()?);
    let to_stdout = !output.is_pipe();
    output.finish()?;
    if arguments.json {
        return outcome.print_json();
    }
    if !quiet {
        let summary = outcome.summary(controller.as_deref(), metrics.as_ref());
        if to_stdout {
            print(&summary);
        } else {
            print_error(&summary);
        }
        outcome.print_warnings();
    }
    Ok(())
}

/// `--list`
fn list() -> Result<(), Failure> {
    let width = BUILT_IN.iter().map(|built_in| built_in.name.len()).max().unwrap_or(0);
    for built_in in BUILT_IN {
        print(&format!("{:<width$}  {}\n", built_in.name, built_in.scenario()?.title));
    }
    Ok(())
}
