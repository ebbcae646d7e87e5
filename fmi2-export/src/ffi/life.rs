//! C functions from instantiation to termination.
#![allow(clippy::missing_safety_doc)] // One rule for all of them: see the module `ffi`.

use std::cell::UnsafeCell;
use std::ffi::{CStr, c_char, c_int};
use std::ptr;

use super::arguments::{strings, text};
use super::guard::Guard;
use super::instance::{Instance, Shared, call, guarded, lose, lost, occupy};
use super::logger::Logger;
use super::panics;
use super::types::{Boolean, CO_SIMULATION, CallbackFunctions, Component, MODEL_EXCHANGE};
use crate::categories::Category;
use crate::model::Experiment;
use crate::phase::Kind;
use crate::resources::Resources;
use crate::served::Served;
use crate::slave::Slave;
use crate::status::{Refusal, Status};

/// `fmi2GetTypesPlatform`: the C types are those of the standard header.
#[must_use]
pub fn get_types_platform() -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion`.
#[must_use]
pub fn get_version() -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2Instantiate`.
#[inline(never)]
pub unsafe fn instantiate(
    library: &'static Served,
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resource_location: *const c_char,
    functions: *const CallbackFunctions,
    logging_on: Boolean,
) -> Component {
    panics::install_hook();
    if !functions.is_aligned() {
        return ptr::null_mut();
    }
    // SAFETY: the host's promise. A copy, since the struct need not outlive this call.
    let Some(callbacks) = (unsafe { functions.as_ref() }).copied() else { return ptr::null_mut() };
    // SAFETY: the host's promise.
    let name = if instance_name.is_null() { c"" } else { unsafe { CStr::from_ptr(instance_name) } };
    let mut logger = Logger::new(&callbacks, name.to_owned(), logging_on != 0);
    let result = panics::without_instance(|| {
        guarded(|| {
            if name.to_bytes().trim_ascii().is_empty() {
                return Err(Refusal::error("instanceName is a null pointer or empty"));
            }
            let kind = match fmu_type {
                MODEL_EXCHANGE => Kind::ModelExchange,
                CO_SIMULATION => Kind::CoSimulation,
                _ => {
                    let message = format!("fmuType is {fmu_type}, it is fmi2ModelExchange (0) or fmi2CoSimulation (1)");
                    return Err(Refusal::error(message));
                }
            };
            // SAFETY: the host's promise.
            let guid = unsafe { text(guid, "fmuGUID") }?;
            // SAFETY: the host's promise.
            let location = if resource_location.is_null() { c"" } else { unsafe { CStr::from_ptr(resource_location) } };
            if library.is_lost() {
                return Err(lost());
            }
            find_model(library, guid, kind, &Resources::located(location.to_bytes()))
        })
    });
    let (status, reason) = match result {
        Ok(Ok((model, slave))) => {
            logger.log(Status::Ok, Category::Events, format_args!("instantiated"));
            let instance = UnsafeCell::new(Instance { slave, library, model, logger });
            let shared = Box::into_raw(Box::new(Shared { guard: Guard::new(), instance }));
            // SAFETY: just made; `free_instance` forgets the guard first.
            unsafe { panics::watch(&raw const (*shared).guard) };
            return shared.cast();
        }
        Ok(Err(refusal)) => (refusal.status(), refusal.into_message()),
        Err(message) => (Status::Error, format!("internal error in the model: {message}")),
    };
    if status == Status::Fatal {
        lose(library);
    }
    // "If a null pointer is returned, then functions->logger is called with detailed information about the reason."
    logger.enable_all();
    logger.log(status, Category::Error, format_args!("fmi2Instantiate failed: {reason}"));
    ptr::null_mut()
}

fn find_model(
    library: &'static Served,
    guid: &str,
    kind: Kind,
    resources: &Resources,
) -> Result<(usize, Slave), Refusal> {
    let mut known = Vec::new();
    for (index, model) in library.models.iter().enumerate() {
        let its = model.guid().map_err(|e| Refusal::error(e.to_string()))?;
        if its == guid {
            return Ok((index, model.instantiate(kind, resources)?));
        }
        known.push(its);
    }
    Err(Refusal::error(format!(
        "fmuGUID is {guid:?}, but this library serves {}: modelDescription.xml and binary are not of the same build",
        known.join(", ")
    )))
}

/// `fmi2FreeInstance`. An instance is not freed from within a call on it (by its logger).
#[inline(never)]
pub unsafe fn free_instance(component: Component) {
    // SAFETY: the host's promise.
    let Some((shared, _)) = (unsafe { occupy(component) }) else { return };
    panics::forget(&raw const shared.guard);
    // SAFETY: the host's promise: it came from `instantiate` and is not used again.
    let instance = unsafe { Box::from_raw(component.cast::<Shared>()) }.instance.into_inner();
    let (library, model) = (instance.library, instance.model);
    panics::without_instance(|| {
        // A panic in the model's destructor must not reach the host either.
        let _ = guarded(|| drop(instance));
        for snapshot in library.states.forget_all_of(component.addr()) {
            let _ = guarded(|| drop(snapshot));
        }
    });
    library.models[model].tidy();
}

/// `fmi2SetDebugLogging`.
#[inline(never)]
pub unsafe fn set_debug_logging(
    component: Component,
    logging_on: Boolean,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let categories = strings(categories, count, "categories")?;
            instance.logger.set(logging_on != 0, &categories).map_err(|unknown: &CStr| {
                Refusal::error(format!("there is no log category {:?}", unknown.to_string_lossy()))
            })?;
            Ok(())
        })
    }
}

/// `fmi2SetupExperiment`.
#[inline(never)]
pub unsafe fn setup_experiment(
    component: Component,
    tolerance_defined: Boolean,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: Boolean,
    stop_time: f64,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            instance.slave.setup_experiment(Experiment {
                start_time,
                stop_time: (stop_time_defined != 0).then_some(stop_time),
                tolerance: (tolerance_defined != 0).then_some(tolerance),
            })
        })
    }
}

/// `fmi2EnterInitializationMode`.
#[inline(never)]
pub unsafe fn enter_initialization_mode(component: Component) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            instance.slave.enter_initialization()?;
            instance.event("initialization mode entered");
            Ok(())
        })
    }
}

/// `fmi2ExitInitializationMode`.
#[inline(never)]
pub unsafe fn exit_initialization_mode(component: Component) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            instance.slave.exit_initialization()?;
            instance.event("initialized");
            Ok(())
        })
    }
}

/// `fmi2Terminate`.
#[inline(never)]
pub unsafe fn terminate(component: Component) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let logger = &instance.logger;
            instance.slave.terminate(&mut |said| logger.log(Status::Warning, Category::Warning, said))?;
            instance.event("terminated");
            Ok(())
        })
    }
}

/// `fmi2Reset`.
#[inline(never)]
pub unsafe fn reset(component: Component) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            instance.slave.reset()?;
            instance.event("reset");
            Ok(())
        })
    }
}
