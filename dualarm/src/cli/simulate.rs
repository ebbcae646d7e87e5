//! `dualarm simulate`

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};

use super::progress::Progress;
use super::{Failure, print};
use crate::files::NewFile;
use crate::fmi::{Fmu, LogMessage, Status};
use crate::grid::TimeGrid;
use crate::master::{Coupling, Master, MasterError};
use crate::metrics::{self, Metrics};
use crate::record::{Column, CsvSink, Pick, Sink, Table};
use crate::report;
use crate::scenario::{self, CONTROLLERS, STARTS, Scenario, Start};
use crate::settings::{Setting, SettingError};

const AFTER_HELP: &str = "\
FMUs run in the order given, each input connected to the output of the same name of another FMU. Without FMUs the plant \
and a controller are taken from the folder that `dualarm package` writes.

Examples:
  dualarm simulate --controller pd --stop 8 -o pd.csv
  dualarm simulate --scenario preload          no contact force becomes tensile
  dualarm simulate --set EI1=0.12              in every FMU that has EI1
  dualarm simulate --set DualArmPlant.EI1=0.12 only in the plant: the controller does not know
  dualarm simulate dist/DualArmPlant.fmu --stop 1 --interval 0 -o - | head";

/// Arguments of `dualarm simulate`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// FMUs to run together [default: plant and --controller from --fmus]
    #[arg(value_name = "FMU")]
    files: Vec<PathBuf>,
    /// Controller of the plant [default: nabfc]
    #[arg(long, short, value_name = "NAME", conflicts_with = "files",
          value_parser = PossibleValuesParser::new(CONTROLLERS.iter().map(|controller| controller.key)))]
    controller: Option<String>,
    /// Where the grasp starts from: at rest without contact force as in the paper, or with a small preload
    #[arg(long, value_name = "NAME", default_value = scenario::REST.key, conflicts_with = "files",
          value_parser = PossibleValuesParser::new(STARTS.iter().map(|start| start.key)))]
    scenario: String,
    /// Folder with the packaged FMUs
    #[arg(long, default_value = "dist", value_name = "FOLDER")]
    fmus: PathBuf,
    /// How signals are exchanged
    #[arg(long, value_enum, default_value_t)]
    coupling: CouplingName,
    /// Communication step size in s [default: what the first FMU suggests, or 1e-4]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    step: Option<f64>,
    /// Start time in s [default: what the first FMU suggests, or 0]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    start: Option<f64>,
    /// Stop time in s [default: what the first FMU suggests, or 5]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    stop: Option<f64>,
    /// Set a parameter or a free input before the start; repeatable
    #[arg(long = "set", value_name = "[COMPONENT.]NAME=VALUE", allow_hyphen_values = true)]
    settings: Vec<Setting>,
    /// Write all outputs as CSV to this file (- for standard output)
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Time in s between two recorded rows; 0 for every step
    #[arg(long, default_value_t = 1e-3, value_name = "SECONDS", allow_hyphen_values = true)]
    interval: f64,
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
    if !(arguments.interval >= 0.0 && arguments.interval.is_finite()) {
        return Err(Failure::usage(format!("the interval must be 0 or more seconds, not {}", arguments.interval)));
    }
    let (files, presets) = files_and_presets(&arguments)?;
    let fmus = files.iter().map(Fmu::open).collect::<Result<Vec<_>, _>>()?;
    let grid = grid(&arguments, &fmus[0])?;
    let mut master = Master::new(&fmus, arguments.coupling.into())?;
    for setting in presets.iter().chain(&arguments.settings) {
        master.apply(setting).map_err(setting_failure)?;
    }
    let columns = master.record(|_| true);
    // Before the simulation: an unwritable place should not cost the time of a run.
    let mut output = Output::new(arguments.output, &columns)?;
    let mut measured = Pick::new(&columns, |name| metrics::SIGNALS.contains(&name));

    master.initialize(&grid)?;
    let limits = scenario::actuator_limits(master.instance(0));
    let bar = Progress::new(quiet).bar("simulating", grid.steps());
    let begin = Instant::now();
    let result =
        master.run(&grid, arguments.interval, &mut (&mut output, &mut measured), &mut |done| bar.set_position(done));
    let duration = begin.elapsed();
    bar.finish_and_clear();
    match result {
        Ok(()) => {}
        // A reader that has seen enough (`| head`) is no failure.
        Err(MasterError::Record(error)) if output.is_pipe() && error.kind() == io::ErrorKind::BrokenPipe => {
            return Ok(());
        }
        Err(MasterError::Record(error)) => return Err(output.failure(error)),
        Err(error) => return Err(error.into()),
    }
    let summary = if quiet { String::new() } else { summary(&master, &grid, duration, &measured.sink, limits) };
    let log = master.finish()?;
    let to_stdout = !output.is_pipe();
    output.finish()?;
    if !quiet {
        if to_stdout {
            print(&summary);
        } else {
            eprint!("{summary}");
        }
        warn(&log);
    }
    Ok(())
}

