//! C functions that read and set variables, and their derivatives.
#![allow(clippy::missing_safety_doc)] // One rule for all of them: see the module `ffi`.

use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::arguments::{are_right, out, places, right_places, right_values, slice, strings, values};
use super::guard::Entered;
use super::instance::{call, end_panicked, enter_shortly, instance};
use super::types::{Boolean, Component, ValueReference};
use crate::status::{Refusal, Status};

/// `fmi2GetReal`.
#[inline(never)]
pub unsafe extern "C" fn get_real(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *mut f64,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        if are_right(vr, value)
            && let Some((instance, entered)) = enter_shortly(component)
        {
            let slave = &mut instance.slave;
            return match catch_unwind(AssertUnwindSafe(|| slave.get_shortly(vr, value, count))) {
                Ok(true) => {
                    entered.leave(true);
                    Status::Ok
                }
                Ok(false) => get_near_real(component, vr, count, value, entered),
                Err(panic) => end_panicked(component, entered, panic),
            };
        }
        get_any_real(component, vr, count, value)
    }
}

/// Goes on where [`get_real`] has entered and found that the variables don't stand side by side. As all that makes up for a short way it is a
/// C function, which never unwinds: so nothing has to be done after it.
#[inline(never)]
unsafe extern "C" fn get_near_real(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *mut f64,
    entered: Entered<'_>,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`; and `get_real` has entered.
    unsafe {
        let slave = &mut instance(component).slave;
        let get =
            || right_places(vr, value, count).is_some_and(|(references, places)| slave.get_near(references, places));
        match catch_unwind(AssertUnwindSafe(get)) {
            Ok(is_done) => {
                entered.leave(true);
                if is_done { Status::Ok } else { get_any_real(component, vr, count, value) }
            }
            Err(panic) => end_panicked(component, entered, panic),
        }
    }
}

#[inline(never)]
unsafe extern "C" fn get_any_real(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *mut f64,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let (references, mut places) = places(vr, value, count)?;
            let slave = &mut instance.slave;
            // Of a thread that is not the owner.
            if slave.is_ready() && (slave.get_shortly(vr, value, count) || slave.get_near(references, places.again())) {
                return Ok(());
            }
            slave.get_real(references, places)
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
#[inline(never)]
pub unsafe extern "C" fn set_real(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const f64,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        if are_right(vr, value)
            && let Some((instance, entered)) = enter_shortly(component)
        {
            if !instance.slave.set_shortly(vr, value, count) {
                return set_near_real(component, vr, count, value, entered);
            }
            entered.leave(true);
            return Status::Ok;
        }
        set_any_real(component, vr, count, value)
    }
}

/// As [`get_near_real`].
#[inline(never)]
unsafe extern "C" fn set_near_real(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const f64,
    entered: Entered<'_>,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`; and `set_real` has entered.
    unsafe {
        let slave = &mut instance(component).slave;
        let set = |(references, values): (&[u32], &[f64])| slave.set_near(references, values);
        let is_done = right_values(vr, value, count).is_some_and(set);
        entered.leave(true);
        if is_done { Status::Ok } else { set_any_real(component, vr, count, value) }
    }
}

#[inline(never)]
unsafe extern "C" fn set_any_real(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const f64,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let (references, values) = values(vr, value, count)?;
            let slave = &mut instance.slave;
            // Of a thread that is not the owner.
            if slave.is_ready() && (slave.set_shortly(vr, value, count) || slave.set_near(references, values)) {
                return Ok(());
            }
            slave.set_real(references, values)
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
