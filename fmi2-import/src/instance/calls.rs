//! The calls of every step. Several can be made together: whether foreign code has changed the floating-point environment is looked at
//! once for all of them.

use std::ffi::c_int;

use super::{Instance, Result};
use crate::floating_point::Environment;
use crate::library::{Component, Status, ValueReference};

/// Booleans that cross the C interface in one call.
const BOOLEANS: usize = 16;

/// The calls that [`Instance::together`] makes.
pub struct Calls<'a>(&'a mut Instance);

impl Instance {
    /// Makes several calls. The floating-point environment is the slave's between them, and the host's again behind them: numbers
    /// that others are to have are computed before the first one.
    #[inline]
    pub fn together<T>(&mut self, calls: impl FnOnce(&mut Calls<'_>) -> T) -> T {
        self.together_in(Environment::now(), calls)
    }

    /// The same where the floating-point environment of this thread is known.
    #[allow(clippy::inline_always)] // As a call of its own it would cost as much as a call of the slave costs the caller.
    #[inline(always)]
    pub fn together_in<T>(&mut self, host: Environment, calls: impl FnOnce(&mut Calls<'_>) -> T) -> T {
        host.guard(|| calls(&mut Calls(self)))
    }
}

impl Calls<'_> {
    /// `fmi2GetReal` for many variables at once.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn get_real(&mut self, references: &[ValueReference], values: &mut [f64]) -> Result<Status> {
        let get = self.0.functions().get_real;
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
        let set = self.0.functions().set_real;
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
        let get = self.0.functions().get_integer;
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
        let set = self.0.functions().set_integer;
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
        let get = self.0.functions().get_boolean;
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
        let set = self.0.functions().set_boolean;
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

    /// `fmi2DoStep`, as [`Instance::do_step`].
    ///
    /// # Errors
    /// When the slave does not complete the step.
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<Status> {
        // SAFETY: living component. No state before `time` will be restored.
        let status = unsafe { (self.0.functions().do_step)(self.0.component.as_ptr(), time, step, 1) };
        if status == 0 { Ok(Status::Ok) } else { self.0.incomplete_step(Status::from_c(status)) }
    }

    /// Calls a function that takes references and as many values, unless both are empty.
    #[inline]
    pub(super) fn exchange(
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
        let status = call(self.0.component.as_ptr(), references.as_ptr(), references.len());
        self.0.check(function, status)
    }
}
