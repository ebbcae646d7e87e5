//! C functions that read and set variables, and their derivatives.
#![allow(clippy::missing_safety_doc)] // One rule for all of them: see the module `ffi`.

use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::arguments::{out, places, right_places, right_values, slice, strings, values};
use super::instance::{call, call_anyhow, call_shortly, panicked};
use super::types::{Boolean, Component, ValueReference};
use crate::status::{Refusal, Status};

/// `fmi2GetReal`.
pub unsafe fn get_real(component: Component, vr: *const ValueReference, count: usize, value: *mut f64) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        let shortly = call_shortly(component, |instance| {
            let (references, places) = right_places(vr, value, count)?;
            match catch_unwind(AssertUnwindSafe(|| instance.slave.get_shortly(references, places))) {
                Ok(done) => done.then_some(Status::Ok),
                Err(panic) => Some(panicked(instance, panic)),
            }
        });
        shortly.unwrap_or_else(|| get_any_real(component, vr, count, value))
    }
}

#[inline(never)]
unsafe fn get_any_real(component: Component, vr: *const ValueReference, count: usize, value: *mut f64) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call_anyhow(component, |instance, has_looked| {
            let (references, places) = places(vr, value, count)?;
            let slave = &mut instance.slave;
            if has_looked { slave.get_each_real(references, places) } else { slave.get_real(references, places) }
        })
    }
}

/// `fmi2GetInteger`.
#[inline(never)]
pub unsafe fn get_integer(component: Component, vr: *const ValueReference, count: usize, value: *mut c_int) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| instance.slave.get_integer(slice(vr, count, "vr")?, out(value, count, "value")?))
    }
}

/// `fmi2GetBoolean`.
#[inline(never)]
pub unsafe fn get_boolean(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *mut Boolean,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| instance.slave.get_boolean(slice(vr, count, "vr")?, out(value, count, "value")?))
    }
}

/// `fmi2GetString`. The strings are valid until the next call on this instance.
#[inline(never)]
pub unsafe fn get_string(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *mut *const c_char,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let (vr, value) = (slice(vr, count, "vr")?, out(value, count, "value")?);
            value.write(instance.slave.get_string(vr)?.iter().map(|string| string.as_ptr()));
            Ok(())
        })
    }
}

/// `fmi2SetReal`.
pub unsafe fn set_real(component: Component, vr: *const ValueReference, count: usize, value: *const f64) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        let shortly = call_shortly(component, |instance| {
            let (references, values) = right_values(vr, value, count)?;
            instance.slave.set_shortly(references, values).then_some(Status::Ok)
        });
        shortly.unwrap_or_else(|| set_any_real(component, vr, count, value))
    }
}

#[inline(never)]
unsafe fn set_any_real(component: Component, vr: *const ValueReference, count: usize, value: *const f64) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call_anyhow(component, |instance, has_looked| {
            let (references, values) = values(vr, value, count)?;
            let slave = &mut instance.slave;
            if has_looked { slave.set_each_real(references, values) } else { slave.set_real(references, values) }
        })
    }
}

/// `fmi2SetInteger`.
#[inline(never)]
pub unsafe fn set_integer(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const c_int,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| instance.slave.set_integer(slice(vr, count, "vr")?, slice(value, count, "value")?))
    }
}

/// `fmi2SetBoolean`.
#[inline(never)]
pub unsafe fn set_boolean(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const Boolean,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| instance.slave.set_boolean(slice(vr, count, "vr")?, slice(value, count, "value")?))
    }
}

/// `fmi2SetString`.
#[inline(never)]
pub unsafe fn set_string(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const *const c_char,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let vr = slice(vr, count, "vr")?;
            let values = strings(value, count, "value")?
                .into_iter()
                .map(|s| s.to_str().map_err(|_| Refusal::error("a string value is not UTF-8")))
                .collect::<Result<Vec<&str>, Refusal>>()?;
            instance.slave.set_string(vr, &values)
        })
    }
}

/// `fmi2SetRealInputDerivatives`.
#[inline(never)]
pub unsafe fn set_real_input_derivatives(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    order: *const c_int,
    value: *const f64,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            instance.slave.set_input_derivatives(
                slice(vr, count, "vr")?,
                slice(order, count, "order")?,
                slice(value, count, "value")?,
            )
        })
    }
}

/// `fmi2GetRealOutputDerivatives`.
#[inline(never)]
pub unsafe fn get_real_output_derivatives(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    order: *const c_int,
    value: *mut f64,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            instance.slave.get_output_derivatives(
                slice(vr, count, "vr")?,
                slice(order, count, "order")?,
                out(value, count, "value")?,
            )
        })
    }
}

/// `fmi2GetDirectionalDerivative`.
#[inline(never)]
pub unsafe fn get_directional_derivative(
    component: Component,
    unknowns: *const ValueReference,
    unknown_count: usize,
    knowns: *const ValueReference,
    known_count: usize,
    seed: *const f64,
    value: *mut f64,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            instance.slave.directional_derivative(
                slice(unknowns, unknown_count, "vUnknown_ref")?,
                slice(knowns, known_count, "vKnown_ref")?,
                slice(seed, known_count, "dvKnown")?,
                out(value, unknown_count, "dvUnknown")?,
            )
        })
    }
}
