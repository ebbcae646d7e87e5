//! A run of a model whose results its page shows. The packaging program steps the model's own code.

use std::fmt::Write as _;

use fmi2_export::packaging::{Instance, Interface, Kind, VariableFacts};
use fmi2_export::{Causality, ExportedModel, Resources};

/// A value as a function of the time (s).
pub type OfTime = fn(f64) -> f64;

/// A run whose results the page shows, in one panel or several.
///
/// ```
/// use fmi2_package::{Panel, Response};
/// let step = Response {
///     caption: "Step of the voltage, and a load from 0.5 s on.",
///     start: &[("voltage", 12.0)],
///     inputs: &[("load", |time| if time < 0.5 { 0.0 } else { 0.02 })],
///     stop_time: 1.0,
///     step_size: 1e-3,
///     panels: &[Panel { title: "Speed", variables: &["speed"] }, Panel { title: "Current", variables: &["current"] }],
///     beside: &[],
/// };
/// # let _ = step;
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Response<'a> {
    /// A description of the experiment, in Markdown.
    pub caption: &'a str,
    /// Values of parameters, and of inputs that stay constant. Booleans are 0 or 1, enumerations numbered from 1.
    pub start: &'a [(&'a str, f64)],
    /// Inputs as functions of the time (s), held over each step.
    pub inputs: &'a [(&'a str, OfTime)],
    /// How long to simulate (s).
    pub stop_time: f64,
    /// Communication step size (s).
    pub step_size: f64,
    /// The panels of the figure.
    pub panels: &'a [Panel<'a>],
    /// Signals from outside the model, which panels may show with its own.
    pub beside: &'a [Beside<'a>],
}

/// A signal from outside the model. For a controller this is a signal of the plant, if the inputs were measured in the loop
/// of both.
#[derive(Clone, Copy, Debug)]
pub struct Beside<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its unit, as it is shown.
    pub unit: &'a str,
    /// Its values.
    pub values: OfTime,
}

/// Some variables over time, all of one unit.
#[derive(Clone, Copy, Debug)]
pub struct Panel<'a> {
    /// Its title.
    pub title: &'a str,
    /// The variables' names, of the model or [beside](Response::beside) it: at most four.
    pub variables: &'a [&'a str],
}

/// Why there are no results.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResponseError {
    /// The model has no such variable.
    #[error("there is no variable {name:?}{}", hint.as_ref().map_or_else(String::new, |hint| format!("; did you mean {hint:?}?")))]
    Unknown {
        /// The name.
        name: String,
        /// The most similar name.
        hint: Option<String>,
    },
    /// A variable of this kind cannot be used in this way.
    #[error("{name} {problem}")]
    Unfit {
        /// Its name.
        name: String,
        /// Why not.
        problem: &'static str,
    },
    /// The times are not valid.
    #[error("stop_time {stop_time} and step_size {step_size} (s) must be positive, and at most 100 000 steps")]
    Times {
        /// The given stop time.
        stop_time: f64,
        /// The given step size.
        step_size: f64,
    },
    /// The model refused a call.
    #[error("the model refused at {time} s: {message}")]
    Refused {
        /// The time.
        time: f64,
        /// The message of the model.
        message: String,
    },
}

/// The results of a run.
pub struct Run<'i> {
    pub times: Vec<f64>,
    /// The inputs over time, with their values from each time on.
    pub inputs: Vec<Series<'i>>,
    /// The shown signals of each panel.
    pub panels: Vec<Vec<Series<'i>>>,
}

/// Values of a signal.
pub struct Series<'i> {
    pub name: &'i str,
    /// The unit that readers see, and the factor: shown value = factor · value.
    pub unit: (&'i str, f64),
    pub values: Vec<f64>,
    source: Source<'i>,
}

/// The owner of a signal.
enum Source<'i> {
    Model(&'i VariableFacts),
    Beside(OfTime),
}

