//! The outcome of a run, for users and for programs.

use std::collections::HashSet;
use std::fmt::Write;
use std::path::PathBuf;

use serde::Serialize;
use serde_json::{Map, Value};

use crate::cli::json::{self, ExperimentDocument, MetricsDocument};
use crate::cli::printable::one_line;
use crate::cli::{paragraph, print_error, width};
use crate::report;
use fmi2_cosim::master::Master;
use fmi2_cosim::names::number;
use fmi2_cosim::record::{Column, Kind};
use fmi2_cosim::run::{Ended, Results, Run};
use fmi2_cosim::system::System;
use fmi2_cosim::wiring::Terminal;
use fmi2_import::{Causality, LogMessage, Status};
use grasp_merit::metrics::{Metrics, MetricsObstacle};

/// The outcome of a run. Serialised, it is the document of `--json`; `docs/tool.md` describes the keys.
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
    /// Why there are no metrics.
    metrics_obstacle: Option<String>,
    output: Option<PathBuf>,
    /// The page.
    pub report: Option<PathBuf>,
    /// Outputs that are texts: rows have no place for them.
    texts: Vec<String>,
    #[serde(skip)]
    columns: usize,
    /// If an FMU ended the simulation.
    ended: Option<End>,
    /// Inputs without a connection and without a setting: they keep their start values.
    open_inputs: Vec<String>,
    /// Warnings of the tool and the FMUs, each once.
    pub warnings: Vec<String>,
    /// The verdict of `--monitor`.
    pub monitor: Option<String>,
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

/// That an FMU ended the simulation.
#[derive(Serialize)]
pub struct End {
    /// How far it got, in s.
    pub time: f64,
    /// The component.
    pub component: String,
    /// The message of the FMU.
    pub reason: String,
}

impl From<Ended> for End {
    fn from(Ended { time, component, source }: Ended) -> Self {
        Self { time, component, reason: source.to_string() }
    }
}

/// Names of components in the first line of a summary.
const SHOWN: usize = 10;

impl Outcome {
    /// Collects everything about a run except the logs of the FMUs. `columns` are those of its rows, `output` is the file
    /// with them.
    pub fn new(
        system: &System,
        master: &Master,
        run: &Run,
        columns: &[Column],
        results: Results,
        metrics: Result<&Metrics, &MetricsObstacle>,
        output: Option<PathBuf>,
    ) -> Self {
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
        let values = columns.iter().zip(&results.last).map(value);
        let text_names = results.texts.iter().map(|(name, _)| name.clone()).collect();
        let texts = results.texts.into_iter().map(|(name, text)| (name, Value::from(text)));
        Self {
            command: "simulate",
            version: env!("CARGO_PKG_VERSION"),
            title: system.title.clone(),
            components: system.components.iter().map(component).collect(),
            connections: connections
                .map(|wire| Connection { from: terminal(wire.from), to: terminal(wire.to) })
                .collect(),
            experiment: ExperimentDocument::new(&run.grid, run.coupling, run.interval).after(results.steps),
            wall_time: results.wall_time.as_secs_f64(),
            last: values.chain(texts).collect(),
            metrics: metrics.ok().map(MetricsDocument::from),
            metrics_obstacle: metrics.err().map(ToString::to_string),
            output,
            report: None,
            texts: text_names,
            columns: columns.len(),
            ended: results.ended.map(End::from),
            open_inputs: open_inputs(system, master),
            warnings: results.remarks,
            monitor: None,
        }
    }

    /// Adds the logs of the FMUs to the warnings.
    pub fn warn(&mut self, log: &[(String, LogMessage)]) {
        self.warnings.extend(complaints(log));
    }

    /// The summary for users; `controller` is the controller that the metrics judge.
    pub fn summary(&self, controller: Option<&str>, metrics: Result<&Metrics, &MetricsObstacle>) -> String {
        let mut names: Vec<_> = self.components.iter().map(|component| component.name.as_str()).take(SHOWN).collect();
        if self.components.len() > SHOWN {
            names.push("…");
        }
        let title = self.title.as_ref().map(|title| one_line(title).into_owned() + "\n").unwrap_or_default();
        let ExperimentDocument { steps, step, stop, .. } = &self.experiment;
        let stop = self.ended.as_ref().map_or(stop, |end| &end.time);
        let head = format!("{}: {} signals connected,", one_line(&names.join(" + ")), self.connections.len());
        let tail = format!(
            "{steps} steps of {} s up to t = {} s in {:.2} s ({:.2} µs each with output)",
            number(*step),
            number(*stop),
            self.wall_time,
            1e6 * self.wall_time / (*steps).max(1) as f64
        );
        let fits = head.chars().count() + 1 + tail.chars().count() <= width();
        let mut text = format!("{title}{head}{}{tail}\n", if fits { " " } else { "\n  " });
        text += &self.connected();
        if !self.texts.is_empty() {
            let names: Vec<_> = self.texts.iter().map(String::as_str).collect();
            text += &listed("texts, which rows leave out (--json has their last values)", &names, width());
        }
        if self.columns == 0 {
            text += "  no FMU has an output that is a number: rows have only times\n";
        }
        if let Some(End { time, component, reason }) = &self.ended {
            let line = format!("{component} ended the simulation at t = {} s: {reason}", number(*time));
            let _ = writeln!(text, "{}", one_line(&line));
        }
        if let Some(verdict) = &self.monitor {
            let _ = writeln!(text, "  monitor: {verdict}");
        }
        match metrics {
            Ok(metrics) => {
                let controller = controller.unwrap_or("none");
                let mut forces = report::force_table([(controller, metrics, "")]);
                // The last column compares with the paper, which has only one case.
                forces.header.pop();
                forces.rows.iter_mut().for_each(|row| drop(row.pop()));
                let efforts = report::effort_table([(controller, metrics)]);
                text = [text, forces.to_terminal(width()), efforts.to_terminal(width())].join("\n");
            }
            Err(obstacle) if obstacle.is_grasp() => text = format!("{text}No metrics: {obstacle}\n"),
            // Other FMUs never wanted any.
            Err(_) => {}
        }
        for file in [&self.output, &self.report].into_iter().flatten() {
            let _ = writeln!(text, "wrote {}", one_line(&file.display().to_string()));
        }
        text
    }

