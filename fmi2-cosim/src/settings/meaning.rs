//! The variables that a name means, and obstacles to setting them.

use super::fit::fitted;
use super::{Setting, SettingError};
use crate::names::closest;
use crate::signal::Signal;
use fmi2_import::description::BaseType;
use fmi2_import::{Causality, ModelDescription, Value, Variability, Variable};

/// A component as settings see it. It need not run yet: everything except a refusal by the FMU is known before.
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
        // A name may be one component's output and another one's parameter: it means the one that can be set.
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
        return Some(driven(source));
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
        return Some(driven(source));
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

fn driven(source: &str) -> String {
    format!("it is an input that {source} drives, which would replace the value; leave it out")
}

/// The error for a name that no component has.
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

/// The settable variables with this name in other letters, those whose description begins with this word, the shortest first, those whose names
/// end with it, those with the closest names, and those whose description contains it, with `prefix.` in front.
fn similar_names<T: Target>(wanted: &str, targets: &[T], prefix: Option<&str>) -> Vec<String> {
    const SHOWN: usize = 5;
    /// Of those whose description begins with the word: other reasons count, too.
    const BEGINNING: usize = 2;
    let settable = || {
        targets.iter().flat_map(|target| {
            let variables = target.description().variables.iter().enumerate();
            let free = variables.filter(|(index, it)| it.is_settable() && target.driven_by(*index).is_none());
            free.map(|(_, variable)| variable)
        })
    };
    let prefix = prefix.map(|component| format!("{component}.")).unwrap_or_default();
    let word = wanted.to_lowercase();
    let says =
        |text: &str| text.to_lowercase().split(|letter: char| !letter.is_alphanumeric()).any(|said| said == word);
    let ends = |name: &str| name.to_lowercase().strip_suffix(&word).is_some_and(|begin| begin.ends_with('_'));
    let same = settable().map(|variable| variable.name.as_str()).filter(|name| name.to_lowercase() == word);
    let begins = |text: &str| {
        let text = text.to_lowercase();
        text.strip_prefix(&word).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
    };
    let length = |variable: &&Variable| variable.description.as_ref().map_or(0, String::len);
    let mut beginning: Vec<_> =
        settable().filter(|variable| variable.description.as_deref().is_some_and(begins)).collect();
    beginning.sort_by_key(length);
    let beginning = beginning.into_iter().map(|variable| variable.name.as_str()).take(BEGINNING);
    let named = settable().filter(|variable| ends(&variable.name)).map(|variable| variable.name.as_str());
    let described = settable().filter(|variable| variable.description.as_deref().is_some_and(says));
    let described = described.map(|variable| variable.name.as_str());
    let mut names: Vec<&str> = Vec::new();
    let close = closest(wanted, settable().map(|variable| variable.name.as_str()));
    for name in same.chain(beginning).chain(named).chain(close).chain(described) {
        if names.len() < SHOWN && !names.contains(&name) {
            names.push(name);
        }
    }
    names.into_iter().map(|name| format!("{prefix}{name}")).collect()
}
