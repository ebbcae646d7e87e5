//! Settings by name, unit and range, in tables that serve checks and declarations alike.

use std::fmt;

/// One number among the settings `T` of a signal.
#[derive(Debug)]
pub struct Field<T> {
    /// What stands behind the signal's name: `_noise`.
    pub suffix: &'static str,
    /// Unit; `None` for that of the signal.
    pub unit: Option<&'static str>,
    /// Whether the unit is that of the signal per second.
    pub per_second: bool,
    /// The least and the greatest admissible value.
    pub range: (f64, f64),
    /// What it is, in words that a signal's name follows.
    pub description: &'static str,
    /// Reads it.
    pub get: fn(&T) -> f64,
    /// Where it is.
    pub field: fn(&mut T) -> &mut f64,
}

/// A setting that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value:?} cannot be used: {reason}")]
pub struct SettingError {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Why, and what to do.
    pub reason: String,
}

impl SettingError {
    pub(crate) fn new(name: impl Into<String>, value: f64, reason: impl fmt::Display) -> Self {
        Self { name: name.into(), value, reason: reason.to_string() }
    }
}

/// Checks all numbers of a signal's settings against their ranges.
pub(crate) fn check_ranges<T>(fields: &[Field<T>], signal: &str, settings: &T) -> Result<(), SettingError> {
    for field in fields {
        check_range(&format!("{signal}{}", field.suffix), (field.get)(settings), field.range)?;
    }
    Ok(())
}

/// Checks a number against its range; NaN is in none.
pub(crate) fn check_range(name: &str, value: f64, (min, max): (f64, f64)) -> Result<(), SettingError> {
    if min <= value && value <= max {
        return Ok(());
    }
    Err(SettingError::new(name, value, format_args!("it must be between {min:e} and {max:e}")))
}