impl<'i> Series<'i> {
    fn of(variable: &'i VariableFacts) -> Self {
        let unit = match (&variable.display_unit, &variable.unit) {
            (Some(display), _) => (&*display.name, display.factor),
            (None, Some(unit)) => (unit.name(), 1.0),
            (None, None) => ("", 1.0),
        };
        Self { name: &variable.name, unit, values: Vec::new(), source: Source::Model(variable) }
    }

    /// Whether it belongs to the model.
    pub fn is_of_model(&self) -> bool {
        matches!(self.source, Source::Model(_))
    }
}

/// Runs a model. Like most masters, it records the outputs after each step, with the inputs of that step.
///
/// # Errors
/// If the run names a variable that does not exist, or the model refuses.
pub fn run<'i>(
    model: &'static dyn ExportedModel,
    interface: &'i Interface,
    response: &Response<'i>,
    resources: &Resources,
) -> Result<Run<'i>, ResponseError> {
    let Response { stop_time, step_size, .. } = *response;
    let steps = (stop_time / step_size).round();
    if !(step_size > 0.0 && (1.0..=1e5).contains(&steps)) {
        return Err(ResponseError::Times { stop_time, step_size });
    }
    let start = settings(interface, response.start)?;
    let (functions, inputs): (Vec<_>, Vec<_>) = response
        .inputs
        .iter()
        .map(|(name, function)| Ok((*function, Series::of(input(interface, name)?))))
        .collect::<Result<Vec<_>, ResponseError>>()?
        .into_iter()
        .unzip();
    let panels =
        response.panels.iter().map(|panel| shown(interface, response.beside, panel)).collect::<Result<_, _>>()?;
    let mut run = Run { times: Vec::new(), inputs, panels };

    let refused = |time| move |message| ResponseError::Refused { time, message };
    let mut instance =
        Instance::new(model, resources).map_err(|message| ResponseError::Refused { time: 0.0, message })?;
    let mut begin = || {
        for (variable, value) in &start {
            instance.set(variable, *value)?;
        }
        instance.enter_initialization()?;
        run.apply(&mut instance, &functions, 0.0)?;
        instance.exit_initialization()?;
        run.record(&mut instance, 0.0)
    };
    begin().map_err(refused(0.0))?;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // At most 100 000.
    for i in 0..steps as u32 {
        let (time, end) = (f64::from(i) * step_size, f64::from(i + 1) * step_size);
        let mut step = || {
            if i > 0 {
                run.apply(&mut instance, &functions, time)?;
            }
            instance.step(time, end - time)?;
            run.record(&mut instance, end)
        };
        step().map_err(refused(time))?;
    }
    for (series, function) in run.inputs.iter_mut().zip(&functions) {
        series.values.push(function(stop_time));
    }
    Ok(run)
}

impl Run<'_> {
    /// Sets the inputs for the step from `time` on.
    fn apply(&mut self, instance: &mut Instance, functions: &[OfTime], time: f64) -> Result<(), String> {
        for (series, function) in self.inputs.iter_mut().zip(functions) {
            let value = function(time);
            series.values.push(value);
            if let Source::Model(variable) = series.source {
                instance.set(variable, value)?;
            }
        }
        Ok(())
    }

    fn record(&mut self, instance: &mut Instance, time: f64) -> Result<(), String> {
        self.times.push(time);
        for series in self.panels.iter_mut().flatten() {
            series.values.push(match series.source {
                Source::Model(variable) => instance.get(variable)?,
                Source::Beside(values) => values(time),
            });
        }
        Ok(())
    }

    /// The shown variables of the model as CSV, each once.
    pub fn results_csv(&self) -> String {
        csv(&self.times, &self.shown(true))
    }

    /// The shown signals beside it as CSV, if there are any.
    pub fn beside_csv(&self) -> Option<String> {
        let columns = self.shown(false);
        (!columns.is_empty()).then(|| csv(&self.times, &columns))
    }

    /// Each once: the model's, or those beside it.
    fn shown(&self, of_model: bool) -> Vec<&Series<'_>> {
        let mut columns: Vec<&Series<'_>> = Vec::new();
        for series in self.panels.iter().flatten().filter(|series| series.is_of_model() == of_model) {
            if !columns.iter().any(|other| other.name == series.name) {
                columns.push(series);
            }
        }
        columns
    }

    /// The inputs over time as CSV, if there are any.
    pub fn inputs_csv(&self) -> Option<String> {
        (!self.inputs.is_empty()).then(|| csv(&self.times, &self.inputs.iter().collect::<Vec<_>>()))
    }
}

