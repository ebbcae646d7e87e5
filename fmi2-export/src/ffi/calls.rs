//! The functions behind the C symbols that [`export!`](crate::export) defines.
#![allow(clippy::missing_safety_doc)] // One rule for all of them: see the module `ffi`.

use std::any::Any;
use std::cell::UnsafeCell;
use std::ffi::{CStr, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};

use super::arguments::{place, slice, slice_mut, strings, text};
use super::library::Library;
use super::panics;
use super::types::{
    Boolean, CO_SIMULATION, CallbackFunctions, Component, FmuState, Status, ValueReference, status_kind,
};
use crate::Experiment;
use crate::logger::{Category, Logger};
use crate::phase::Call;
use crate::slave::{AnySlave, Outcome, Refusal};

/// What an `fmi2Component` points to.
struct Shared {
    /// A call is running on the instance.
    busy: AtomicBool,
    instance: UnsafeCell<Instance>,
}

struct Instance {
    library: &'static Library,
    /// Which model of the library, for tidying up.
    model: usize,
    logger: Logger,
    slave: Box<dyn AnySlave>,
}

impl Instance {
    /// Tells of a step in the instance's life.
    fn event(&self, status: Status, what: &str) -> Status {
        self.logger.log(status, Category::Events, format_args!("{what}"));
        status
    }
}

/// Marks an instance as in use; `None` if it is no instance, or is in use already: by a logger that calls back, or by
/// another thread.
///
/// # Safety
/// If not null and aligned, `component` must come from `instantiate` and not have been freed.
unsafe fn occupy<'c>(component: Component) -> Option<&'c Shared> {
    let pointer = component.cast::<Shared>();
    if !pointer.is_aligned() {
        return None;
    }
    // SAFETY: aligned; the rest is the caller's promise.
    let shared = unsafe { pointer.as_ref() }?;
    // A swap and not a load and a store, so that of two threads one is refused: it costs 1.2 ns.
    (!shared.busy.swap(true, Ordering::Acquire)).then_some(shared)
}

/// Runs a call on an instance; refusals are logged, panics caught. Nothing is logged about a call from within another
/// one, because the logger would call again.
unsafe fn call(component: Component, run: impl FnOnce(&mut Instance) -> Outcome) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    let Some(shared) = (unsafe { occupy(component) }) else { return Status::Error };
    // SAFETY: `busy` was false, so this is the only reference until it is false again.
    let instance = unsafe { &mut *shared.instance.get() };
    let status = match guarded(|| run(instance)) {
        Ok(Ok(status)) => status,
        Ok(Err(refusal)) => refused(instance, &refusal),
        Err(message) => panicked(instance, &message),
    };
    shared.busy.store(false, Ordering::Release);
    status
}

#[cold]
fn refused(instance: &Instance, refusal: &Refusal) -> Status {
    instance.logger.log(refusal.status, refusal.category(), format_args!("{}", refusal.message));
    refusal.status
}

#[cold]
fn panicked(instance: &mut Instance, message: &str) -> Status {
    instance.slave.poison();
    instance.logger.log(Status::Error, Category::Error, format_args!("internal error in the model: {message}"));
    Status::Error
}

/// Runs code that may panic; the message if it did.
fn guarded<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(run)).map_err(|panic| {
        let message = panic
            .downcast_ref::<&str>()
            .copied()
            .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
            .unwrap_or("no message")
            .to_owned();
        dispose(panic);
        message
    })
}

/// Drops what a panic has thrown: its destructor can panic, too, and throw something of the kind.
fn dispose(mut thrown: Box<dyn Any + Send>) {
    for _ in 0..8 {
        match catch_unwind(AssertUnwindSafe(|| drop(thrown))) {
            Ok(()) => return,
            Err(next) => thrown = next,
        }
    }
    std::mem::forget(thrown);
}

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
pub unsafe fn instantiate(
    library: &'static Library,
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
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
            if fmu_type != CO_SIMULATION {
                return Err(Refusal::error("this FMU is for co-simulation (fmi2CoSimulation) only"));
            }
            // SAFETY: the host's promise.
            let guid = unsafe { text(guid, "fmuGUID") }?;
            find_model(library, guid)
        })
    });
    let reason = match result {
        Ok(Ok((model, slave))) => {
            logger.log(Status::Ok, Category::Events, format_args!("instantiated"));
            let instance = UnsafeCell::new(Instance { library, model, logger, slave });
            let shared = Box::into_raw(Box::new(Shared { busy: AtomicBool::new(false), instance }));
            // SAFETY: just made; `free_instance` forgets the flag first.
            unsafe { panics::watch(&raw const (*shared).busy) };
            return shared.cast();
        }
        Ok(Err(refusal)) => refusal.message,
        Err(message) => format!("internal error in the model: {message}"),
    };
    // "If a null pointer is returned, then functions->logger is called with detailed information about the reason."
    logger.enable_all();
    logger.log(Status::Error, Category::Error, format_args!("fmi2Instantiate failed: {reason}"));
    ptr::null_mut()
}

