//! The C interface of a model that is linked into the test, as `export!` defines it: what can be asked of it without loading
//! a library. Tests of model crates include this file, too.

use std::ffi::{c_char, c_int, c_void};
use std::ptr::null_mut;

use fmi2_export::ffi::types::{CallbackFunctions, EventInfo, FmuState, Status};

/// `fmi2Component`.
pub type C = *mut c_void;

/// A host that hears nothing.
#[allow(dead_code)]
pub const NO_CALLBACKS: CallbackFunctions = CallbackFunctions {
    logger: None,
    allocate_memory: None,
    free_memory: None,
    step_finished: None,
    component_environment: null_mut(),
};

// Each test uses a part of it.
#[allow(dead_code, clashing_extern_declarations, clippy::too_many_arguments)]
unsafe extern "C" {
    pub fn fmi2Instantiate(
        name: *const c_char,
        kind: c_int,
        guid: *const c_char,
        resources: *const c_char,
        functions: *const CallbackFunctions,
        visible: c_int,
        logging: c_int,
    ) -> C;
    pub fn fmi2FreeInstance(c: C);
    pub fn fmi2SetupExperiment(
        c: C,
        has_tolerance: c_int,
        tolerance: f64,
        start: f64,
        has_stop: c_int,
        stop: f64,
    ) -> Status;
    pub fn fmi2EnterInitializationMode(c: C) -> Status;
    pub fn fmi2ExitInitializationMode(c: C) -> Status;
    pub fn fmi2GetReal(c: C, vr: *const u32, n: usize, value: *mut f64) -> Status;
    pub fn fmi2GetInteger(c: C, vr: *const u32, n: usize, value: *mut c_int) -> Status;
    pub fn fmi2GetBoolean(c: C, vr: *const u32, n: usize, value: *mut c_int) -> Status;
    pub fn fmi2SetReal(c: C, vr: *const u32, n: usize, value: *const f64) -> Status;
    pub fn fmi2SetInteger(c: C, vr: *const u32, n: usize, value: *const c_int) -> Status;
    pub fn fmi2SetBoolean(c: C, vr: *const u32, n: usize, value: *const c_int) -> Status;
    pub fn fmi2SetRealInputDerivatives(
        c: C,
        vr: *const u32,
        n: usize,
        order: *const c_int,
        value: *const f64,
    ) -> Status;
    pub fn fmi2GetRealOutputDerivatives(c: C, vr: *const u32, n: usize, order: *const c_int, value: *mut f64)
    -> Status;
    pub fn fmi2GetDirectionalDerivative(
        c: C,
        unknowns: *const u32,
        nu: usize,
        knowns: *const u32,
        nk: usize,
        seed: *const f64,
        value: *mut f64,
    ) -> Status;
    pub fn fmi2Reset(c: C) -> Status;
    pub fn fmi2GetFMUstate(c: C, state: *mut FmuState) -> Status;
    pub fn fmi2SetFMUstate(c: C, state: FmuState) -> Status;
    pub fn fmi2SerializedFMUstateSize(c: C, state: FmuState, size: *mut usize) -> Status;
    pub fn fmi2SerializeFMUstate(c: C, state: FmuState, bytes: *mut c_char, size: usize) -> Status;
    pub fn fmi2DeSerializeFMUstate(c: C, bytes: *const c_char, size: usize, state: *mut FmuState) -> Status;
    pub fn fmi2DoStep(c: C, time: f64, size: f64, no_set_state_before: c_int) -> Status;
    pub fn fmi2GetRealStatus(c: C, kind: c_int, value: *mut f64) -> Status;
    pub fn fmi2EnterEventMode(c: C) -> Status;
    pub fn fmi2NewDiscreteStates(c: C, info: *mut EventInfo) -> Status;
    pub fn fmi2EnterContinuousTimeMode(c: C) -> Status;
    pub fn fmi2CompletedIntegratorStep(
        c: C,
        no_set_state_before: c_int,
        enter_event_mode: *mut c_int,
        terminate: *mut c_int,
    ) -> Status;
    pub fn fmi2SetTime(c: C, time: f64) -> Status;
    pub fn fmi2SetContinuousStates(c: C, x: *const f64, n: usize) -> Status;
    pub fn fmi2GetDerivatives(c: C, derivatives: *mut f64, n: usize) -> Status;
    pub fn fmi2GetEventIndicators(c: C, indicators: *mut f64, n: usize) -> Status;
    pub fn fmi2GetContinuousStates(c: C, x: *mut f64, n: usize) -> Status;
}