/// Numbers are written so that they read back exactly.
fn csv(times: &[f64], columns: &[&Series<'_>]) -> String {
    let mut csv = String::from("time");
    for series in columns {
        let _ = write!(csv, ",\"{}\"", series.name.replace('"', "\"\""));
    }
    for (i, time) in times.iter().enumerate() {
        let _ = write!(csv, "\n{time}");
        for series in columns {
            let _ = write!(csv, ",{}", series.values[i]);
        }
    }
    csv.push('\n');
    csv
}

fn settings<'i>(
    interface: &'i Interface,
    start: &[(&str, f64)],
) -> Result<Vec<(&'i VariableFacts, f64)>, ResponseError> {
    let setting = |(name, value): &(&str, f64)| {
        let variable = find(interface, name)?;
        match (variable.causality, variable.kind) {
            (Causality::Output | Causality::Local, _) => {
                Err(unfit(variable, "is computed by the model: it cannot be set"))
            }
            (_, Kind::String) => Err(unfit(variable, "is a string: it cannot be set to a number")),
            _ => Ok((variable, *value)),
        }
    };
    start.iter().map(setting).collect()
}

fn input<'i>(interface: &'i Interface, name: &str) -> Result<&'i VariableFacts, ResponseError> {
    let variable = find(interface, name)?;
    if (variable.causality, variable.kind) == (Causality::Input, Kind::Real) {
        Ok(variable)
    } else {
        Err(unfit(variable, "is no input of type Real: it cannot follow a function of time"))
    }
}

fn shown<'i>(
    interface: &'i Interface,
    beside: &'i [Beside<'i>],
    panel: &Panel<'i>,
) -> Result<Vec<Series<'i>>, ResponseError> {
    let mut shown: Vec<Series<'i>> = Vec::new();
    for &name in panel.variables {
        let unfit = |problem| ResponseError::Unfit { name: name.to_owned(), problem };
        let series = match beside.iter().find(|beside| beside.name == name) {
            Some(Beside { name, unit, values }) => {
                Series { name, unit: (unit, 1.0), values: Vec::new(), source: Source::Beside(*values) }
            }
            None => Series::of(find(interface, name)?),
        };
        if matches!(series.source, Source::Model(VariableFacts { kind: Kind::String, .. })) {
            return Err(unfit("is a string: it cannot be drawn"));
        }
        if shown.first().is_some_and(|first| first.unit != series.unit) {
            return Err(unfit("has another unit than the first variable of its panel"));
        }
        if shown.len() >= 4 {
            return Err(unfit("is the fifth variable of its panel, at most four can be told apart"));
        }
        shown.push(series);
    }
    Ok(shown)
}

fn unfit(variable: &VariableFacts, problem: &'static str) -> ResponseError {
    ResponseError::Unfit { name: variable.name.clone(), problem }
}

fn find<'i>(interface: &'i Interface, name: &str) -> Result<&'i VariableFacts, ResponseError> {
    interface.variables.iter().find(|variable| variable.name == name).ok_or_else(|| {
        let likeness = |known: &VariableFacts| strsim::jaro_winkler(&known.name, name);
        let nearest = interface.variables.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let hint = nearest.filter(|known| likeness(known) > 0.7).map(|known| known.name.clone());
        ResponseError::Unknown { name: name.to_owned(), hint }
    })
}
