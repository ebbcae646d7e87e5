//! The description of an SSP: its components, connections, values and experiment.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::cli::Failure;
use crate::cli::printable::one_line;
use fmi2_cosim::ssp::Package;
use fmi2_cosim::ssp::package::split_variant;
use fmi2_cosim::system::Connections;
use fmi2_cosim::wiring::Terminal;

use super::text::table;

/// The document of `--json`; `docs/tool.md` describes the keys.
#[derive(Serialize)]
pub struct Document {
    command: &'static str,
    version: &'static str,
    file: PathBuf,
    /// The system structure that was read.
    structure: String,
    title: Option<String>,
    components: Vec<Component>,
    connections: Vec<Connection>,
    /// Inputs that no connection leads to.
    open_inputs: Vec<String>,
    default_experiment: Experiment,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Component {
    name: String,
    model: String,
    /// `None` if the FMU has none.
    description: Option<String>,
}

#[derive(Serialize)]
struct Connection {
    from: String,
    to: String,
}

/// In s, but for the tolerance.
#[derive(Serialize)]
struct Experiment {
    start: Option<f64>,
    stop: Option<f64>,
    step: Option<f64>,
    tolerance: Option<f64>,
}

impl Document {
    /// Reads the documents and the FMUs' descriptions; no code of an FMU runs.
    pub fn of(file: &Path) -> Result<Self, Failure> {
        let (path, structure) = split_variant(file);
        let system = Package::open(file)?.system()?;
        let described = |(name, fmu): &(String, fmi2_import::Fmu)| Component {
            name: name.clone(),
            model: fmu.description().model_name.clone(),
            description: fmu.description().description.clone(),
        };
        let name = |Terminal { component, variable }: Terminal| {
            let (name, fmu) = &system.components[component];
            format!("{name}.{}", fmu.description().variables[variable].name)
        };
        let wires = match &system.connections {
            Connections::Explicit(wires) => wires.as_slice(),
            Connections::ByName => &[],
        };
        let mut open_inputs = Vec::new();
        for (component, (_, fmu)) in system.components.iter().enumerate() {
            for (variable, described) in fmu.description().variables.iter().enumerate() {
                let terminal = Terminal { component, variable };
                let is_input = described.causality == fmi2_import::Causality::Input;
                if is_input && !wires.iter().any(|wire| wire.to == terminal) {
                    open_inputs.push(name(terminal));
                }
            }
        }
        let experiment = system.experiment;
        Ok(Self {
            command: "info",
            version: env!("CARGO_PKG_VERSION"),
            file: path,
            structure,
            title: system.title.clone(),
            components: system.components.iter().map(described).collect(),
            connections: wires.iter().map(|it| Connection { from: name(it.from), to: name(it.to) }).collect(),
            open_inputs,
            default_experiment: Experiment {
                start: experiment.start,
                stop: experiment.stop,
                step: experiment.step,
                tolerance: experiment.tolerance,
            },
            warnings: system.remarks.clone(),
        })
    }

    /// For people.
    pub fn summary(&self, width: Option<usize>) -> String {
        let title = self.title.as_deref().unwrap_or("A system");
        let mut text = format!("{}\n{}, {}\n\nComponents\n", one_line(title), self.file.display(), self.structure);
        let rows = self.components.iter().map(|Component { name, model, description }| {
            vec![name.clone(), model.clone(), description.clone().unwrap_or_default()]
        });
        text += &table(&["name", "model", "description"], rows.collect(), width);
        text += "\nConnections\n";
        let rows = self.connections.iter().map(|Connection { from, to }| vec![from.clone(), to.clone()]);
        text += &table(&["from", "to"], rows.collect(), width);
        if !self.open_inputs.is_empty() {
            let rows = self.open_inputs.iter().map(|input| vec![input.clone()]);
            text += "\nInputs that nothing leads to\n";
            text += &table(&["name"], rows.collect(), width);
        }
        let Experiment { start, stop, step, .. } = self.default_experiment;
        let said = [("from", start), ("to", stop), ("step", step)];
        let said: Vec<_> = said.iter().filter_map(|(word, time)| Some(format!("{word} {} s", (*time)?))).collect();
        let said = if said.is_empty() { "as its first FMU says".into() } else { said.join(", ") };
        let _ = writeln!(text, "\nDefault run: {said}");
        for warning in &self.warnings {
            let _ = writeln!(text, "warning: {}", one_line(warning));
        }
        text
    }
}
