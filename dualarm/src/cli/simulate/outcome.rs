//! What a run led to, for people and for machines.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;
use serde_json::{Map, Value};

use super::experiment::Run;
use crate::cli::json::{self, ExperimentDocument, MetricsDocument};
use crate::cli::print_error;
use crate::grasp::metrics::{Metrics, MetricsObstacle};
use crate::report;
use fmi2_cosim::master::Master;
use fmi2_cosim::record::{Column, Kind};
use fmi2_cosim::system::System;
use fmi2_import::{LogMessage, Status};

/// What a run led to. Serialised, it is what `--json` prints; `docs/tool.md` describes the keys.
#[derive(Serialize)]
pub struct Outcome {
    command: &'static str,
    version: &'static str,
    title: Option<String>,
    components: Vec<Component>,
    connections: Vec<Connection>,
    experiment: ExperimentDocument,
    /// In s.
    wall_time: f64,
    /// The outputs at the stop time.
    #[serde(rename = "final")]
    last: Map<String, Value>,
    metrics: Option<MetricsDocument>,
    /// Why there are none.
    metrics_obstacle: Option<String>,
    output: Option<PathBuf>,
    /// What the tool and the FMUs warned about, each thing once.
    pub warnings: Vec<String>,
}

#[derive(Serialize)]
struct Component {
    name: String,
    model: String,
    fmu: PathBuf,
}

#[derive(Serialize)]
struct Connection {
    from: String,
    to: String,
}

/// What is only known after a run.
pub struct Findings<'a> {
    /// Wall time.
    pub duration: Duration,
    /// The recorded variables.
    pub columns: &'a [Column],
    /// Their values at the stop time.
    pub last: &'a [f64],
    /// If the run was a grasp, or else why there are none.
    pub metrics: Result<Metrics, MetricsObstacle>,
    /// The file with the rows.
    pub output: Option<PathBuf>,
}

impl Outcome {
    /// Gathers everything about a run but its warnings.
    pub fn new(system: &System, master: &Master, run: &Run, findings: Findings) -> Self {
        let component = |(name, fmu): &(String, fmi2_import::Fmu)| Component {
            name: name.clone(),
            model: fmu.description().model_name.clone(),
            fmu: fmu.path().to_owned(),
        };
        let terminal = |terminal: fmi2_cosim::wiring::Terminal| {
            let (name, fmu) = &system.components[terminal.component];
            format!("{name}.{}", fmu.description().variables[terminal.variable].name)
        };
        let connections = master.wires().iter();
        let value = |(column, value): (&Column, &f64)| (column.name.clone(), json_value(column.kind, *value));
        Self {
            command: "simulate",
            version: env!("CARGO_PKG_VERSION"),
            title: system.title.clone(),
            components: system.components.iter().map(component).collect(),
            connections: connections
                .map(|wire| Connection { from: terminal(wire.from), to: terminal(wire.to) })
                .collect(),
            experiment: ExperimentDocument::new(&run.grid, run.coupling, run.interval),
            wall_time: findings.duration.as_secs_f64(),
            last: findings.columns.iter().zip(findings.last).map(value).collect(),
            metrics: findings.metrics.as_ref().ok().map(MetricsDocument::from),
            metrics_obstacle: findings.metrics.err().map(|obstacle| obstacle.to_string()),
            output: findings.output,
            warnings: Vec::new(),
        }
    }

    /// Adds warnings: the tool's, and what the FMUs logged.
    pub fn warn(&mut self, remarks: Vec<String>, log: &[(String, LogMessage)]) {
        self.warnings = remarks;
        for (component, message) in log.iter().filter(|(_, message)| message.status != Status::Ok) {
            let line = format!("{component}: {}", message.text.trim());
            if !self.warnings.contains(&line) {
                self.warnings.push(line);
            }
        }
    }

    /// For people; `controller` is what the metrics judge.
    pub fn summary(&self, controller: Option<&str>, metrics: Result<&Metrics, &MetricsObstacle>) -> String {
        let names: Vec<_> = self.components.iter().map(|component| component.name.as_str()).collect();
        let title = self.title.as_ref().map(|title| format!("{title}\n")).unwrap_or_default();
        let ExperimentDocument { steps, step, stop, .. } = &self.experiment;
        let mut text = format!(
            "{title}{}: {} signals connected, {steps} steps of {step} s up to t = {stop} s in {:.2} s ({:.2} µs per step)\n",
            names.join(" + "),
            self.connections.len(),
            self.wall_time,
            1e6 * self.wall_time / *steps as f64
        );
        match metrics {
            Ok(metrics) => {
                let controller = controller.unwrap_or("none");
                let mut forces = report::force_table([(controller, metrics, "")]);
                // The last column compares with the paper, which knows one case only.
                forces.header.pop();
                forces.rows.iter_mut().for_each(|row| drop(row.pop()));
                let efforts = report::effort_table([(controller, metrics)]);
                text = [text, forces.to_terminal(), efforts.to_terminal()].join("\n");
            }
            Err(obstacle) if obstacle.is_grasp() => text = format!("{text}No metrics: {obstacle}\n"),
            // Other FMUs never wanted any.
            Err(_) => {}
        }
        text
    }

    /// Prints the warnings.
    pub fn print_warnings(&self) {
        const SHOWN: usize = 5;
        for line in self.warnings.iter().take(SHOWN) {
            print_error(&format!("warning: {line}\n"));
        }
        if self.warnings.len() > SHOWN {
            print_error(&format!("warning: … and {} more\n", self.warnings.len() - SHOWN));
        }
    }

    /// Prints it for machines.
    pub fn print_json(&self) -> Result<(), crate::cli::Failure> {
        json::print(self)
    }
}

fn json_value(kind: Kind, value: f64) -> Value {
    match kind {
        Kind::Real => Value::from(value),
        #[allow(clippy::cast_possible_truncation)] // it was a 32-bit integer
        Kind::Integer => Value::from(value as i32),
        Kind::Boolean => Value::from(value != 0.0),
    }
}
