//! Values a user gives to variables by name: `name=value` or `Component.name=value`.

use std::fmt;
use std::str::FromStr;

use crate::names::{self, closest, suggestion};
use crate::signal::Signal;
use crate::units::{UnitMismatch, Units};
use fmi2_import::description::BaseType;
use fmi2_import::{CallError, Causality, Mismatch, ModelDescription, Value, Variability, Variable, VariableType};

/// A value for a variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// `name` (in every component that has it) or `Component.name`.
    pub target: String,
    /// What it gets. A text from the command line stands for whatever the variable's type makes of it.
    pub value: Value,
}

/// Why a setting cannot be applied.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// No component has such a variable.
    #[error("there is no variable \"{target}\" in {}{}", .components.join(" or "), suggestion(.similar))]
    Unknown {
        /// What the user wrote.
        target: String,
        /// The components that were searched.
        components: Vec<String>,
        /// Settable variables with similar names.
        similar: Vec<String>,
    },
    /// What stands before the dot is no component.
    #[error("there is no component \"{component}\"; the components are {}{}", .components.join(", "), suggestion(.similar))]
    UnknownComponent {
        /// What stands before the dot.
        component: String,
        /// All components.
        components: Vec<String>,
        /// What the user may have meant.
        similar: Vec<String>,
    },
    /// The variable is not the user's to set.
    #[error("{component}.{name} cannot be set: {reason}")]
    NotSettable {
        /// The component.
        component: String,
        /// The variable.
        name: String,
        /// Why.
        reason: String,
    },
    /// The text is not a value of the variable's type.
    #[error("{component}.{name} needs {expected}, not \"{value}\"")]
    Value {
        /// The component.
        component: String,
        /// The variable.
        name: String,
        /// What the user wrote.
        value: String,
        /// What is needed.
        expected: String,
    },
    /// The value is outside the range that the FMU states.
    #[error("{component}.{name} must be {range}, not {value}")]
    Range {
        /// The component.
        component: String,
        /// The variable.
        name: String,
        /// The range in words.
        range: String,
        /// What was given.
        value: Value,
    },
    /// The FMU refused the value.
    #[error("{setting} is refused: {source}")]
    Refused {
        /// The setting.
        setting: Setting,
        /// What the FMU says.
        source: Box<CallError>,
    },
}

impl Setting {
    /// A setting.
    #[must_use]
    pub fn new(target: impl Into<String>, value: impl Into<Value>) -> Self {
        Self { target: target.into(), value: value.into() }
    }
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((target, value)) if !target.trim().is_empty() => Ok(Self::new(target.trim(), value.trim())),
            _ => Err("expected name=value or Component.name=value".into()),
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.target, self.value)
    }
}

/// A component as far as settings are concerned. It need not run yet: everything but the FMU's own refusal is known before.
pub(crate) trait Target {
    fn name(&self) -> &str;
    fn description(&self) -> &ModelDescription;
    /// Which output drives this input, if one does.
    fn driven_by(&self, variable: usize) -> Option<&str>;
}

/// A variable of a component: indices.
pub(crate) type Place = (usize, usize);

/// Every variable that a setting means, with the value that it would get there.
pub(crate) fn check<T: Target>(setting: &Setting, targets: &[T]) -> Result<Vec<(Place, Value)>, SettingError> {
    let meant = meant(&setting.target, targets, obstacle_to_setting)?;
    let fitted = |place: Place| Ok((place, fitted(&targets[place.0], place.1, &setting.value)?));
    meant.into_iter().map(fitted).collect()
}

/// The value that one variable would get.
pub(crate) fn check_one<T: Target>(place: Place, value: &Value, targets: &[T]) -> Result<Value, SettingError> {
    let target = &targets[place.0];
    match obstacle_to_setting(target, place.1) {
        None => fitted(target, place.1, value),
        Some(reason) => Err(SettingError::NotSettable {
            component: target.name().to_owned(),
            name: target.description().variables[place.1].name.clone(),
            reason,
        }),
    }
}

