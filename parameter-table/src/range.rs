//! Admissible values, and the message about others.

use std::fmt;

/// An interval of admissible values, closed at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least admissible value.
    pub min: f64,
    /// The greatest admissible value.
    pub max: f64,
}

impl Range {
    /// All numbers but NaN; infinite ones, too.
    pub const ANY: Self = Self::new(f64::NEG_INFINITY, f64::INFINITY);

    /// The interval from `min` to `max`.
    #[must_use]
    pub const fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    /// Whether `value` is admissible; never so for NaN.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }
}

/// The values a parameter may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Admissible {
    /// Those of a range.
    Within(Range),
    /// Greater than another parameter (its name and value), up to a limit.
    Above(&'static str, f64, f64),
    /// Less than another parameter (its name and value), down to a limit.
    Below(&'static str, f64, f64),
}

impl Admissible {
    /// Whether a value is one of them; never so for NaN.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        match self {
            Self::Within(range) => range.contains(value),
            Self::Above(_, other, limit) => value > other && value <= limit,
            Self::Below(_, other, limit) => value < other && value >= limit,
        }
    }

    /// Checks a value of the parameter `name`.
    ///
    /// # Errors
    /// If it is not admissible.
    pub fn check(self, name: &str, value: f64) -> Result<(), InvalidParameter> {
        if self.contains(value) {
            Ok(())
        } else {
            Err(InvalidParameter { name: name.to_owned(), value, admissible: self })
        }
    }
}

impl fmt::Display for Admissible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Within(Range { min, max }) => write!(f, "between {} and {}", plain(min), plain(max)),
            Self::Above(name, other, limit) => {
                write!(f, "greater than {name} = {} and at most {}", plain(other), plain(limit))
            }
            Self::Below(name, other, limit) => {
                write!(f, "less than {name} = {} and at least {}", plain(other), plain(limit))
            }
        }
    }
}

/// A number with the fewest digits that read back, whole ones without a point: limits of an order are 4 and 24, not 4.0 and 24.0.
fn plain(value: f64) -> String {
    let mut text = format!("{value:?}");
    if text.ends_with(".0") {
        text.truncate(text.len() - 2);
    }
    text
}

/// A parameter with a value that is not admissible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("parameter {name} = {} is not admissible: it must be {admissible}", plain(*.value))]
pub struct InvalidParameter {
    /// The parameter's name.
    pub name: String,
    /// The refused value.
    pub value: f64,
    /// The admissible values.
    pub admissible: Admissible,
}
