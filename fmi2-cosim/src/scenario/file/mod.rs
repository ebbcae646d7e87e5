//! The text of a scenario file.

mod values;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use fmi2_import::document::Lines;
use serde::Deserialize;
use toml::Spanned;

use super::{Scenario, ScenarioError};
use crate::grid::GridError;
use crate::master::Coupling;
use crate::names::with_suggestion;
use crate::settings::Setting;
use crate::system::{Located, RunOptions, SourceLine, is_tolerance};
use values::{Constant, Input};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: String,
    #[serde(default)]
    description: String,
    fmus: Vec<PathBuf>,
    #[serde(default)]
    experiment: ExperimentTable,
    #[serde(default)]
    parameters: BTreeMap<String, Spanned<Constant>>,
    #[serde(default)]
    inputs: BTreeMap<String, Spanned<Input>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExperimentTable {
    start: Option<Spanned<f64>>,
    stop: Option<Spanned<f64>>,
    step: Option<Spanned<f64>>,
    interval: Option<Spanned<f64>>,
    tolerance: Option<Spanned<f64>>,
    coupling: Option<Coupling>,
}

pub(super) fn parse(file: &str, text: &str) -> Result<Scenario, ScenarioError> {
    let lines = Lines::of(text);
    let content = |offset: usize, message: String| {
        let (line, column) = lines.position(text, offset);
        ScenarioError::Content { file: file.to_owned(), line, column, message }
    };
    let read: File = toml::from_str(text)
        .map_err(|error| content(error.span().map_or(0, |span| span.start), with_suggestion(error.message())))?;
    if read.fmus.is_empty() {
        return Err(content(0, "fmus names no file".to_owned()));
    }
    let name: Arc<str> = file.into();
    let place = |offset: usize| Some(SourceLine { file: Arc::clone(&name), line: lines.line(offset) });
    let mut settings = Vec::new();
    for (name, value) in in_file_order(read.parameters) {
        let place = place(value.span().start);
        settings.push(Located { item: Setting::new(name, value.into_inner().0), place });
    }
    let (mut held, mut inputs) = (Vec::new(), Vec::new());
    for (name, input) in in_file_order(read.inputs) {
        let place = place(input.span().start);
        match input.into_inner() {
            Input::Constant(value) => held.push(Located { item: Setting::new(name, value), place }),
            Input::Varying(signal) => inputs.push(Located { item: (name, signal), place }),
        }
    }
    let experiment = read.experiment.check().map_err(|(offset, message)| content(offset, message))?;
    Ok(Scenario {
        title: read.title,
        description: read.description.trim().to_owned(),
        fmus: read.fmus,
        experiment,
        settings,
        held,
        inputs,
        folder: None,
    })
}

/// The keys of a table from the first line to the last: of `M` and `"Plant.M"`, which may mean one variable, the later one counts.
fn in_file_order<T>(table: BTreeMap<String, Spanned<T>>) -> Vec<(String, Spanned<T>)> {
    let mut keys: Vec<_> = table.into_iter().collect();
    keys.sort_by_key(|(_, value)| value.span().start);
    keys
}

