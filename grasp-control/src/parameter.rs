//! Parameters by their names in the interface: unit, admissible range, access.

use std::fmt;
use thiserror::Error;

/// One real parameter of an owner `T`.
#[derive(Debug)]
pub struct Parameter<T> {
    /// Name in the interface, for example `c31`.
    pub name: &'static str,
    /// SI unit in FMI's notation, `1` for a pure number.
    pub unit: &'static str,
    /// One line for the user.
    pub description: &'static str,
    /// Admissible values.
    pub range: Range,
    /// Reads the parameter.
    pub get: fn(&T) -> f64,
    /// Where the parameter is, to be written unchecked.
    pub field: fn(&mut T) -> &mut f64,
}

/// Declares a [`Parameter`]: name, unit, range, description, path of the field.
macro_rules! parameter {
    ($name:expr, $unit:literal, $range:expr, $description:expr, $($field:tt)+) => {
        $crate::parameter::Parameter {
            name: $name,
            unit: $unit,
            description: $description,
            range: $range,
            get: |owner| owner.$($field)+,
            field: |owner| &mut owner.$($field)+,
        }
    };
}

/// An interval of admissible values, closed at both ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Smallest admissible value.
    pub min: f64,
    /// Largest admissible value.
    pub max: f64,
}

impl Range {
    /// A gain: zero or positive.
    pub const GAIN: Self = Self::from(0.0, 1e6);
    /// Something that divides: positive.
    pub const DIVISOR: Self = Self::from(1e-9, 1e9);

    /// The interval from `min` to `max`.
    #[must_use]
    pub const fn from(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    /// Whether `value` is admissible; never so for NaN.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{:e}, {:e}]", self.min, self.max)
    }
}

/// A parameter outside its admissible range.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("parameter {name} = {value} is not in its admissible range {range}")]
pub struct ParameterError {
    /// Name in the interface.
    pub name: &'static str,
    /// The offending value.
    pub value: f64,
    /// The admissible values.
    pub range: Range,
}

/// Checks one value against its range.
pub(crate) fn check_value(name: &'static str, value: f64, range: Range) -> Result<(), ParameterError> {
    if range.contains(value) { Ok(()) } else { Err(ParameterError { name, value, range }) }
}

/// Checks all parameters of an owner, in the order of their table.
pub(crate) fn check<'a, T: 'a>(
    parameters: impl IntoIterator<Item = &'a Parameter<T>>,
    owner: &T,
) -> Result<(), ParameterError> {
    parameters.into_iter().try_for_each(|p| check_value(p.name, (p.get)(owner), p.range))
}
