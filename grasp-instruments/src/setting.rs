//! Faults of settings.

use std::fmt;

use parameter_table::InvalidParameter;

/// A setting that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// It is outside of its range.
    #[error(transparent)]
    Range(#[from] InvalidParameter),
    /// It does not fit the others.
    #[error("{name} = {value:?} cannot be used: {reason}")]
    Unfit {
        /// Its name.
        name: String,
        /// Its value.
        value: f64,
        /// Why, and what to do.
        reason: String,
    },
}

impl SettingError {
    pub(crate) fn unfit(name: impl Into<String>, value: f64, reason: impl fmt::Display) -> Self {
        Self::Unfit { name: name.into(), value, reason: reason.to_string() }
    }
}
