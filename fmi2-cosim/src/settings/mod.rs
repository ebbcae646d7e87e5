//! Values that a user sets by name: `name=value` or `Component.name=value`.
//!
//! `meaning` finds the variables that a name means, `fit` converts values to their types.

mod fit;
mod meaning;

use std::fmt;
use std::str::FromStr;

use crate::names::suggestion;
use fmi2_import::{CallError, Value};

pub(crate) use meaning::{Place, Target, check, check_one, meant, obstacle_to_driving};

/// A value for a variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// `name` (in every component that has it) or `Component.name`.
    pub target: String,
    /// Its value. The variable's type determines how a text from the command line is read.
    pub value: Value,
}

/// Why a setting cannot be applied.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// No component has such a variable.
    #[error("there is no variable \"{target}\" in {}{}", .components.join(" or "), suggestion(.similar))]
    Unknown {
        /// The target as the user wrote it.
        target: String,
        /// The components that were searched.
        components: Vec<String>,
        /// Settable variables with similar names.
        similar: Vec<String>,
    },
    /// The part before the dot is not a component.
    #[error("there is no component \"{component}\"; the components are {}{}", .components.join(", "), suggestion(.similar))]
    UnknownComponent {
        /// The part before the dot.
        component: String,
        /// All components.
        components: Vec<String>,
        /// Names that the user may have meant.
        similar: Vec<String>,
    },
    /// The user must not set this variable.
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
        /// The value as the user wrote it.
        value: String,
        /// The expected kind of value.
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
        /// The given value.
        value: Value,
    },
    /// The FMU refused the value.
    #[error("{setting} is refused: {source}")]
    Refused {
        /// The setting.
        setting: Setting,
        /// The error of the FMU.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_split_at_the_first_equals_sign() {
        assert_eq!("EI1=0.2".parse(), Ok(Setting::new("EI1", "0.2")));
        assert_eq!(" a.b[1] = x=y ".parse(), Ok(Setting::new("a.b[1]", "x=y")));
        assert!("EI1".parse::<Setting>().is_err());
        assert!("=1".parse::<Setting>().is_err());
        // Whether this is one text or two settings only the variable's type says.
        assert_eq!("label=1,b=c".parse(), Ok(Setting::new("label", "1,b=c")));
    }
}
