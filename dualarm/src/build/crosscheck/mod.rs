//! The usual release layout: each FMU alone with inputs, a reference solution, the options of that solution, and a README,
//! as the FMI cross-check rules 4.1 demand (section 9.1).
//!
//! ```text
//! fmus/2.0/cs/linux64/fmi2-export/1.0.0/DualArmPlant/
//!     DualArmPlant.fmu
//!     DualArmPlant_in.csv     inputs over time, to be interpolated linearly
//!     DualArmPlant_ref.csv    the solution: this tool's, with the step of the options
//!     DualArmPlant_ref.opt    start and stop time, step, tolerance
//!     README.md
//! ```

mod experiments;
mod readme;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

pub use experiments::{EXPERIMENTS, SoloExperiment, Source};
use fmi2_cosim::files::{FileSet, WriteError};
use fmi2_cosim::grid::{GridError, TimeGrid};
use fmi2_cosim::master::{Coupling, MasterError};
use fmi2_cosim::record::{CsvSink, Sink, Table};
use fmi2_cosim::signal::{Shape, Signal, SignalError};
use fmi2_cosim::system::{Located, System, SystemError};
use fmi2_import::{Causality, Fmu, FmuError, ModelDescription, VariableType};

/// Communication step in s. All FMUs are stable with it when they run alone.
const STEP: f64 = 1e-4;
/// Time in s between two rows of the files.
const INTERVAL: f64 = 1e-3;
/// The rules demand a relative tolerance; this is that of their example. Co-simulation with a fixed step does not use it.
const TOLERANCE: f64 = 1e-4;

