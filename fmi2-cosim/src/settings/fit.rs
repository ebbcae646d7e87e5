//! Conversion of values to a variable's type, unit and range.

use super::SettingError;
use super::meaning::Target;
use crate::names;
use crate::units::{UnitMismatch, Units};
use fmi2_import::{Mismatch, ModelDescription, Value, Variable, VariableType};

/// A value as one of this variable's type, within its range.
pub(super) fn fitted<T: Target>(target: &T, index: usize, given: &Value) -> Result<Value, SettingError> {
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
            None => {
                let is_name = |text: &str| text.starts_with(|letter: char| !letter.is_ascii_punctuation());
                let expected = match with_unit(given) {
                    Some((_, rest)) if rest.contains('=') => {
                        format!("{} (set each of several variables by itself)", mismatch.expected)
                    }
                    Some((_, unit)) if is_name(unit) && variable.unit_in_text().is_some() => {
                        format!("{} (the FMU defines no unit \"{unit}\")", mismatch.expected)
                    }
                    _ => mismatch.expected,
                };
                return Err(wrong(Mismatch { expected, ..mismatch }));
            }
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
    let unit = variable.unit_in_text().map(|unit| format!(" {unit}")).unwrap_or_default();
    let is_outside = min.is_some_and(|min| number < min) || max.is_some_and(|max| number > max);
    is_outside.then(|| match (min.map(names::number), max.map(names::number)) {
        (Some(min), Some(max)) => format!("from {min} to {max}{unit}"),
        (Some(min), None) => format!("at least {min}{unit}"),
        (None, max) => format!("at most {}{unit}", max.unwrap_or_default()),
    })
}

/// A number followed by its unit, such as `3 deg`, as a value of a variable; `None` if the text is not of this form.
fn in_own_unit(
    value: &Value,
    variable: &Variable,
    description: &ModelDescription,
) -> Option<Result<f64, UnitMismatch>> {
    let (number, unit) = with_unit(value)?;
    Units::of(description).value_for(variable, number, unit)
}

/// A text as a number and what follows it, the longest number that there is.
fn with_unit(value: &Value) -> Option<(f64, &str)> {
    const LONGEST: usize = 100;
    let Value::Text(text) = value else { return None };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| !number.is_nan());
    let ends = text.char_indices().map(|(at, _)| at).take(LONGEST).filter(|at| *at > 0);
    ends.filter_map(|at| Some((number(&text[..at])?, text[at..].trim()))).last()
}