/// Every variable a user means with `name` or `Component.name` and to which there is no obstacle.
pub(crate) fn meant<T: Target>(
    wanted: &str,
    targets: &[T],
    obstacle: impl Fn(&T, usize) -> Option<String>,
) -> Result<Vec<Place>, SettingError> {
    let named = targets.iter().enumerate().filter_map(|(index, target)| {
        let description = target.description();
        let local = || {
            let name = wanted.strip_prefix(target.name())?.strip_prefix('.')?;
            description.index_of(name)
        };
        description.index_of(wanted).or_else(local).map(|variable| (index, variable))
    });
    let (mut free, mut first_obstacle) = (Vec::new(), None);
    for (target, variable) in named {
        match obstacle(&targets[target], variable) {
            None => free.push((target, variable)),
            Some(reason) => _ = first_obstacle.get_or_insert((target, variable, reason)),
        }
    }
    match first_obstacle {
        // A name may be one component's output and another one's parameter: it means the one where nothing is in the way.
        _ if !free.is_empty() => Ok(free),
        None => Err(unknown(wanted, targets)),
        Some((target, variable, reason)) => Err(SettingError::NotSettable {
            component: targets[target].name().to_owned(),
            name: targets[target].description().variables[variable].name.clone(),
            reason,
        }),
    }
}

fn obstacle_to_setting<T: Target>(target: &T, index: usize) -> Option<String> {
    let variable = &target.description().variables[index];
    if let Some(source) = target.driven_by(index) {
        return Some(format!("it is an input that {source} drives"));
    }
    if variable.is_settable() {
        return None;
    }
    Some(match (variable.variability, variable.causality) {
        (Variability::Constant, _) => "it is a constant".into(),
        (_, Causality::Output) => "it is an output that the FMU computes".into(),
        _ => "the FMU computes it".into(),
    })
}

/// Why a variable cannot follow this signal over time.
pub(crate) fn obstacle_to_driving<T: Target>(target: &T, index: usize, signal: &Signal) -> Option<String> {
    let variable = &target.description().variables[index];
    if let Some(source) = target.driven_by(index) {
        return Some(format!("it is an input that {source} drives"));
    }
    if variable.causality != Causality::Input {
        return Some("only inputs can change over time, and it is none".into());
    }
    let signal = match signal.of(variable) {
        Ok(signal) => signal,
        Err(mismatch) => return Some(mismatch.to_string()),
    };
    let values = || signal.values().map(|value| value.to_string()).collect::<Vec<_>>().join(", ");
    match variable.base_type() {
        BaseType::Real => None,
        BaseType::String => Some("texts cannot change over time".into()),
        _ if signal.is_ramped() => Some("only real inputs can follow straight lines; give it steps".into()),
        BaseType::Boolean if signal.values().any(|value| value != 0.0 && value != 1.0) => {
            Some(format!("it needs true and false (or 1 and 0), not {}", values()))
        }
        _ if signal.values().any(|value| value.fract() != 0.0 || value.abs() > f64::from(i32::MAX)) => {
            Some(format!("it needs integers, not {}", values()))
        }
        _ => None,
    }
}

/// A value as one of this variable's type, within its range.
fn fitted<T: Target>(target: &T, index: usize, given: &Value) -> Result<Value, SettingError> {
    let variable = &target.description().variables[index];
    let wrong = |Mismatch { value, expected }| SettingError::Value {
        component: target.name().to_owned(),
        name: variable.name.clone(),
        value,
        expected,
    };
    let value = match variable.value(given) {
        Ok(value) => value,
        Err(mismatch) => match in_own_unit(given, variable, target.description()) {
            Some(Ok(number)) => Value::Real(number),
            Some(Err(error)) => {
                let expected = format!("{} ({error})", mismatch.expected);
                return Err(wrong(Mismatch { expected, ..mismatch }));
            }
            None => return Err(wrong(mismatch)),
        },
    };
    match outside(variable, &value) {
        None => Ok(value),
        Some(range) => {
            let (component, name) = (target.name().to_owned(), variable.name.clone());
            Err(SettingError::Range { component, name, range, value })
        }
    }
}

