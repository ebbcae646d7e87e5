//! A parameter set (SSV): names and values (SSP 1.0.1, section 6).

use std::sync::Arc;

use super::structure::{Line, Origin};
use fmi2_import::Value;
use fmi2_import::description::{Item, Unit};

/// One `.ssv` document, or the same thing inside an `.ssd`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterSet {
    /// Name of the set. Ecos and `libcosim` choose sets by it.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// The parameters, in the order of the file.
    pub parameters: Vec<ParameterValue>,
    /// Enumerations that parameters refer to: name and items.
    pub enumerations: Vec<(String, Arc<[Item]>)>,
    /// Units that parameters refer to.
    pub units: Vec<Unit>,
    /// Where the file comes from.
    pub origin: Origin,
}

/// A name and its value.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterValue {
    /// Name of the variable.
    pub name: String,
    /// Its value; of an enumeration, the item's name.
    pub value: Value,
    /// The unit or enumeration that the value refers to.
    pub refers_to: Reference,
    /// Where it is declared.
    pub line: Line,
}

/// Definitions that a parameter's value refers to.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Reference {
    /// None: the value is complete.
    #[default]
    Nothing,
    /// The unit of a real number.
    Unit(String),
    /// The enumeration that the text is an item of, by name if the file has one.
    Enumeration(Option<String>),
}

impl Reference {
    /// The unit, if it is one.
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        match self {
            Self::Unit(name) => Some(name),
            Self::Nothing | Self::Enumeration(_) => None,
        }
    }
}

impl From<Option<String>> for Reference {
    /// The unit of this name, if there is one.
    fn from(unit: Option<String>) -> Self {
        unit.map_or(Self::Nothing, Self::Unit)
    }
}