fn find_model(library: &'static Library, guid: &str) -> Result<(usize, Box<dyn AnySlave>), Refusal> {
    let mut known = Vec::new();
    for (index, model) in library.models.iter().enumerate() {
        let its = model.guid().map_err(|e| Refusal::error(e.to_string()))?;
        if its == guid {
            let slave = model.instantiate().map_err(|e| Refusal::error(e.to_string()))?;
            return Ok((index, slave));
        }
        known.push(its);
    }
    Err(Refusal::error(format!(
        "fmuGUID is {guid:?}, but this library serves {}: modelDescription.xml and binary are not of the same build",
        known.join(", ")
    )))
}

/// `fmi2FreeInstance`. An instance is not freed from within a call on it (by its logger).
pub unsafe fn free_instance(component: Component) {
    // SAFETY: the host's promise.
    let Some(shared) = (unsafe { occupy(component) }) else { return };
    panics::forget(&raw const shared.busy);
    // SAFETY: the host's promise: it came from `instantiate` and is not used again.
    let instance = unsafe { Box::from_raw(component.cast::<Shared>()) }.instance.into_inner();
    let (library, model) = (instance.library, instance.model);
    panics::without_instance(|| {
        // A panic in the model's destructor must not reach the host either.
        let _ = guarded(|| drop(instance));
        for snapshot in library.forget_all_of(component.addr()) {
            let _ = guarded(|| drop(snapshot));
        }
    });
    library.models[model].tidy();
}

/// `fmi2SetDebugLogging`.
pub unsafe fn set_debug_logging(
    component: Component,
    logging_on: Boolean,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: the host's promise, here and in all functions below.
    unsafe {
        call(component, |instance| {
            let categories = strings(categories, count, "categories")?;
            instance.logger.set(logging_on != 0, &categories).map_err(|unknown: &CStr| {
                Refusal::error(format!("there is no log category {:?}", unknown.to_string_lossy()))
            })?;
            Ok(Status::Ok)
        })
    }
}

