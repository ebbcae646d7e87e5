//! A variable: its role, when it changes, its type and its range, and what values it takes.

use std::sync::Arc;

use crate::value::{Mismatch, Value, truth, whole};

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
                Self::ALL.iter().copied().find(|each| each.name() == name)
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
    /// How its initial value comes about; `None` where the standard defines none (inputs, independent).
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

    /// Whether a user may set it before initialisation: parameters, inputs, and whatever has a start value that counts.
    #[must_use]
    pub fn is_settable(&self) -> bool {
        self.variability != Variability::Constant
            && (self.causality == Causality::Input || matches!(self.initial, Some(Initial::Exact | Initial::Approx)))
    }

    /// The value a text stands for: a number, `true` or `false` (or 1 and 0), an item's name or number, or the text itself.
    ///
    /// # Errors
    /// When it stands for none; says what is needed. No real variable takes NaN.
    pub fn parse(&self, text: &str) -> Result<Value, Mismatch> {
        let value = match self.base_type() {
            BaseType::Real => text.parse().ok().filter(|value: &f64| !value.is_nan()).map(Value::Real),
            BaseType::Integer => text.parse().ok().map(Value::Integer),
            BaseType::Boolean => truth(text).map(Value::Boolean),
            BaseType::String => Some(Value::Text(text.to_owned())),
            BaseType::Enumeration => {
                let named = self.items().iter().find(|item| item.name == text).map(|item| item.value);
                named.or_else(|| text.parse().ok().filter(|number| self.has_item(*number))).map(Value::Integer)
            }
        };
        value.ok_or_else(|| self.mismatch(text.to_owned()))
    }

    /// A value as one of this variable's type: whole numbers may be written as reals or integers, truth values as 1 and 0,
    /// items of enumerations by name or number, and texts stand for what [`Variable::parse`] reads in them.
    ///
    /// # Errors
    /// When it does not fit the type; says what is needed.
    pub fn value(&self, given: &Value) -> Result<Value, Mismatch> {
        let number = match given {
            Value::Text(text) => return self.parse(text),
            Value::Boolean(value) if self.base_type() == BaseType::Boolean => return Ok(Value::Boolean(*value)),
            // A truth value is no number, but may be an item's name, or text.
            Value::Boolean(value) => return self.parse(&value.to_string()),
            Value::Real(number) => *number,
            Value::Integer(number) => f64::from(*number),
        };
        let value = match self.base_type() {
            BaseType::Real => Some(number).filter(|number| !number.is_nan()).map(Value::Real),
            BaseType::Integer => whole(number).map(Value::Integer),
            BaseType::Boolean => {
                whole(number).filter(|number| [0, 1].contains(number)).map(|one| Value::Boolean(one == 1))
            }
            BaseType::String => Some(Value::Text(given.to_string())),
            BaseType::Enumeration => whole(number).filter(|number| self.has_item(*number)).map(Value::Integer),
        };
        value.ok_or_else(|| self.mismatch(given.to_string()))
    }

    /// A value of this variable with items of enumerations by name, where they have one.
    #[must_use]
    pub fn with_name(&self, value: Value) -> Value {
        match value {
            Value::Integer(number) => {
                let item = self.items().iter().find(|item| item.value == number);
                item.map_or(value, |item| Value::Text(item.name.clone()))
            }
            other => other,
        }
    }

    /// Whether an enumeration has an item of this number. Without a list of items any number may be right.
    fn has_item(&self, number: i32) -> bool {
        self.items().is_empty() || self.items().iter().any(|item| item.value == number)
    }

    fn mismatch(&self, value: String) -> Mismatch {
        let expected = match self.base_type() {
            BaseType::Real => self.unit().map_or_else(|| "a number".into(), |unit| format!("a number in {unit}")),
            BaseType::Integer => "an integer".into(),
            BaseType::Boolean => "true or false".into(),
            BaseType::String => "a text".into(),
            BaseType::Enumeration => {
                let names: Vec<_> = self.items().iter().map(|item| item.name.as_str()).collect();
                format!("one of {}", names.join(", "))
            }
        };
        Mismatch { value, expected }
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
