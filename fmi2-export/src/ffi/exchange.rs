//! C functions that only model exchange has.
#![allow(clippy::missing_safety_doc)] // One rule for all of them: see the module `ffi`.

use super::arguments::{out, slice};
use super::instance::call;
use super::types::{Boolean, Component, EventInfo};
use crate::categories::Category;
use crate::exchange::Completed;
use crate::status::Status;

/// `fmi2EnterEventMode`.
#[inline(never)]
pub unsafe fn enter_event_mode(component: Component) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe { call(component, |instance| instance.slave.enter_event_mode()) }
}

/// `fmi2NewDiscreteStates`.
#[inline(never)]
pub unsafe fn new_discrete_states(component: Component, info: *mut EventInfo) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let info = out(info, 1, "eventInfo")?;
            let logger = &instance.logger;
            let found =
                instance.slave.new_discrete_states(&mut |said| logger.log(Status::Warning, Category::Warning, said))?;
            info.write([EventInfo {
                new_discrete_states_needed: Boolean::from(found.update.again),
                terminate_simulation: Boolean::from(found.update.terminate),
                nominals_of_continuous_states_changed: 0,
                values_of_continuous_states_changed: Boolean::from(found.states_changed),
                next_event_time_defined: Boolean::from(found.update.next_time.is_some()),
                next_event_time: found.update.next_time.unwrap_or(0.0),
            }]);
            Ok(())
        })
    }
}

/// `fmi2EnterContinuousTimeMode`.
#[inline(never)]
pub unsafe fn enter_continuous_time_mode(component: Component) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe { call(component, |instance| instance.slave.enter_continuous_time_mode()) }
}

/// `fmi2CompletedIntegratorStep`.
#[inline(never)]
pub unsafe fn completed_integrator_step(
    component: Component,
    _no_set_state_before: Boolean,
    enter_event_mode: *mut Boolean,
    terminate_simulation: *mut Boolean,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let enter_event_mode = out(enter_event_mode, 1, "enterEventMode")?;
            let terminate_simulation = out(terminate_simulation, 1, "terminateSimulation")?;
            let logger = &instance.logger;
            let completed = instance
                .slave
                .completed_integrator_step(&mut |said| logger.log(Status::Warning, Category::Warning, said))?;
            enter_event_mode.write([Boolean::from(completed == Completed::EnterEventMode)]);
            terminate_simulation.write([Boolean::from(completed == Completed::Terminate)]);
            Ok(())
        })
    }
}

/// `fmi2SetTime`.
pub unsafe fn set_time(component: Component, time: f64) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe { call(component, |instance| instance.slave.set_time(time)) }
}

/// `fmi2SetContinuousStates`.
pub unsafe fn set_continuous_states(component: Component, states: *const f64, count: usize) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe { call(component, |instance| instance.slave.set_continuous_states(slice(states, count, "x")?)) }
}

/// `fmi2GetDerivatives`.
pub unsafe fn get_derivatives(component: Component, derivatives: *mut f64, count: usize) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe { call(component, |instance| instance.slave.get_derivatives(out(derivatives, count, "derivatives")?)) }
}

/// `fmi2GetEventIndicators`.
pub unsafe fn get_event_indicators(component: Component, indicators: *mut f64, count: usize) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| instance.slave.get_event_indicators(out(indicators, count, "eventIndicators")?))
    }
}

/// `fmi2GetContinuousStates`.
#[inline(never)]
pub unsafe fn get_continuous_states(component: Component, states: *mut f64, count: usize) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe { call(component, |instance| instance.slave.get_continuous_states(out(states, count, "x")?)) }
}

/// `fmi2GetNominalsOfContinuousStates`.
#[inline(never)]
pub unsafe fn get_nominals_of_continuous_states(component: Component, nominals: *mut f64, count: usize) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe { call(component, |instance| instance.slave.get_nominals(out(nominals, count, "x_nominal")?)) }
}