    /// The connections, and the open inputs.
    fn connected(&self) -> String {
        let mut lines: Vec<(String, Vec<&str>)> = Vec::new();
        for Connection { from, to } in &self.connections {
            let (from, name) = self.split(from);
            let pair = format!("{from} → {}", self.split(to).0);
            match lines.last_mut() {
                Some((last, names)) if *last == pair => names.push(name),
                _ => lines.push((pair, vec![name])),
            }
        }
        if !self.open_inputs.is_empty() {
            lines.push(("open inputs".into(), self.open_inputs.iter().map(String::as_str).collect()));
        }
        lines.iter().map(|(title, names)| listed(title, names, width())).collect()
    }

    /// Component and variable of `Component.name`; both may have dots.
    fn split<'a>(&self, name: &'a str) -> (&'a str, &'a str) {
        let component = self
            .components
            .iter()
            .map(|component| component.name.as_str())
            .find(|component| name.strip_prefix(component).is_some_and(|rest| rest.starts_with('.')));
        component.map_or(("", name), |component| (&name[..component.len()], &name[component.len() + 1..]))
    }

    /// Prints it for machines.
    pub fn print_json(&self) -> Result<(), crate::cli::Failure> {
        json::print(self)
    }
}

/// The inputs that nothing drives and that neither the user nor the scenario gives a value.
fn open_inputs(system: &System, master: &Master) -> Vec<String> {
    let driven: HashSet<_> = master.wires().iter().map(|wire| wire.to).chain(master.driven()).collect();
    let settings = system.settings.iter().map(|setting| &setting.item).chain(&system.overrides);
    let named: HashSet<_> = settings.map(|setting| setting.target.as_str()).collect();
    let mut open = Vec::new();
    for (component, (name, fmu)) in system.components.iter().enumerate() {
        for (variable, described) in fmu.description().variables.iter().enumerate() {
            // Few of many variables are inputs.
            if described.causality != Causality::Input {
                continue;
            }
            let full = format!("{name}.{}", described.name);
            let is_set = named.contains(described.name.as_str()) || named.contains(full.as_str());
            let is_driven = driven.contains(&Terminal { component, variable });
            if !is_driven && !is_set {
                open.push(full);
            }
        }
    }
    open
}

/// Names after a title, on as many lines of `width` columns as they need. Of very many names only the first are shown;
/// `--json` has all.
fn listed(title: &str, names: &[&str], width: usize) -> String {
    const SHOWN: usize = 60;
    let mut text = format!("  {}:", one_line(title));
    let mut length = text.chars().count();
    let shown = names.len().min(SHOWN);
    for (index, name) in names[..shown].iter().enumerate() {
        let name = one_line(name);
        let comma = if index + 1 == names.len() { "" } else { "," };
        let more = 1 + name.chars().count() + comma.len();
        if index > 0 && length + more > width {
            text += "\n   ";
            length = 3;
        }
        let _ = write!(text, " {name}{comma}");
        length += more;
    }
    if shown < names.len() {
        let _ = write!(text, "\n    \u{2026} {} in all, which --json lists", names.len());
    }
    text + "\n"
}

/// The warnings and errors in the logs of the FMUs, each once.
pub fn complaints(log: &[(String, LogMessage)]) -> Vec<String> {
    let mut seen = HashSet::new();
    let complaints = log.iter().filter(|(_, message)| message.status != Status::Ok);
    let lines = complaints.map(|(component, message)| format!("{component}: {}", message.text.trim()));
    lines.filter(|line| seen.insert(line.clone())).collect()
}

/// Prints warnings.
pub fn print_warnings(warnings: &[String]) {
    const SHOWN: usize = 5;
    for line in warnings.iter().take(SHOWN) {
        print_error(&format!("warning: {}\n", paragraph(line)));
    }
    if warnings.len() > SHOWN {
        print_error(&format!("warning: … and {} more\n", warnings.len() - SHOWN));
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