impl ExperimentTable {
    /// The options, if they can be run; otherwise the place and the fault.
    fn check(self) -> Result<RunOptions, (usize, String)> {
        let Self { start, stop, step, interval, tolerance, coupling } = self;
        let value = |key: &Option<Spanned<f64>>| key.as_ref().map(|value| *value.get_ref());
        let refuse = |key: &Option<Spanned<f64>>, message: String| {
            Err((key.as_ref().map_or(0, |value| value.span().start), message))
        };
        let begin = value(&start).unwrap_or(0.0);
        if !begin.is_finite() {
            return refuse(&start, format!("the start time must be a finite number of seconds, not {begin}"));
        }
        if let Some(end) = value(&stop).filter(|end| !(end.is_finite() && *end > begin)) {
            return refuse(&stop, GridError::Stop { start: begin, stop: end }.to_string());
        }
        if let Some(step_size) = value(&step).filter(|step| !(step.is_finite() && *step > 0.0)) {
            return refuse(&step, GridError::Step(step_size).to_string());
        }
        if let Some(seconds) = value(&interval).filter(|seconds| !(seconds.is_finite() && *seconds >= 0.0)) {
            return refuse(&interval, format!("the interval must be 0 or more seconds, not {seconds}"));
        }
        if let Some(value) = value(&tolerance).filter(|tolerance| !is_tolerance(*tolerance)) {
            return refuse(&tolerance, format!("the tolerance must be a positive number, not {value}"));
        }
        let [start, stop, step, interval, tolerance] = [start, stop, step, interval, tolerance].map(|key| value(&key));
        Ok(RunOptions { start, stop, step, tolerance, coupling, interval })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"title = "Two"
description = """
Long.
"""
fmus = ["a.fmu", "b.fmu"]

[experiment]
stop = 2
step = 1e-3
tolerance = 1e-6
coupling = "jacobi"

[parameters]
M = 1.5
order = 8
actuator_model = "raw"
"Plant.on" = true

[inputs]
u = 0.25
delta_F.steps = [[0, 0], [0.5, 0.1]]
"Plant.enable" = { steps = [[0, false], [1, true]] }
lambda1_ref.linear = [[0, -0.5], [1, -0.6]]
"#;

    #[test]
    fn every_part_is_read() {
        let scenario = parse("x.toml", GOOD).unwrap();
        assert_eq!((scenario.title.as_str(), scenario.description.as_str()), ("Two", "Long."));
        assert_eq!(scenario.fmus.len(), 2);
        let RunOptions { start, stop, step, tolerance, coupling, interval } = scenario.experiment;
        assert_eq!((start, stop, step, interval), (None, Some(2.0), Some(1e-3), None));
        assert_eq!(tolerance, Some(1e-6));
        assert_eq!(coupling, Some(Coupling::Jacobi));
        let settings: Vec<_> = scenario.settings.iter().map(|setting| setting.item.to_string()).collect();
        assert_eq!(settings, ["M=1.5", "order=8", "actuator_model=raw", "Plant.on=true"]);
        assert_eq!(scenario.held[0].item.to_string(), "u=0.25");
        assert_eq!(scenario.settings[0].place.as_ref().unwrap().to_string(), "x.toml:14");
        let values: Vec<_> =
            scenario.inputs.iter().map(|input| (input.item.0.as_str(), input.item.1.at(0.75))).collect();
        assert_eq!(values, [("delta_F", 0.1), ("Plant.enable", 0.0), ("lambda1_ref", -0.575)]);
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        for (from, to, expected) in [
            ("stop = 2", "stp = 2", "x.toml:8:1: unknown field `stp`"),
            ("stop = 2", "stp = 2", "did you mean stop?"),
            ("fmus", "fmu", "x.toml:5:1: unknown field `fmu`"),
            ("title = \"Two\"\n", "", "missing field `title`"),
            ("stop = 2", "stop = \"2\"", "x.toml:8:8: invalid type: string \"2\", expected f64"),
            ("stop = 2", "stop = -1", "x.toml:8:8: the stop time (-1 s) must be later than the start time (0 s)"),
            (
                "stop = 2",
                "start = 3\nstop = 2",
                "x.toml:9:8: the stop time (2 s) must be later than the start time (3 s)",
            ),
            ("stop = 2", "start = nan", "x.toml:8:9: the start time must be a finite number"),
            ("step = 1e-3", "step = 0.0", "x.toml:9:8: the step size must be a positive number of seconds, not 0"),
            ("step = 1e-3", "interval = -1", "x.toml:9:12: the interval must be 0 or more seconds, not -1"),
            ("\"jacobi\"", "\"jakobi\"", "x.toml:11:12: unknown variant `jakobi`"),
            ("\"jacobi\"", "\"jakobi\"", "did you mean jacobi?"),
            ("step = 1e-3", "step = 1e-3\nstep = 2", "x.toml:10:1: duplicate key"),
            ("tolerance = 1e-6", "tolerance = 0", "x.toml:10:13: the tolerance must be a positive number, not 0"),
            ("= 1.5", "= ", "x.toml:14:"),
            ("\"Plant.on\"", "Plant.on", "write \"Component.name\" with its quotation marks"),
            ("delta_F.steps", "delta_F.step", "unknown shape `step`"),
            ("\"Plant.enable\"", "Plant.enable", "\"Component.name\" with its quotation marks"),
            ("[0.5, 0.1]", "[-1, 0.1]", "x.toml:21:"),
            ("[0.5, 0.1]", "[-1, 0.1]", "times must increase: -1 s follows 0 s"),
            ("[0.5, 0.1]", "[0.5]", "x.toml:21:"),
            ("[0.5, 0.1]", "[0.5, 0.1, 3]", "a point is [time, value], not 3 numbers"),
            ("[0.5, 0.1]", "[\"x\", 0.1]", "expected a number for the time of a point"),
            ("[0.5, 0.1]", "[0.5, []]", "expected a number, true or false, or the name of an enumeration's item"),
            ("[0.5, 0.1]", "[0.5, nan]", "is not finite"),
            ("[\"a.fmu\", \"b.fmu\"]", "[]", "fmus names no file"),
        ] {
            assert!(GOOD.contains(from), "{from}");
            let message = parse("x.toml", &GOOD.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(message.contains(expected), "{message:?} should contain {expected:?}");
        }
    }
}
