//! The text of a study file.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use fmi2_cosim::master::Coupling;
use fmi2_cosim::names::with_suggestion;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::system::{Located, RunOptions, SourceLine, is_tolerance};
use fmi2_import::Value;
use fmi2_import::document::Lines;
use serde::Deserialize;
use toml::Spanned;

use super::range::{self, RangeEntry};
use super::{Bound, Coordinates, Entrant, Method, Source, Study, StudyError};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: String,
    #[serde(default)]
    description: String,
    system: SourceEntry,
    #[serde(default)]
    controllers: Vec<Spanned<EntrantEntry>>,
    method: Spanned<Method>,
    draws: Option<Spanned<u64>>,
    #[serde(default = "one")]
    seed: u64,
    points: Option<PathBuf>,
    coordinates: Option<Coordinates>,
    #[serde(default)]
    experiment: ExperimentTable,
    #[serde(default)]
    parameters: BTreeMap<String, Spanned<toml::Value>>,
    #[serde(default)]
    vary: BTreeMap<String, Spanned<RangeEntry>>,
    #[serde(default)]
    outputs: Vec<String>,
    #[serde(default)]
    success: BTreeMap<String, Spanned<BoundEntry>>,
}

fn one() -> u64 {
    1
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the name of a scenario, a file (.toml, .ssp), or a list of FMU files")]
enum SourceEntry {
    Named(String),
    Fmus(Vec<PathBuf>),
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a controller's name, or { name = …, title = …, step = …, parameters = {…} }")]
enum EntrantEntry {
    Name(String),
    Table(EntrantTable),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntrantTable {
    name: String,
    title: Option<String>,
    step: Option<f64>,
    #[serde(default)]
    parameters: BTreeMap<String, toml::Value>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExperimentTable {
    start: Option<f64>,
    stop: Option<f64>,
    step: Option<f64>,
    interval: Option<f64>,
    tolerance: Option<Spanned<f64>>,
    coupling: Option<Coupling>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the largest value, or { min = …, max = … }")]
enum BoundEntry {
    Most(f64),
    Table(BoundTable),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoundTable {
    min: Option<f64>,
    max: Option<f64>,
}

/// A fault, and its byte in the text.
pub(super) type Fault = (usize, String);

pub(super) fn parse(file: &str, text: &str) -> Result<Study, StudyError> {
    let lines = Lines::of(text);
    let content = |(offset, message): Fault| {
        let (line, column) = lines.position(text, offset);
        StudyError::Content { file: file.to_owned(), line, column, message }
    };
    let name: Arc<str> = file.into();
    let place = |offset: usize| SourceLine { file: Arc::clone(&name), line: lines.line(offset) };
    let read: File = toml::from_str(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        content((offset, with_suggestion(error.message()) + dotted(text, offset)))
    })?;
    read.study(&place).map_err(content)
}

/// A hint for a name that a dot divides in two: TOML takes the second half for a key inside the first.
fn dotted(text: &str, offset: usize) -> &'static str {
    if text[..offset].ends_with('.') { " (write \"Component.name\" with its quotation marks)" } else { "" }
}

impl File {
    fn study(self, place: &dyn Fn(usize) -> SourceLine) -> Result<Study, Fault> {
        let method = *self.method.get_ref();
        self.check_method()?;
        let constant = |(name, value): (String, Spanned<toml::Value>)| {
            let at = value.span().start;
            let value = value_of(value.into_inner()).map_err(|message| (at, message))?;
            Ok(Located { item: Setting::new(name, value), place: Some(place(at)) })
        };
        let parameters = self.parameters.into_iter().map(constant).collect::<Result<_, Fault>>()?;
        let mut vary = Vec::new();
        for (name, entry) in self.vary {
            let at = entry.span().start;
            vary.push(range::varied(name, entry.into_inner(), method, place(at)).map_err(|message| (at, message))?);
        }
        let bound = |(figure, entry): (String, Spanned<BoundEntry>)| {
            let at = entry.span().start;
            let (min, max) = match entry.into_inner() {
                BoundEntry::Most(max) => (None, Some(max)),
                BoundEntry::Table(BoundTable { min, max }) => (min, max),
            };
            if min.is_none() && max.is_none() || min.is_some_and(f64::is_nan) || max.is_some_and(f64::is_nan) {
                return Err((at, format!("{figure} needs a number for min or max")));
            }
            Ok(Bound { figure, min, max, place: place(at) })
        };
        let success = self.success.into_iter().map(bound).collect::<Result<_, Fault>>()?;
        let entrant = |entry: Spanned<EntrantEntry>| {
            let at = entry.span().start;
            entry.into_inner().entrant(&place(at)).map_err(|message| (at, message))
        };
        let entrants = self.controllers.into_iter().map(entrant).collect::<Result<Vec<_>, Fault>>()?;
        let system = match self.system {
            SourceEntry::Named(name) => Source::Named(name),
            SourceEntry::Fmus(files) if files.is_empty() => return Err((0, "system names no FMU".into())),
            SourceEntry::Fmus(files) => Source::Fmus(files),
        };
        if !entrants.is_empty() && matches!(system, Source::Fmus(_)) {
            let message =
                "controllers take the place of a scenario's controller, but system is a list of FMUs; write a scenario";
            return Err((0, message.into()));
        }
        Ok(Study {
            title: self.title,
            description: self.description.trim().to_owned(),
            system,
            entrants,
            method,
            draws: self.draws.map(Spanned::into_inner),
            seed: self.seed,
            points: self.points,
            coordinates: self.coordinates.unwrap_or_default(),
            experiment: self.experiment.options()?,
            parameters,
            vary,
            outputs: self.outputs,
            success,
            folder: None,
        })
    }

    /// Checks the keys that a method needs, and those that it must not have.
    fn check_method(&self) -> Result<(), Fault> {
        let method = *self.method.get_ref();
        let at = self.method.span().start;
        let draws = self.draws.as_ref();
        match (method, draws) {
            (Method::Grid | Method::Table, Some(draws)) => {
                let reason = if method == Method::Grid { "the values" } else { "the table" };
                Err((draws.span().start, format!("{reason} say how many draws there are; leave draws out")))
            }
            (Method::LatinHypercube | Method::Sobol | Method::Random, None) => {
                Err((at, "draws is missing: how many points are wanted?".into()))
            }
            (_, Some(draws)) if *draws.get_ref() == 0 => Err((draws.span().start, "draws must be at least 1".into())),
            (Method::Table, None) if self.points.is_none() => {
                Err((at, "points is missing: the file (.csv or .parquet) with a column for each parameter".into()))
            }
            _ if method != Method::Table && self.points.is_some() => {
                Err((at, "points belong to method = \"table\"".into()))
            }
            _ if method != Method::Table && self.vary.is_empty() => {
                Err((at, "nothing is varied: [vary] names parameters and their ranges".into()))
            }
            _ => Ok(()),
        }
    }
}

impl EntrantEntry {
    fn entrant(self, place: &SourceLine) -> Result<Entrant, String> {
        Ok(match self {
            Self::Name(name) => Entrant { name, title: None, step: None, parameters: Vec::new() },
            Self::Table(EntrantTable { name, title, step, parameters }) => {
                if step.is_some_and(|step| !(step > 0.0 && step.is_finite())) {
                    return Err(format!("the step of {name} must be a positive number of seconds"));
                }
                let setting = |(target, value)| {
                    Ok(Located { item: Setting::new(target, value_of(value)?), place: Some(place.clone()) })
                };
                let parameters = parameters.into_iter().map(setting).collect::<Result<_, String>>()?;
                Entrant { name, title, step, parameters }
            }
        })
    }
}

impl ExperimentTable {
    fn options(self) -> Result<RunOptions, Fault> {
        let tolerance = self.tolerance;
        if let Some(wrong) = tolerance.as_ref().filter(|tolerance| !is_tolerance(*tolerance.get_ref())) {
            return Err((wrong.span().start, "the tolerance must be a positive number".into()));
        }
        // Start, stop, step and interval are checked together with those of the system.
        Ok(RunOptions {
            start: self.start,
            stop: self.stop,
            step: self.step,
            tolerance: tolerance.map(Spanned::into_inner),
            coupling: self.coupling,
            interval: self.interval,
        })
    }
}

/// A number, a truth value or a text of TOML.
pub(super) fn value_of(value: toml::Value) -> Result<Value, String> {
    #[allow(clippy::cast_precision_loss)] // as a real has it
    let integer = |value: i64| i32::try_from(value).map_or(Value::Real(value as f64), Value::Integer);
    match value {
        toml::Value::Integer(value) => Ok(integer(value)),
        toml::Value::Float(value) => Ok(value.into()),
        toml::Value::Boolean(value) => Ok(value.into()),
        toml::Value::String(value) => Ok(value.into()),
        toml::Value::Table(_) => Err("expected a value (write \"Component.name\" with its quotation marks)".into()),
        _ => Err("expected a number, true or false, or a text".into()),
    }
}

#[cfg(test)]
mod tests;
