//! A parameter set (SSV): names and values (SSP 1.0.1, section 6).

use std::sync::Arc;

use super::structure::Line;
use fmi2_import::description::{Item, Unit};

/// One `.ssv` document, or the same thing inside an `.ssd`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterSet {
    /// Name of the set. Ecos and `libcosim` choose sets by it.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// The parameters, in the order of the file.
    pub parameters: Vec<Parameter>,
    /// Enumerations that parameters refer to: name and items.
    pub enumerations: Vec<(String, Arc<[Item]>)>,
    /// Units that parameters refer to.
    pub units: Vec<Unit>,
}

/// A name and its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name of the variable.
    pub name: String,
    /// Its value.
    pub value: Value,
    /// Where it is declared.
    pub line: Line,
}

/// A value of one of the types of FMI 2.0.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A real number in a unit.
    Real(f64, Option<String>),
    /// An integer.
    Integer(i32),
    /// True or false.
    Boolean(bool),
    /// Text.
    String(String),
    /// An enumeration's item by its name, and the enumeration's name.
    Enumeration(String, Option<String>),
}
