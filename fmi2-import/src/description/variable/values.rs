//! Which values a variable takes, and how they may be written.

use super::{BaseType, Variable};
use crate::value::{Mismatch, Value, truth, whole};

impl Variable {
    /// The value of a text: a number, `true` or `false` (or 1 and 0), an item's name or number, or the text itself.
    ///
    /// # Errors
    /// When the text has no value of this type; the error says what is expected. No real variable accepts NaN.
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

    /// A value as one of this variable's type. Whole numbers may be given as reals or integers, truth values as 1 and 0,
    /// items of enumerations by name or number; a text is read by [`Variable::parse`].
    ///
    /// # Errors
    /// When it does not fit the type; the error says what is expected.
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
            BaseType::Real => {
                self.unit_in_text().map_or_else(|| "a number".into(), |unit| format!("a number in {unit}"))
            }
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
