//! `dualarm simulate`

mod output;
mod source;

use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};

use super::fmus::FmuFolder;
use super::progress::Progress;
use super::{Failure, print};
use crate::fmi::{LogMessage, Status};
use crate::grasp::{self, CONTROLLERS};
use crate::grid::TimeGrid;
use crate::master::{Coupling, Master, MasterError};
use crate::metrics::{self, Metrics};
use crate::record::{Every, Pick, Table};
use crate::report;
use crate::scenario::BUILT_IN;
use crate::settings::Setting;
use crate::system::System;
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
  dualarm simulate --set DualArmPlant.EI1=0.12   only in the plant: the controller
                                                 does not know
  dualarm simulate a.fmu b.fmu --stop 2 -o -     any FMUs; rows to standard output";

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
    /// Write all outputs as CSV to this file (- for standard output); missing folders are created
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Time in s between two rows of the output; 0 for every step [default: 1e-3]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    interval: Option<f64>,
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
    let system = source::system(&arguments.what, arguments.controller.as_deref(), &arguments.folder.fmus)?;
    let grid = grid(&arguments, &system)?;
    let interval = interval(&arguments, &system)?;
    let coupling = arguments.coupling.map(Coupling::from).or(system.experiment.coupling).unwrap_or_default();
    let mut master = system.master(coupling)?;
    for setting in &arguments.settings {
        master.apply(setting).map_err(Failure::usage)?;
    }
    let columns = master.record(|_| true);
    // Before the simulation: an unwritable place should not cost the time of a run.
    let mut output = Every::new(interval, grid.stop(), Output::new(arguments.output, &columns)?);
    let mut measured = Pick::new(&columns, |name| metrics::SIGNALS.contains(&name));
    // Metrics are made of every step, however few of them are written.
    let measures = measured.sink.columns().len() == metrics::SIGNALS.len();
    let recorded = if measures { 0.0 } else { interval };

    master.initialize(&grid)?;
    let mut warnings = system.remarks.clone();
    warnings.extend_from_slice(master.warnings());
    warnings.extend(grid_remark(&grid, interval));
    warnings.extend(unconnected(&master));
    let limits = grasp::actuator_limits(master.instance(0));
    let bar = Progress::new(quiet).bar("simulating", grid.steps());
    let begin = Instant::now();
    let result = master.run(&grid, recorded, &mut (&mut output, &mut measured), &mut |done| bar.set_position(done));
    let duration = begin.elapsed();
    bar.finish_and_clear();
    let output = output.sink;
    match result {
        Ok(()) => {}
        // A reader that has seen enough (`| head`) is no failure.
        Err(MasterError::Record(error)) if output.is_pipe() && error.kind() == io::ErrorKind::BrokenPipe => {
            return Ok(());
        }
        Err(MasterError::Record(error)) => return Err(output.failure(error)),
        Err(error) => return Err(error.into()),
    }
    let summary =
        if quiet { String::new() } else { summary(&system, &master, &grid, duration, &measured.sink, limits) };
    let log = master.finish()?;
    let to_stdout = !output.is_pipe();
    output.finish()?;
    if !quiet {
        if to_stdout {
            print(&summary);
        } else {
            eprint!("{summary}");
        }
        warn(&warnings, &log);
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

fn grid(arguments: &Arguments, system: &System) -> Result<TimeGrid, Failure> {
    let wanted = system.experiment;
    let suggested = system.components.first().map(|(_, fmu)| fmu.description().default_experiment).unwrap_or_default();
    let start = arguments.start.or(wanted.start).or(suggested.start_time).unwrap_or(0.0);
    let stop = arguments.stop.or(wanted.stop).or(suggested.stop_time).unwrap_or(start + 5.0);
    let step = arguments.step.or(wanted.step).or(suggested.step_size).unwrap_or(1e-4);
    let grid = TimeGrid::new(start, stop, step).map_err(Failure::usage)?;
    if step > (stop - start) * (1.0 + 1e-9) {
        return Err(Failure::usage(format!("a step of {step} s is longer than the run from {start} s to {stop} s")));
    }
    Ok(grid)
}

fn interval(arguments: &Arguments, system: &System) -> Result<f64, Failure> {
    let interval = arguments.interval.or(system.experiment.interval).unwrap_or(1e-3);
    if interval >= 0.0 && interval.is_finite() {
        Ok(interval)
    } else {
        Err(Failure::usage(format!("the interval must be 0 or more seconds, not {interval}")))
    }
}

/// Rows are taken at communication points only.
fn grid_remark(grid: &TimeGrid, interval: f64) -> Option<String> {
    let steps = interval / grid.step();
    let is_multiple = (steps - steps.round()).abs() <= 1e-6 * steps.max(1.0);
    // An interval shorter than the step means every step, and nobody misses anything.
    (steps > 1.0 && !is_multiple).then(|| {
        format!(
            "the interval of {interval} s is no multiple of the step of {} s: rows come at the first communication point \
             after each multiple, not equally spaced",
            grid.step()
        )
    })
}

/// FMUs that were given together but have nothing to say to each other.
fn unconnected(master: &Master) -> Vec<String> {
    let names: Vec<_> = master.names().collect();
    let is_alone =
        |&index: &usize| !master.wires().iter().any(|wire| wire.from.component == index || wire.to.component == index);
    if names.len() < 2 {
        return Vec::new();
    }
    let alone = (0..names.len()).filter(is_alone);
    alone
        .map(|index| format!("{} shares no signal with the other FMUs: no output has an input's name", names[index]))
        .collect()
}

fn summary(
    system: &System,
    master: &Master,
    grid: &TimeGrid,
    duration: Duration,
    measured: &Table,
    limits: [Option<metrics::Limits>; 3],
) -> String {
    let names: Vec<_> = master.names().collect();
    let steps = grid.steps();
    let title = system.title.as_ref().map(|title| format!("{title}\n")).unwrap_or_default();
    let mut text = format!(
        "{title}{}: {} signals connected, {steps} steps of {} s up to t = {} s in {:.2} s ({:.2} µs per step)\n",
        names.join(" + "),
        master.wires().len(),
        grid.step(),
        grid.stop(),
        duration.as_secs_f64(),
        1e6 * duration.as_secs_f64() / steps as f64
    );
    if let Some(metrics) = Metrics::of(measured, limits) {
        let controller = names.last().copied().unwrap_or_default();
        let mut forces = report::force_table([(controller, &metrics, "")]);
        forces.header.pop();
        forces.rows.iter_mut().for_each(|row| drop(row.pop()));
        let efforts = report::effort_table([(controller, &metrics)]);
        text = [text, forces.to_terminal(), efforts.to_terminal()].join("\n");
    }
    text
}

/// Prints the run's warnings and what the FMUs warned about, each warning once.
fn warn(warnings: &[String], log: &[(String, LogMessage)]) {
    const SHOWN: usize = 5;
    let mut lines = warnings.to_vec();
    for (component, message) in log.iter().filter(|(_, message)| message.status != Status::Ok) {
        let line = format!("{component}: {}", message.text.trim());
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    for line in lines.iter().take(SHOWN) {
        eprintln!("warning: {line}");
    }
    if lines.len() > SHOWN {
        eprintln!("warning: … and {} more", lines.len() - SHOWN);
    }
}