/// `fmi2SetupExperiment`.
pub unsafe fn setup_experiment(
    component: Component,
    tolerance_defined: Boolean,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: Boolean,
    stop_time: f64,
) -> Status {
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
pub unsafe fn enter_initialization_mode(component: Component) -> Status {
    unsafe {
        call(component, |instance| {
            instance.slave.enter_initialization().map(|status| instance.event(status, "initialization mode entered"))
        })
    }
}

/// `fmi2ExitInitializationMode`.
pub unsafe fn exit_initialization_mode(component: Component) -> Status {
    unsafe {
        call(component, |instance| {
            instance.slave.exit_initialization().map(|status| instance.event(status, "initialized"))
        })
    }
}

/// `fmi2Terminate`.
pub unsafe fn terminate(component: Component) -> Status {
    unsafe { call(component, |instance| instance.slave.terminate().map(|status| instance.event(status, "terminated"))) }
}

/// `fmi2Reset`.
pub unsafe fn reset(component: Component) -> Status {
    unsafe { call(component, |instance| instance.slave.reset().map(|status| instance.event(status, "reset"))) }
}

/// `fmi2GetReal`.
pub unsafe fn get_real(component: Component, vr: *const ValueReference, count: usize, value: *mut f64) -> Status {
    unsafe {
        call(component, |instance| instance.slave.get_real(slice(vr, count, "vr")?, slice_mut(value, count, "value")?))
    }
}

/// `fmi2GetInteger`.
pub unsafe fn get_integer(component: Component, vr: *const ValueReference, count: usize, value: *mut c_int) -> Status {
    unsafe {
        call(component, |instance| {
            instance.slave.get_integer(slice(vr, count, "vr")?, slice_mut(value, count, "value")?)
        })
    }
}

/// `fmi2GetBoolean`.
pub unsafe fn get_boolean(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *mut Boolean,
) -> Status {
    unsafe {
        call(component, |instance| {
            instance.slave.get_boolean(slice(vr, count, "vr")?, slice_mut(value, count, "value")?)
        })
    }
}

/// `fmi2GetString`. The strings are valid until the next call on this instance.
pub unsafe fn get_string(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *mut *const c_char,
) -> Status {
    unsafe {
        call(component, |instance| {
            let (vr, value) = (slice(vr, count, "vr")?, slice_mut(value, count, "value")?);
            for (to, from) in value.iter_mut().zip(instance.slave.get_string(vr)?) {
                *to = from.as_ptr();
            }
            Ok(Status::Ok)
        })
    }
}

/// `fmi2SetReal`.
pub unsafe fn set_real(component: Component, vr: *const ValueReference, count: usize, value: *const f64) -> Status {
    unsafe {
        call(component, |instance| instance.slave.set_real(slice(vr, count, "vr")?, slice(value, count, "value")?))
    }
}

/// `fmi2SetInteger`.
pub unsafe fn set_integer(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const c_int,
) -> Status {
    unsafe {
        call(component, |instance| instance.slave.set_integer(slice(vr, count, "vr")?, slice(value, count, "value")?))
    }
}

/// `fmi2SetBoolean`.
pub unsafe fn set_boolean(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const Boolean,
) -> Status {
    unsafe {
        call(component, |instance| instance.slave.set_boolean(slice(vr, count, "vr")?, slice(value, count, "value")?))
    }
}

/// `fmi2SetString`.
pub unsafe fn set_string(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    value: *const *const c_char,
) -> Status {
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
pub unsafe fn set_real_input_derivatives(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    order: *const c_int,
    value: *const f64,
) -> Status {
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
pub unsafe fn get_real_output_derivatives(
    component: Component,
    vr: *const ValueReference,
    count: usize,
    order: *const c_int,
    value: *mut f64,
) -> Status {
    unsafe {
        call(component, |instance| {
            instance.slave.get_output_derivatives(
                slice(vr, count, "vr")?,
                slice(order, count, "order")?,
                slice_mut(value, count, "value")?,
            )
        })
    }
}

/// `fmi2GetDirectionalDerivative`.
pub unsafe fn get_directional_derivative(
    component: Component,
    unknowns: *const ValueReference,
    unknown_count: usize,
    knowns: *const ValueReference,
    known_count: usize,
    seed: *const f64,
    value: *mut f64,
) -> Status {
    unsafe {
        call(component, |instance| {
            instance.slave.directional_derivative(
                slice(unknowns, unknown_count, "vUnknown_ref")?,
                slice(knowns, known_count, "vKnown_ref")?,
                slice(seed, known_count, "dvKnown")?,
                slice_mut(value, unknown_count, "dvUnknown")?,
            )
        })
    }
}

/// `fmi2DoStep`.
pub unsafe fn do_step(component: Component, time: f64, size: f64, _no_set_state_before: Boolean) -> Status {
    unsafe { call(component, |instance| instance.slave.do_step(time, size, &instance.logger)) }
}

/// `fmi2CancelStep`: there is never a step in progress.
pub unsafe fn cancel_step(component: Component) -> Status {
    unsafe { call(component, |_| Err(Refusal::error("fmi2CancelStep: no step is in progress, steps are synchronous"))) }
}

/// Checks that status may be asked for now.
fn check_status(instance: &Instance, what: &str) -> Result<(), Refusal> {
    let phase = instance.slave.phase();
    if phase.allows(Call::GetStatus) {
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
    Refusal { status: Status::Discard, message }
}

/// `fmi2GetStatus`.
pub unsafe fn get_status(component: Component, kind: c_int, value: *mut c_int) -> Status {
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetStatus")?;
            place(value, "value")?;
            Err(no_status("fmi2GetStatus", kind))
        })
    }
}

/// `fmi2GetRealStatus`.
pub unsafe fn get_real_status(component: Component, kind: c_int, value: *mut f64) -> Status {
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetRealStatus")?;
            let value = place(value, "value")?;
            if kind != status_kind::LAST_SUCCESSFUL_TIME {
                return Err(no_status("fmi2GetRealStatus", kind));
            }
            *value = instance.slave.last_successful_time();
            Ok(Status::Ok)
        })
    }
}

/// `fmi2GetIntegerStatus`: there is no status of this type.
pub unsafe fn get_integer_status(component: Component, kind: c_int, value: *mut c_int) -> Status {
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetIntegerStatus")?;
            place(value, "value")?;
            Err(no_status("fmi2GetIntegerStatus", kind))
        })
    }
}