/// The FMU files and the settings that come with a named controller.
fn files_and_presets(arguments: &Arguments) -> Result<(Vec<PathBuf>, Vec<Setting>), Failure> {
    if !arguments.files.is_empty() {
        return Ok((arguments.files.clone(), Vec::new()));
    }
    let key = arguments.controller.as_deref().unwrap_or(scenario::NABFC.key);
    let controller = Scenario::find(key).unwrap_or(&scenario::NABFC);
    let files: Vec<_> = [scenario::PLANT, controller.fmu].map(|file| arguments.fmus.join(file)).into();
    if let Some(missing) = files.iter().find(|file| !file.exists()) {
        return Err(Failure {
            code: 1,
            message: format!(
                "there is no {}; run `dualarm package` first, or say where with --fmus",
                missing.display()
            ),
        });
    }
    let start = Start::find(&arguments.scenario).unwrap_or(&scenario::REST);
    Ok((files, controller.settings().chain(start.settings()).collect()))
}

fn grid(arguments: &Arguments, first: &Fmu) -> Result<TimeGrid, Failure> {
    let suggested = first.description().default_experiment;
    let start = arguments.start.or(suggested.start_time).unwrap_or(0.0);
    let stop = arguments.stop.or(suggested.stop_time).unwrap_or(start + 5.0);
    let step = arguments.step.or(suggested.step_size).unwrap_or(1e-4);
    TimeGrid::new(start, stop, step).map_err(Failure::usage)
}

pub fn setting_failure(error: SettingError) -> Failure {
    if error.is_usage() { Failure::usage(error) } else { error.into() }
}

fn summary(
    master: &Master,
    grid: &TimeGrid,
    duration: Duration,
    measured: &Table,
    limits: [Option<metrics::Limits>; 3],
) -> String {
    let names: Vec<_> = master.names().collect();
    let steps = grid.steps();
    let mut text = format!(
        "{}: {} signals connected, {steps} steps of {} s up to t = {} s in {:.2} s ({:.2} µs per step)\n",
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

/// Prints what the FMUs warned about, each warning once.
pub fn warn(log: &[(String, LogMessage)]) {
    const SHOWN: usize = 5;
    let mut lines: Vec<String> = Vec::new();
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

/// Where the rows go.
enum Output {
    None,
    File(CsvSink<NewFile>),
    Pipe(CsvSink<io::BufWriter<io::Stdout>>),
}

impl Output {
    fn new(path: Option<PathBuf>, columns: &[Column]) -> Result<Self, Failure> {
        Ok(match path {
            None => Self::None,
            Some(path) if path.as_os_str() == "-" => {
                let mut sink = CsvSink::to(io::BufWriter::new(io::stdout()));
                sink.header(columns)?;
                Self::Pipe(sink)
            }
            Some(path) => Self::File(CsvSink::new(NewFile::create(path)?, columns)?),
        })
    }

    fn is_pipe(&self) -> bool {
        matches!(self, Self::Pipe(_))
    }

    fn failure(&self, error: io::Error) -> Failure {
        match self {
            Self::File(sink) => sink.error(error).into(),
            _ => error.into(),
        }
    }

    fn finish(self) -> Result<(), Failure> {
        match self {
            Self::None => {}
            Self::File(sink) => sink.finish()?,
            Self::Pipe(sink) => match sink.into_inner().and_then(|mut writer| writer.flush()) {
                Err(error) if error.kind() != io::ErrorKind::BrokenPipe => return Err(error.into()),
                _ => {}
            },
        }
        Ok(())
    }
}

impl Sink for Output {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        match self {
            Self::None => Ok(()),
            Self::File(sink) => sink.row(time, values),
            Self::Pipe(sink) => sink.row(time, values),
        }
    }
}