/// The range of a variable in words, if a value lies outside.
fn outside(variable: &Variable, value: &Value) -> Option<String> {
    let (number, min, max) = match (&variable.kind, value) {
        (VariableType::Real(real), Value::Real(number)) => (*number, real.min, real.max),
        (VariableType::Integer { min, max, .. }, Value::Integer(number)) => {
            (f64::from(*number), min.map(f64::from), max.map(f64::from))
        }
        _ => return None,
    };
    let unit = variable.unit().map(|unit| format!(" {unit}")).unwrap_or_default();
    let is_outside = min.is_some_and(|min| number < min) || max.is_some_and(|max| number > max);
    is_outside.then(|| match (min.map(names::number), max.map(names::number)) {
        (Some(min), Some(max)) => format!("from {min} to {max}{unit}"),
        (Some(min), None) => format!("at least {min}{unit}"),
        (None, max) => format!("at most {}{unit}", max.unwrap_or_default()),
    })
}

/// A number with its unit behind it, such as `3 deg`, as a value of a variable; `None` if it is none.
fn in_own_unit(
    value: &Value,
    variable: &Variable,
    description: &ModelDescription,
) -> Option<Result<f64, UnitMismatch>> {
    const LONGEST: usize = 100;
    let Value::Text(text) = value else { return None };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| !number.is_nan());
    let ends = text.char_indices().map(|(at, _)| at).take(LONGEST).filter(|at| *at > 0);
    let (number, unit) = ends.filter_map(|at| Some((number(&text[..at])?, text[at..].trim()))).last()?;
    Units::of(description).value_for(variable, number, unit)
}

/// What to say about a name that no component has.
fn unknown<T: Target>(wanted: &str, targets: &[T]) -> SettingError {
    let components: Vec<String> = targets.iter().map(|target| target.name().to_owned()).collect();
    let split = wanted
        .split_once('.')
        .map(|(component, name)| (component, name, components.iter().position(|c| c == component)));
    match split {
        Some((component, name, Some(index))) => {
            let mut similar = similar_names(name, &targets[index..=index], Some(component));
            if similar.is_empty() {
                similar = targets
                    .iter()
                    .filter(|target| target.description().index_of(name).is_some())
                    .map(|target| format!("{}.{name}", target.name()))
                    .collect();
            }
            SettingError::Unknown { target: name.to_owned(), components: vec![component.to_owned()], similar }
        }
        // A dot may also belong to a variable's own name.
        Some((component, name, None)) if similar_names(wanted, targets, None).is_empty() => {
            let close = closest(component, components.iter().map(String::as_str));
            let similar = close.into_iter().map(|component| format!("{component}.{name}")).collect();
            SettingError::UnknownComponent { component: component.to_owned(), components, similar }
        }
        _ => {
            let similar = similar_names(wanted, targets, None);
            SettingError::Unknown { target: wanted.to_owned(), components, similar }
        }
    }
}

/// The settable variables whose names come closest, and those that say this word of themselves, with `prefix.` in front.
fn similar_names<T: Target>(wanted: &str, targets: &[T], prefix: Option<&str>) -> Vec<String> {
    const SHOWN: usize = 5;
    let settable = || {
        targets.iter().flat_map(|target| {
            let variables = target.description().variables.iter().enumerate();
            let free = variables.filter(|(index, it)| it.is_settable() && target.driven_by(*index).is_none());
            free.map(|(_, variable)| variable)
        })
    };
    let prefix = prefix.map(|component| format!("{component}.")).unwrap_or_default();
    let mut names = closest(wanted, settable().map(|variable| variable.name.as_str()));
    let word = wanted.to_lowercase();
    let says = |variable: &&Variable| {
        let text = variable.description.as_deref().unwrap_or_default().to_lowercase();
        text.split(|letter: char| !letter.is_alphanumeric()).any(|said| said == word)
    };
    for variable in settable().filter(says) {
        if names.len() < SHOWN && !names.contains(&variable.name.as_str()) {
            names.push(&variable.name);
        }
    }
    names.into_iter().map(|name| format!("{prefix}{name}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_split_at_the_first_equals_sign() {
        assert_eq!("EI1=0.2".parse(), Ok(Setting::new("EI1", "0.2")));
        assert_eq!(" a.b[1] = x=y ".parse(), Ok(Setting::new("a.b[1]", "x=y")));
        assert!("EI1".parse::<Setting>().is_err());
        assert!("=1".parse::<Setting>().is_err());
    }
}
