//! Values of variables: many of one type at once, or one of any type.

use std::ffi::CString;
use std::ptr;

use super::{Instance, Result};
use crate::description::{BaseType, Variable};
use crate::error::CallError;
use crate::library::{Status, ValueReference, text};
use crate::value::Value;

impl Instance {
    /// The value of a variable.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn get(&mut self, variable: &Variable) -> Result<Value> {
        let reference = [variable.value_reference];
        Ok(match variable.base_type() {
            BaseType::Real => {
                let mut value = [0.0];
                self.get_real(&reference, &mut value)?;
                Value::Real(value[0])
            }
            BaseType::Integer | BaseType::Enumeration => {
                let mut value = [0];
                self.get_integer(&reference, &mut value)?;
                Value::Integer(value[0])
            }
            BaseType::Boolean => {
                let mut value = [false];
                self.get_boolean(&reference, &mut value)?;
                Value::Boolean(value[0])
            }
            BaseType::String => Value::Text(self.get_string(variable.value_reference)?),
        })
    }

    /// Sets a variable to a value, as [`Variable::value`] converts it.
    ///
    /// # Errors
    /// When the value does not fit the variable's type, or the slave refuses it.
    pub fn set(&mut self, variable: &Variable, value: &Value) -> Result<Status> {
        let fitted = variable.value(value).map_err(|source| CallError::Value {
            instance: self.name.clone(),
            variable: variable.name.clone(),
            source: Box::new(source),
        })?;
        let reference = [variable.value_reference];
        match fitted {
            Value::Real(value) => self.set_real(&reference, &[value]),
            Value::Integer(value) => self.set_integer(&reference, &[value]),
            Value::Boolean(value) => self.set_boolean(&reference, &[value]),
            Value::Text(value) => self.set_string(variable.value_reference, &value),
        }
    }

    /// `fmi2GetReal` for many variables at once.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn get_real(&mut self, references: &[ValueReference], values: &mut [f64]) -> Result<Status> {
        self.together(|calls| calls.get_real(references, values))
    }

    /// `fmi2SetReal` for many variables at once.
    ///
    /// # Errors
    /// When the slave refuses a value.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn set_real(&mut self, references: &[ValueReference], values: &[f64]) -> Result<Status> {
        self.together(|calls| calls.set_real(references, values))
    }

    /// `fmi2GetInteger` for many variables at once, integers and enumerations.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn get_integer(&mut self, references: &[ValueReference], values: &mut [i32]) -> Result<Status> {
        self.together(|calls| calls.get_integer(references, values))
    }

    /// `fmi2SetInteger` for many variables at once, integers and enumerations.
    ///
    /// # Errors
    /// When the slave refuses a value.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn set_integer(&mut self, references: &[ValueReference], values: &[i32]) -> Result<Status> {
        self.together(|calls| calls.set_integer(references, values))
    }

    /// `fmi2GetBoolean` for many variables.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn get_boolean(&mut self, references: &[ValueReference], values: &mut [bool]) -> Result<Status> {
        self.together(|calls| calls.get_boolean(references, values))
    }

    /// `fmi2SetBoolean` for many variables.
    ///
    /// # Errors
    /// When the slave refuses a value.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn set_boolean(&mut self, references: &[ValueReference], values: &[bool]) -> Result<Status> {
        self.together(|calls| calls.set_boolean(references, values))
    }

    /// `fmi2GetString` for one variable.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn get_string(&mut self, reference: ValueReference) -> Result<String> {
        let get = self.functions().get_string;
        let mut value = ptr::null();
        self.together(|calls| {
            calls.exchange("fmi2GetString", &[reference], 1, |component, references, count| {
                // SAFETY: living component, one reference and room for one pointer.
                unsafe { get(component, references, count, &raw mut value) }
            })
        })?;
        // SAFETY: the slave returned a C string (or null), which is valid until the next call.
        Ok(unsafe { text(value) })
    }

    /// `fmi2SetString` for one variable.
    ///
    /// # Errors
    /// When the slave refuses the value, or the value has a zero byte inside.
    pub fn set_string(&mut self, reference: ValueReference, value: &str) -> Result<Status> {
        let c_value = CString::new(value)
            .map_err(|_| CallError::ZeroByte { instance: self.name.clone(), text: value.to_owned() })?;
        let pointer = c_value.as_ptr();
        let set = self.functions().set_string;
        self.together(|calls| {
            calls.exchange("fmi2SetString", &[reference], 1, |component, references, count| {
                // SAFETY: living component, one reference and one C string, which lives until the end of this function.
                unsafe { set(component, references, count, &raw const pointer) }
            })
        })
    }
}
