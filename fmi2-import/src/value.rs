//! One value of a variable, with the type it has at the C interface.

use std::fmt;

/// A value of one of the types that cross the C interface of FMI 2.0. An enumeration's value is the [`Value::Integer`]
/// of its item, or as [`Value::Text`] the item's name, which [`Variable::value`](crate::Variable::value) accepts.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// `fmi2Real`.
    Real(f64),
    /// `fmi2Integer`, also of enumerations.
    Integer(i32),
    /// `fmi2Boolean`.
    Boolean(bool),
    /// `fmi2String`.
    Text(String),
}

/// A value that does not fit the variable's type.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{expected} is needed, not \"{value}\"")]
pub struct Mismatch {
    /// The given value.
    pub value: String,
    /// The expected kind of value, in words: `a number in m`, `true or false`, `one of slow, fast`.
    pub expected: String,
}

/// As a user would write it: the shortest decimal that reads back, `true` or `false`, the text itself.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Real(value) => {
                let text = format!("{value:?}");
                f.write_str(text.strip_suffix(".0").unwrap_or(&text))
            }
            Self::Integer(value) => write!(f, "{value}"),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Text(value) => f.write_str(value),
        }
    }
}

macro_rules! from {
    ($($type:ty => $variant:ident),*) => {
        $(impl From<$type> for Value {
            fn from(value: $type) -> Self {
                Self::$variant(value.into())
            }
        })*
    };
}
from!(f64 => Real, i32 => Integer, bool => Boolean, String => Text, &str => Text);

/// The truth value of a text in XML and on a command line.
pub(crate) fn truth(text: &str) -> Option<bool> {
    match text {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// The number as a 32-bit integer, if it is one.
pub(crate) fn whole(number: f64) -> Option<i32> {
    #[allow(clippy::cast_possible_truncation)] // compared with the number afterwards
    let integer = number as i32;
    (f64::from(integer) == number).then_some(integer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_numbers_of_32_bits_are_integers() {
        assert_eq!([2.0, -0.0, 2_147_483_647.0, -2_147_483_648.0].map(whole), [2, 0, i32::MAX, i32::MIN].map(Some));
        assert_eq!([0.5, 2_147_483_648.0, 1e300, f64::INFINITY, f64::NAN].map(whole), [None; 5]);
    }

    #[test]
    fn values_read_as_a_user_writes_them() {
        let values = [Value::from(1e-4), 0.1.into(), 8.0.into(), 1e300.into(), (-3).into(), true.into(), "fast".into()];
        assert_eq!(values.map(|value| value.to_string()), ["0.0001", "0.1", "8", "1e300", "-3", "true", "fast"]);
    }
}
