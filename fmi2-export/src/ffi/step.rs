//! C functions that step, and that ask how a step went.
#![allow(clippy::missing_safety_doc)] // One rule for all of them: see the module `ffi`.

use std::ffi::{c_char, c_int};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::arguments::out;
use super::instance::{Instance, call, end_failed, end_panicked, enter_shortly};
use super::types::{Boolean, Component, status_kind};
use crate::categories::Category;
use crate::phase::{Call, Kind};
use crate::status::{Refusal, Status};

/// `fmi2DoStep`.
#[inline(never)]
pub unsafe extern "C" fn do_step(component: Component, time: f64, size: f64, _no_set_state_before: Boolean) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        let Some((instance, entered)) = enter_shortly(component) else { return do_any_step(component, time, size) };
        if !instance.slave.is_usual_step(time, size) {
            entered.leave(true);
            return do_any_step(component, time, size);
        }
        let logger = &instance.logger;
        let slave = &mut instance.slave;
        let mut warn = |said: fmt::Arguments<'_>| logger.log(Status::Warning, Category::Warning, said);
        match catch_unwind(AssertUnwindSafe(|| slave.step(time, size, &mut warn))) {
            Ok(Ok(())) => {
                entered.leave(true);
                Status::Ok
            }
            Ok(Err(failure)) => end_failed(component, entered, failure),
            Err(panic) => end_panicked(component, entered, panic),
        }
    }
}

/// A C function, which never unwinds: so nothing has to be done after it.
#[inline(never)]
unsafe extern "C" fn do_any_step(component: Component, time: f64, size: f64) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let logger = &instance.logger;
            instance.slave.do_step(time, size, &mut |said| logger.log(Status::Warning, Category::Warning, said))
        })
    }
}

/// `fmi2CancelStep`: there is never a step in progress.
#[inline(never)]
pub unsafe fn cancel_step(component: Component) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe { call(component, |_| Err(Refusal::error("fmi2CancelStep: no step is in progress, steps are synchronous"))) }
}

/// Checks that status may be asked for now.
fn check_status(instance: &Instance, what: &str) -> Result<(), Refusal> {
    let (kind, phase) = (instance.slave.kind(), instance.slave.phase());
    if kind != Kind::CoSimulation {
        Err(Refusal::error(format!("{what} is for co-simulation; this instance is for {}", kind.name())))
    } else if phase.allows(Call::GetStatus) {
        Ok(())
    } else {
        Err(Refusal::error(format!("{what} is not allowed {}", phase.name())))
    }
}

/// A status that a slave whose steps are synchronous does not have.
fn no_status(what: &str, kind: c_int) -> Refusal {
    let message = match kind {
        status_kind::DO_STEP | status_kind::PENDING => {
            format!("{what}: no step is pending, fmi2DoStep returns when the step is done")
        }
        status_kind::LAST_SUCCESSFUL_TIME => format!("{what}: fmi2LastSuccessfulTime is a Real status"),
        status_kind::TERMINATED => format!("{what}: fmi2Terminated is a Boolean status"),
        _ => format!("{what}: there is no status kind {kind}"),
    };
    Refusal::discard(message)
}

/// `fmi2GetStatus`.
#[inline(never)]
pub unsafe fn get_status(component: Component, kind: c_int, value: *mut c_int) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetStatus")?;
            out(value, 1, "value")?;
            Err(no_status("fmi2GetStatus", kind))
        })
    }
}

/// `fmi2GetRealStatus`.
#[inline(never)]
pub unsafe fn get_real_status(component: Component, kind: c_int, value: *mut f64) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetRealStatus")?;
            let value = out(value, 1, "value")?;
            if kind != status_kind::LAST_SUCCESSFUL_TIME {
                return Err(no_status("fmi2GetRealStatus", kind));
            }
            value.write([instance.slave.last_successful_time()]);
            Ok(())
        })
    }
}

/// `fmi2GetIntegerStatus`: there is no status of this type.
#[inline(never)]
pub unsafe fn get_integer_status(component: Component, kind: c_int, value: *mut c_int) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetIntegerStatus")?;
            out(value, 1, "value")?;
            Err(no_status("fmi2GetIntegerStatus", kind))
        })
    }
}

/// `fmi2GetBooleanStatus`.
#[inline(never)]
pub unsafe fn get_boolean_status(component: Component, kind: c_int, value: *mut Boolean) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetBooleanStatus")?;
            let value = out(value, 1, "value")?;
            if kind != status_kind::TERMINATED {
                return Err(no_status("fmi2GetBooleanStatus", kind));
            }
            // A model here never ends a simulation by itself.
            value.write([0]);
            Ok(())
        })
    }
}

/// `fmi2GetStringStatus`.
#[inline(never)]
pub unsafe fn get_string_status(component: Component, kind: c_int, value: *mut *const c_char) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetStringStatus")?;
            out(value, 1, "value")?;
            Err(no_status("fmi2GetStringStatus", kind))
        })
    }
}
