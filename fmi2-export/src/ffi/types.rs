//! C types of `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`.

use std::ffi::{c_char, c_int, c_uint, c_void};

pub use crate::status::Status;

/// `fmi2Component`: an instance.
pub type Component = *mut c_void;
/// `fmi2FMUstate`: a saved state.
pub type FmuState = *mut c_void;
/// `fmi2ValueReference`.
pub type ValueReference = c_uint;
/// `fmi2Boolean`: 0 or 1.
pub type Boolean = c_int;

/// `fmi2Type`: model exchange.
pub const MODEL_EXCHANGE: c_int = 0;
/// `fmi2Type`: co-simulation.
pub const CO_SIMULATION: c_int = 1;

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EventInfo {
    /// `newDiscreteStatesNeeded`.
    pub new_discrete_states_needed: Boolean,
    /// `terminateSimulation`.
    pub terminate_simulation: Boolean,
    /// `nominalsOfContinuousStatesChanged`.
    pub nominals_of_continuous_states_changed: Boolean,
    /// `valuesOfContinuousStatesChanged`.
    pub values_of_continuous_states_changed: Boolean,
    /// `nextEventTimeDefined`.
    pub next_event_time_defined: Boolean,
    /// `nextEventTime` (s), if it is defined.
    pub next_event_time: f64,
}

/// `fmi2StatusKind`, as the host passes it (any number can arrive).
pub mod status_kind {
    use std::ffi::c_int;
    /// `fmi2DoStepStatus`.
    pub const DO_STEP: c_int = 0;
    /// `fmi2PendingStatus`.
    pub const PENDING: c_int = 1;
    /// `fmi2LastSuccessfulTime`.
    pub const LAST_SUCCESSFUL_TIME: c_int = 2;
    /// `fmi2Terminated`.
    pub const TERMINATED: c_int = 3;
}

/// `fmi2CallbackLogger`.
pub type LoggerCallback = unsafe extern "C" fn(
    environment: *mut c_void,
    instance_name: *const c_char,
    status: Status,
    category: *const c_char,
    message: *const c_char,
    ...
);

/// `fmi2CallbackFunctions`. The memory functions are not used (`canNotUseMemoryManagementFunctions`), and steps are
/// always finished when `fmi2DoStep` returns, so `stepFinished` is not either.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    /// May be null.
    pub logger: Option<LoggerCallback>,
    /// Unused; may be null.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Unused; may be null.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Unused; may be null.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, Status)>,
    /// Handed back to the logger; may be null.
    pub component_environment: *mut c_void,
}
