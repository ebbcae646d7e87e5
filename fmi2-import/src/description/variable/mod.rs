//! A variable: its causality, variability, type, range, and the values it accepts.

mod values;

use std::sync::Arc;

use crate::value::Value;

/// Gives an enum the names that the standard's XML has for its variants.
macro_rules! named {
    ($type:ident: $($variant:ident = $name:literal),*) => {
        impl $type {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The name in XML.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// The one of this name in XML.
            #[must_use]
            pub fn from_name(name: &str) -> Option<Self> {
                match name {
                    $($name => Some(Self::$variant),)*
                    _ => None,
                }
            }
        }
    };
}

named!(Causality: Parameter = "parameter", CalculatedParameter = "calculatedParameter", Input = "input",
    Output = "output", Local = "local", Independent = "independent");
named!(Variability: Constant = "constant", Fixed = "fixed", Tunable = "tunable", Discrete = "discrete",
    Continuous = "continuous");
named!(Initial: Exact = "exact", Approx = "approx", Calculated = "calculated");
named!(BaseType: Real = "Real", Integer = "Integer", Boolean = "Boolean", String = "String",
    Enumeration = "Enumeration");

/// One item of an enumeration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// Name of the item.
    pub name: String,
    /// Value that crosses the C interface.
    pub value: i32,
    /// One sentence about the item.
    pub description: Option<String>,
}

/// One variable.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// Handle for the C interface; several variables of one base type may share it.
    pub value_reference: u32,
    /// One sentence about the variable.
    pub description: Option<String>,
    /// Its role.
    pub causality: Causality,
    /// When its value may change.
    pub variability: Variability,
    /// How its initial value is determined; `None` where the standard defines none (inputs, independent).
    pub initial: Option<Initial>,
    /// Base type with start value, unit and range.
    pub kind: VariableType,
}

/// A variable's role.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set by the user before (or, if tunable, during) the simulation.
    Parameter,
    /// Follows from other parameters.
    CalculatedParameter,
    /// Set by another model or the user during the simulation.
    Input,
    /// Offered to other models.
    Output,
    /// Internal.
    Local,
    /// The independent variable, time.
    Independent,
}

/// When a variable's value may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Never.
    Constant,
    /// Not after initialisation.
    Fixed,
    /// Between steps, by the user.
    Tunable,
    /// At events.
    Discrete,
    /// Always.
    Continuous,
}

/// How an initial value comes about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// The start value holds.
    Exact,
    /// The start value is a guess.
    Approx,
    /// The model computes it.
    Calculated,
}

/// A variable's base type with its attributes.
#[derive(Debug, Clone, PartialEq)]
pub enum VariableType {
    /// A real number.
    Real(RealAttributes),
    /// A 32-bit integer.
    Integer {
        /// Start value.
        start: Option<i32>,
        /// Smallest value.
        min: Option<i32>,
        /// Largest value.
        max: Option<i32>,
    },
    /// True or false.
    Boolean {
        /// Start value.
        start: Option<bool>,
    },
    /// Text.
    String {
        /// Start value.
        start: Option<String>,
    },
    /// One of the items of a declared type.
    Enumeration {
        /// Index of the type in [`ModelDescription::types`](super::ModelDescription::types).
        declared_type: Option<usize>,
        /// The items of the type, in the order of the file; the variables of one type share them.
        items: Arc<[Item]>,
        /// Start value.
        start: Option<i32>,
    },
}

/// Attributes of a real variable; those it inherits from its declared type are filled in.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RealAttributes {
    /// Start value.
    pub start: Option<f64>,
    /// Unit, a name in [`ModelDescription::units`](super::ModelDescription::units).
    pub unit: Option<String>,
    /// Unit for display.
    pub display_unit: Option<String>,
    /// Physical quantity.
    pub quantity: Option<String>,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
    /// Usual size.
    pub nominal: Option<f64>,
    /// Index (from 0) of the variable this one is the time derivative of.
    pub derivative: Option<usize>,
    /// Differences matter, not the absolute value.
    pub relative_quantity: bool,
}

/// The base types that cross the C interface by functions of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaseType {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer`.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
    /// `fmi2String`.
    String,
    /// `fmi2Integer` with named values.
    Enumeration,
}

impl Variable {
    /// Base type.
    #[must_use]
    pub fn base_type(&self) -> BaseType {
        self.kind.base_type()
    }

    /// Unit of a real variable.
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        match &self.kind {
            VariableType::Real(real) => real.unit.as_deref(),
            _ => None,
        }
    }

    /// The unit to be written behind a value: none behind a pure number, whose unit is `1`.
    #[must_use]
    pub fn unit_in_text(&self) -> Option<&str> {
        self.unit().filter(|unit| *unit != "1")
    }

    /// The items of an enumeration variable; empty for every other type, and without a declared type.
    #[must_use]
    pub fn items(&self) -> &[Item] {
        match &self.kind {
            VariableType::Enumeration { items, .. } => items,
            _ => &[],
        }
    }

    /// The start value, if the file has one.
    #[must_use]
    pub fn start(&self) -> Option<Value> {
        match &self.kind {
            VariableType::Real(real) => real.start.map(Value::Real),
            VariableType::Integer { start, .. } | VariableType::Enumeration { start, .. } => start.map(Value::Integer),
            VariableType::Boolean { start } => start.map(Value::Boolean),
            VariableType::String { start } => start.clone().map(Value::Text),
        }
    }

    /// Whether a user may set it before initialisation: parameters, inputs, and variables whose start value is used.
    #[must_use]
    pub fn is_settable(&self) -> bool {
        self.variability != Variability::Constant
            && (self.causality == Causality::Input || matches!(self.initial, Some(Initial::Exact | Initial::Approx)))
    }
}

impl VariableType {
    /// Base type.
    #[must_use]
    pub fn base_type(&self) -> BaseType {
        match self {
            Self::Real(_) => BaseType::Real,
            Self::Integer { .. } => BaseType::Integer,
            Self::Boolean { .. } => BaseType::Boolean,
            Self::String { .. } => BaseType::String,
            Self::Enumeration { .. } => BaseType::Enumeration,
        }
    }
}
