//! Values a user gives to variables by name: `name=value` or `Component.name=value`.

use std::fmt;
use std::str::FromStr;

use crate::fmi::description::BaseType;
use crate::fmi::{CallError, Causality, Instance, ModelDescription, Variability, Variable};

/// A value for a variable, still as text: its meaning depends on the variable's type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// `name` (in every component that has it) or `Component.name`.
    pub target: String,
    /// Number, `true`/`false`, text, or the name of an enumeration's item.
    pub value: String,
}

/// Why a setting cannot be applied.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// No component has such a variable.
    #[error("there is no variable \"{target}\"{}", suggestion(.similar))]
    Unknown {
        /// What the user wrote.
        target: String,
        /// Settable variables with similar names.
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
    /// The FMU refused the value.
    #[error("{setting} is refused: {source}")]
    Refused {
        /// The setting.
        setting: Setting,
        /// What the FMU says.
        source: CallError,
    },
}

impl SettingError {
    /// Whether the user wrote something that cannot be, as opposed to a value an FMU does not like.
    #[must_use]
    pub fn is_usage(&self) -> bool {
        !matches!(self, Self::Refused { .. })
    }
}

fn suggestion(similar: &[String]) -> String {
    match similar {
        [] => String::new(),
        names => format!("; did you mean {}?", names.join(" or ")),
    }
}

impl Setting {
    /// A setting.
    #[must_use]
    pub fn new(target: impl Into<String>, value: impl Into<String>) -> Self {
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

/// A component as far as settings are concerned.
pub(crate) trait Target {
    fn name(&self) -> &str;
    fn instance(&mut self) -> &mut Instance;
    fn description(&self) -> &ModelDescription;
    /// Which output drives this input, if one does.
    fn driven_by(&self, variable: usize) -> Option<&str>;
}

/// Applies a setting to every component it means. Only valid before initialisation.
pub(crate) fn apply<T: Target>(setting: &Setting, targets: &mut [T]) -> Result<(), SettingError> {
    let meant: Vec<(usize, usize)> = targets
        .iter()
        .enumerate()
        .filter_map(|(index, target)| {
            let description = target.description();
            let local = || {
                let name = setting.target.strip_prefix(target.name())?.strip_prefix('.')?;
                description.index_of(name)
            };
            description.index_of(&setting.target).or_else(local).map(|variable| (index, variable))
        })
        .collect();
    if meant.is_empty() {
        return Err(SettingError::Unknown {
            target: setting.target.clone(),
            similar: similar_names(&setting.target, targets),
        });
    }
    // A name may be one component's output and another one's parameter: set it where it can be set.
    let obstacles: Vec<_> = meant.iter().map(|&(target, variable)| obstacle(&targets[target], variable)).collect();
    if let Some(Some(first)) = obstacles.first()
        && obstacles.iter().all(Option::is_some)
    {
        let (target, variable) = meant[0];
        return Err(SettingError::NotSettable {
            component: targets[target].name().to_owned(),
            name: targets[target].description().variables[variable].name.clone(),
            reason: first.clone(),
        });
    }
    for ((target, variable), obstacle) in meant.into_iter().zip(obstacles) {
        if obstacle.is_none() {
            set(&mut targets[target], variable, setting)?;
        }
    }
    Ok(())
}

fn obstacle<T: Target>(target: &T, index: usize) -> Option<String> {
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

fn set<T: Target>(target: &mut T, index: usize, setting: &Setting) -> Result<(), SettingError> {
    let variable = target.description().variables[index].clone();
    let text = setting.value.as_str();
    let wrong = |expected: String, target: &T| SettingError::Value {
        component: target.name().to_owned(),
        name: variable.name.clone(),
        value: text.to_owned(),
        expected,
    };
    let references = [variable.value_reference];
    let result = match variable.base_type() {
        BaseType::Real => match text.parse::<f64>() {
            Ok(value) if !value.is_nan() => target.instance().set_real(&references, &[value]),
            _ => return Err(wrong(format!("a number{}", in_unit(&variable)), target)),
        },
        BaseType::Integer => match text.parse() {
            Ok(value) => target.instance().set_integer(&references, &[value]),
            Err(_) => return Err(wrong("an integer".into(), target)),
        },
        BaseType::Boolean => match text {
            "true" | "1" => target.instance().set_boolean(&references, &[true]),
            "false" | "0" => target.instance().set_boolean(&references, &[false]),
            _ => return Err(wrong("true or false".into(), target)),
        },
        BaseType::String => target.instance().set_string(variable.value_reference, text),
        BaseType::Enumeration => {
            let items = target.description().items(&variable);
            let item = items
                .iter()
                .find(|item| item.name == text || item.value.to_string() == text)
                .map(|item| item.value)
                // Without a list of items any number may be right.
                .or_else(|| text.parse().ok().filter(|_| items.is_empty()));
            let Some(value) = item else {
                let names: Vec<_> = items.iter().map(|item| item.name.as_str()).collect();
                return Err(wrong(format!("one of {}", names.join(", ")), target));
            };
            target.instance().set_integer(&references, &[value])
        }
    };
    match result {
        Ok(_) => Ok(()),
        Err(source) => Err(SettingError::Refused { setting: setting.clone(), source }),
    }
}

fn in_unit(variable: &Variable) -> String {
    variable.unit().map(|unit| format!(" in {unit}")).unwrap_or_default()
}

/// The settable variables whose names come closest, best first.
fn similar_names<T: Target>(wanted: &str, targets: &[T]) -> Vec<String> {
    const SHOWN: usize = 3;
    const ALIKE: f64 = 0.8;
    let mut found: Vec<(f64, String)> = Vec::new();
    for target in targets {
        // With a component's name in front, only that component is meant.
        let (wanted, prefix) = match wanted.split_once('.') {
            Some((component, name)) if component == target.name() => (name, format!("{component}.")),
            Some((component, _)) if targets.iter().any(|other| other.name() == component) => continue,
            _ => (wanted, String::new()),
        };
        let description = target.description();
        for (index, variable) in description.variables.iter().enumerate() {
            if !variable.is_settable() || target.driven_by(index).is_some() {
                continue;
            }
            let score = strsim::jaro_winkler(&wanted.to_lowercase(), &variable.name.to_lowercase());
            let name = format!("{prefix}{}", variable.name);
            if score >= ALIKE && !found.iter().any(|(_, known)| *known == name) {
                found.push((score, name));
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().take(SHOWN).map(|(_, name)| name).collect()
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