/// `fmi2GetBooleanStatus`.
pub unsafe fn get_boolean_status(component: Component, kind: c_int, value: *mut Boolean) -> Status {
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetBooleanStatus")?;
            let value = place(value, "value")?;
            if kind != status_kind::TERMINATED {
                return Err(no_status("fmi2GetBooleanStatus", kind));
            }
            // A model here never ends a simulation by itself.
            *value = 0;
            Ok(Status::Ok)
        })
    }
}

/// `fmi2GetStringStatus`.
pub unsafe fn get_string_status(component: Component, kind: c_int, value: *mut *const c_char) -> Status {
    unsafe {
        call(component, |instance| {
            check_status(instance, "fmi2GetStringStatus")?;
            place(value, "value")?;
            Err(no_status("fmi2GetStringStatus", kind))
        })
    }
}

/// `fmi2GetFMUstate`.
pub unsafe fn get_fmu_state(component: Component, state: *mut FmuState) -> Status {
    unsafe {
        call(component, |instance| {
            let state = place(state, "FMUstate")?;
            let snapshot = instance.slave.save();
            let owner = component.addr();
            if state.is_null() {
                *state = ptr::without_provenance_mut(instance.library.keep(owner, snapshot));
            } else if !instance.library.replace(state.addr(), owner, snapshot) {
                return Err(unknown_state());
            }
            Ok(Status::Ok)
        })
    }
}

/// `fmi2SetFMUstate`. The state may have been saved by another instance of the same FMU.
pub unsafe fn set_fmu_state(component: Component, state: FmuState) -> Status {
    unsafe {
        call(component, |instance| {
            let snapshot = instance.library.snapshot(state.addr()).ok_or_else(unknown_state)?;
            instance.slave.restore(&snapshot)
        })
    }
}

/// `fmi2FreeFMUstate`.
pub unsafe fn free_fmu_state(component: Component, state: *mut FmuState) -> Status {
    unsafe {
        call(component, |instance| {
            let state = place(state, "FMUstate")?;
            // "If a null pointer is provided, the call is ignored."
            if !state.is_null() {
                if !instance.library.forget(state.addr()) {
                    return Err(unknown_state());
                }
                *state = ptr::null_mut();
            }
            Ok(Status::Ok)
        })
    }
}

fn unknown_state() -> Refusal {
    Refusal::error("FMUstate is none that fmi2GetFMUstate or fmi2DeSerializeFMUstate returned, or it was freed")
}

fn encode(instance: &Instance, state: FmuState) -> Result<Vec<u8>, Refusal> {
    let snapshot = instance.library.snapshot(state.addr()).ok_or_else(unknown_state)?;
    instance.slave.encode(&snapshot)
}

/// `fmi2SerializedFMUstateSize`.
pub unsafe fn serialized_fmu_state_size(component: Component, state: FmuState, size: *mut usize) -> Status {
    unsafe {
        call(component, |instance| {
            let size = place(size, "size")?;
            *size = encode(instance, state)?.len();
            Ok(Status::Ok)
        })
    }
}

/// `fmi2SerializeFMUstate`.
pub unsafe fn serialize_fmu_state(component: Component, state: FmuState, bytes: *mut c_char, size: usize) -> Status {
    unsafe {
        call(component, |instance| {
            let encoded = encode(instance, state)?;
            let bytes = slice_mut(bytes.cast::<u8>(), size, "serializedState")?;
            if bytes.len() < encoded.len() {
                return Err(Refusal::error(format!("the state needs {} bytes, size is {size}", encoded.len())));
            }
            bytes[..encoded.len()].copy_from_slice(&encoded);
            Ok(Status::Ok)
        })
    }
}

/// `fmi2DeSerializeFMUstate`.
pub unsafe fn deserialize_fmu_state(
    component: Component,
    bytes: *const c_char,
    size: usize,
    state: *mut FmuState,
) -> Status {
    unsafe {
        call(component, |instance| {
            let bytes = slice(bytes.cast::<u8>(), size, "serializedState")?;
            let state = place(state, "FMUstate")?;
            let snapshot = instance.slave.decode(bytes)?;
            let owner = component.addr();
            // As with `fmi2GetFMUstate`, a state that was returned before is replaced.
            if state.is_null() || !instance.library.replace(state.addr(), owner, snapshot.clone()) {
                *state = ptr::without_provenance_mut(instance.library.keep(owner, snapshot));
            }
            Ok(Status::Ok)
        })
    }
}
