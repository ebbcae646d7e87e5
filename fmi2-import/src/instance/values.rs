//! Values of variables: many of one type at once, or one of any type.

use std::ffi::{CString, c_int};
use std::ptr;

use super::{Instance, Result};
use crate::description::{BaseType, Variable};
use crate::error::CallError;
use crate::floating_point::guarded;
use crate::library::{Component, Status, ValueReference, text};
use crate::value::Value;

/// Booleans that cross the C interface in one call.
const BOOLEANS: usize = 16;

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
        let get = self.functions().get_real;
        self.exchange("fmi2GetReal", references, values.len(), |component, references, count| {
            // SAFETY: living component, both arrays have `count` elements.
            unsafe { get(component, references, count, values.as_mut_ptr()) }
        })
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
        let set = self.functions().set_real;
        self.exchange("fmi2SetReal", references, values.len(), |component, references, count| {
            // SAFETY: living component, both arrays have `count` elements.
            unsafe { set(component, references, count, values.as_ptr()) }
        })
    }

    /// `fmi2GetInteger` for many variables at once, integers and enumerations.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn get_integer(&mut self, references: &[ValueReference], values: &mut [i32]) -> Result<Status> {
        let get = self.functions().get_integer;
        self.exchange("fmi2GetInteger", references, values.len(), |component, references, count| {
            // SAFETY: living component, both arrays have `count` elements.
            unsafe { get(component, references, count, values.as_mut_ptr()) }
        })
    }

    /// `fmi2SetInteger` for many variables at once, integers and enumerations.
    ///
    /// # Errors
    /// When the slave refuses a value.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn set_integer(&mut self, references: &[ValueReference], values: &[i32]) -> Result<Status> {
        let set = self.functions().set_integer;
        self.exchange("fmi2SetInteger", references, values.len(), |component, references, count| {
            // SAFETY: living component, both arrays have `count` elements.
            unsafe { set(component, references, count, values.as_ptr()) }
        })
    }

    /// `fmi2GetBoolean` for many variables.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn get_boolean(&mut self, references: &[ValueReference], values: &mut [bool]) -> Result<Status> {
        assert_eq!(references.len(), values.len());
        let get = self.functions().get_boolean;
        let mut worst = Status::Ok;
        for (references, values) in references.chunks(BOOLEANS).zip(values.chunks_mut(BOOLEANS)) {
            let mut c_values = [0; BOOLEANS];
            let status =
                self.exchange("fmi2GetBoolean", references, values.len(), |component, references, count| {
                    // SAFETY: living component, both arrays have at least `count` elements.
                    unsafe { get(component, references, count, c_values.as_mut_ptr()) }
                })?;
            worst = worst.max(status);
            for (value, c_value) in values.iter_mut().zip(&c_values) {
                *value = *c_value != 0;
            }
        }
        Ok(worst)
    }

    /// `fmi2SetBoolean` for many variables.
    ///
    /// # Errors
    /// When the slave refuses a value.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn set_boolean(&mut self, references: &[ValueReference], values: &[bool]) -> Result<Status> {
        assert_eq!(references.len(), values.len());
        let set = self.functions().set_boolean;
        let mut worst = Status::Ok;
        for (references, values) in references.chunks(BOOLEANS).zip(values.chunks(BOOLEANS)) {
            let mut c_values = [0; BOOLEANS];
            for (c_value, value) in c_values.iter_mut().zip(values) {
                *c_value = c_int::from(*value);
            }
            let status =
                self.exchange("fmi2SetBoolean", references, values.len(), |component, references, count| {
                    // SAFETY: living component, both arrays have at least `count` elements.
                    unsafe { set(component, references, count, c_values.as_ptr()) }
                })?;
            worst = worst.max(status);
        }
        Ok(worst)
    }

    /// `fmi2GetString` for one variable.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn get_string(&mut self, reference: ValueReference) -> Result<String> {
        let get = self.functions().get_string;
        let mut value = ptr::null();
        self.exchange("fmi2GetString", &[reference], 1, |component, references, count| {
            // SAFETY: living component, one reference and room for one pointer.
            unsafe { get(component, references, count, &raw mut value) }
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
        self.exchange("fmi2SetString", &[reference], 1, |component, references, count| {
            // SAFETY: living component, one reference and one C string, which lives until the end of this function.
            unsafe { set(component, references, count, &raw const pointer) }
        })
    }

    /// Calls a function that takes references and as many values, unless both are empty.
    #[inline]
    fn exchange(
        &mut self,
        function: &'static str,
        references: &[ValueReference],
        values: usize,
        call: impl FnOnce(Component, *const ValueReference, usize) -> c_int,
    ) -> Result<Status> {
        assert_eq!(references.len(), values, "{function}: as many values as references");
        if references.is_empty() {
            return Ok(Status::Ok);
        }
        let status = guarded(|| call(self.component.as_ptr(), references.as_ptr(), references.len()));
        self.check(function, status)
    }
}