/// Why there is no release.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReleaseError {
    /// An FMU cannot be used.
    #[error("{0}; `dualarm package` makes the FMUs")]
    Fmu(#[from] FmuError),
    /// An FMU cannot be instantiated or its values set.
    #[error(transparent)]
    System(#[from] SystemError),
    /// A simulation failed.
    #[error(transparent)]
    Master(#[from] MasterError),
    /// A signal makes no sense.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// A time makes no sense.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// An FMU lacks a variable of its experiment.
    #[error("{model} has no {what}")]
    Missing {
        /// The FMU.
        model: String,
        /// The missing variable.
        what: String,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Simulates every FMU of a folder alone and writes the layout below `out`; `progress` is called with the present activity.
/// Returns the folders of the FMUs.
///
/// # Errors
/// When an FMU is missing, its experiment does not fit it, or a file cannot be written.
pub fn release(fmus: &Path, out: &Path, progress: &mut dyn FnMut(&str)) -> Result<Vec<PathBuf>, ReleaseError> {
    let mut folders = Vec::new();
    for experiment in &EXPERIMENTS {
        progress(&format!("reference solution of {}", experiment.model));
        let file = fmus.join(format!("{}.fmu", experiment.model));
        let fmu = Fmu::open(&file)?;
        let inputs = complete(&inputs(experiment, fmus)?, fmu.description());
        let reference = simulate(&fmu, experiment, &inputs)?;
        folders.push(write(&fmu, &file, experiment, &inputs, &reference, out)?);
    }
    Ok(folders)
}

/// The experiment's inputs at the rows of the input file.
fn inputs(experiment: &SoloExperiment, fmus: &Path) -> Result<Table, ReleaseError> {
    match experiment.inputs {
        Source::Ramps(ramps) => {
            // Only where a line begins or ends: the rules interpolate linearly.
            let mut times: Vec<f64> = ramps.iter().flat_map(|(_, points)| points.iter().map(|point| point.0)).collect();
            times.sort_by(f64::total_cmp);
            times.dedup();
            let signals = ramps
                .iter()
                .map(|(_, points)| Signal::new(Shape::Linear, points.to_vec()))
                .collect::<Result<Vec<_>, _>>()?;
            let mut table = Table::new(ramps.iter().map(|(name, _)| column(name)).collect());
            for time in times {
                let values: Vec<_> = signals.iter().map(|signal| signal.at(time)).collect();
                keep(&mut table, time, &values);
            }
            Ok(table)
        }
        Source::ClosedLoop { plant, reference } => {
            let (plant, controller) = (
                Fmu::open(fmus.join(format!("{plant}.fmu")))?,
                Fmu::open(fmus.join(format!("{}.fmu", experiment.model)))?,
            );
            recorded(experiment, &plant, &controller, reference)
        }
    }
}

/// All real inputs of an FMU in the order of its description: the rules demand that the file matches it. Inputs that the
/// experiment does not use keep their start values.
fn complete(inputs: &Table, description: &ModelDescription) -> Table {
    let all = description.with_causality(Causality::Input).filter_map(|variable| match &variable.kind {
        VariableType::Real(real) => Some((variable.name.as_str(), real.start.unwrap_or_default())),
        _ => None,
    });
    let all: Vec<_> = all.map(|(name, start)| (name, inputs.column(name), start)).collect();
    let mut table = Table::new(all.iter().map(|(name, ..)| column(name)).collect());
    for (row, time) in inputs.times().iter().enumerate() {
        let values: Vec<_> = all.iter().map(|(_, values, start)| values.map_or(*start, |values| values[row])).collect();
        keep(&mut table, *time, &values);
    }
    table
}

/// The inputs of a controller while it controls the plant and one of its references changes.
fn recorded(
    experiment: &SoloExperiment,
    plant: &Fmu,
    controller: &Fmu,
    (name, points): (&str, &[(f64, f64)]),
) -> Result<Table, ReleaseError> {
    let signal = Signal::new(Shape::Linear, points.to_vec())?;
    let mut system = System::of_fmus(&[plant.clone(), controller.clone()]);
    system.inputs = vec![Located::nowhere((name.to_owned(), signal.clone()))];
    let mut master = system.master(Coupling::GaussSeidel)?;
    let wanted = |name: &str| controller.description().with_causality(Causality::Input).any(|v| v.name == name);
    let mut measured = Table::new(master.record(wanted));
    let grid = TimeGrid::new(0.0, experiment.stop, STEP)?;
    master.initialize(&grid)?;
    master.run(&grid, INTERVAL, &mut measured, &mut |_| ())?;

    let mut columns = measured.columns().to_vec();
    columns.push(column(name));
    let mut table = Table::new(columns);
    for (time, values) in measured.rows() {
        keep(&mut table, time, &[&values[..], &[signal.at(time)]].concat());
    }
    Ok(table)
}

/// The solution: outputs of the FMU alone, driven by these inputs.
fn simulate(fmu: &Fmu, experiment: &SoloExperiment, inputs: &Table) -> Result<Table, ReleaseError> {
    let missing = |what: String| ReleaseError::Missing { model: experiment.model.to_owned(), what };
    let mut system = System::of_fmus(std::slice::from_ref(fmu));
    for input in inputs.columns() {
        let values = inputs.column(&input.name).unwrap_or_default();
        let points = inputs.times().iter().copied().zip(values.iter().copied()).collect();
        system.inputs.push(Located::nowhere((input.name.clone(), Signal::new(Shape::Linear, points)?)));
    }
    let mut master = system.master(Coupling::GaussSeidel)?;
    let columns = master.record(|name| experiment.outputs.contains(&name));
    if let Some(output) = experiment.outputs.iter().find(|output| !columns.iter().any(|column| column.name == **output))
    {
        return Err(missing(format!("output {output}")));
    }
    let mut table = Table::new(columns);
    let grid = TimeGrid::new(0.0, experiment.stop, STEP)?;
    master.initialize(&grid)?;
    master.run(&grid, INTERVAL, &mut table, &mut |_| ())?;
    master.finish()?;
    Ok(table)
}

fn column(name: &str) -> fmi2_cosim::record::Column {
    fmi2_cosim::record::Column { name: name.to_owned(), ..fmi2_cosim::record::Column::default() }
}

fn keep(table: &mut Table, time: f64, values: &[f64]) {
    // Memory takes every row.
    let _ = table.row(time, values);
}

fn write(
    fmu: &Fmu,
    file: &Path,
    experiment: &SoloExperiment,
    inputs: &Table,
    reference: &Table,
    out: &Path,
) -> Result<PathBuf, ReleaseError> {
    let description = fmu.description();
    // "name version", as generationTool has it.
    let tool = description.generation_tool.as_deref().unwrap_or("unknown");
    let (tool, version) = tool.rsplit_once(' ').unwrap_or((tool, "unknown"));
    let model = experiment.model;
    let folder = out.join("fmus").join(&description.fmi_version).join("cs").join(fmi2_import::platform());
    let folder = folder.join(tool).join(version).join(model);
    let bytes = std::fs::read(file).map_err(|source| FmuError::Read { path: file.to_owned(), source })?;
    let written = FileSet::new();
    written.write(folder.join(format!("{model}.fmu")), bytes)?;
    written.write(folder.join(format!("{model}_in.csv")), csv(inputs))?;
    written.write(folder.join(format!("{model}_ref.csv")), csv(reference))?;
    written.write(folder.join(format!("{model}_ref.opt")), options(experiment))?;
    written.write(folder.join("README.md"), readme::text(description, experiment, inputs))?;
    written.appear()?;
    Ok(folder)
}

/// A table in the format of appendix B of the rules: quoted names, unquoted numbers, the time first.
fn csv(table: &Table) -> String {
    let names: Vec<_> = table.columns().iter().map(|column| format!(",\"{}\"", column.name)).collect();
    let mut text = format!("\"time\"{}\n", names.concat());
    let mut sink = CsvSink::to(Vec::new());
    for (time, values) in table.rows() {
        // Memory takes every row.
        let _ = sink.row(time, &values);
    }
    let rows = sink.into_inner().unwrap_or_default();
    text.push_str(&String::from_utf8_lossy(&rows));
    text
}

/// The options file. The validator of fmpy reads only numbers, so the optional `SolverType` is omitted.
fn options(experiment: &SoloExperiment) -> String {
    let mut text = String::new();
    for (name, value) in [
        ("StartTime", 0.0),
        ("StopTime", experiment.stop),
        ("StepSize", STEP),
        ("RelTol", TOLERANCE),
        ("OutputIntervalLength", INTERVAL),
    ] {
        let _ = writeln!(text, "{name}, {value:?}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_files_quote_names_only() {
        let mut table = Table::new(vec![column("a"), column("b[1]")]);
        keep(&mut table, 0.0, &[1.0, -2.5e-9]);
        keep(&mut table, 1e-3, &[0.1, 3.0]);
        assert_eq!(csv(&table), "\"time\",\"a\",\"b[1]\"\n0,1,-2.5e-9\n0.001,0.1,3\n");
    }

    #[test]
    fn options_have_what_the_rules_require() {
        let text = options(&EXPERIMENTS[0]);
        for required in ["StartTime, 0.0\n", "StopTime, ", "StepSize, 0.0001\n", "RelTol, 0.0001\n"] {
            assert!(text.contains(required), "{text}");
        }
    }
}
