//! What a host calls at every communication step allocates nothing (and so formats nothing), once it has been called once.

use std::ffi::{CString, c_char, c_int, c_void};
use std::hint::black_box;
use std::ptr::{null, null_mut};

use allocation_counter::measure;
use fmi2_export::ffi::types::{CallbackFunctions, Status};

#[path = "../examples/misbehaving.rs"]
#[allow(missing_docs, dead_code)]
mod model;

type C = *mut c_void;

// The functions that the example defines.
#[allow(clashing_extern_declarations, clippy::too_many_arguments)]
unsafe extern "C" {
    fn fmi2Instantiate(
        name: *const c_char,
        kind: c_int,
        guid: *const c_char,
        resources: *const c_char,
        functions: *const CallbackFunctions,
        visible: c_int,
        logging: c_int,
    ) -> C;
    fn fmi2FreeInstance(c: C);
    fn fmi2SetupExperiment(
        c: C,
        has_tolerance: c_int,
        tolerance: f64,
        start: f64,
        has_stop: c_int,
        stop: f64,
    ) -> Status;
    fn fmi2EnterInitializationMode(c: C) -> Status;
    fn fmi2ExitInitializationMode(c: C) -> Status;
    fn fmi2GetReal(c: C, vr: *const u32, n: usize, value: *mut f64) -> Status;
    fn fmi2GetInteger(c: C, vr: *const u32, n: usize, value: *mut c_int) -> Status;
    fn fmi2GetBoolean(c: C, vr: *const u32, n: usize, value: *mut c_int) -> Status;
    fn fmi2SetReal(c: C, vr: *const u32, n: usize, value: *const f64) -> Status;
    fn fmi2SetInteger(c: C, vr: *const u32, n: usize, value: *const c_int) -> Status;
    fn fmi2SetBoolean(c: C, vr: *const u32, n: usize, value: *const c_int) -> Status;
    fn fmi2SetRealInputDerivatives(c: C, vr: *const u32, n: usize, order: *const c_int, value: *const f64) -> Status;
    fn fmi2GetRealOutputDerivatives(c: C, vr: *const u32, n: usize, order: *const c_int, value: *mut f64) -> Status;
    fn fmi2GetDirectionalDerivative(
        c: C,
        unknowns: *const u32,
        nu: usize,
        knowns: *const u32,
        nk: usize,
        seed: *const f64,
        value: *mut f64,
    ) -> Status;
    fn fmi2DoStep(c: C, time: f64, size: f64, no_set_state_before: c_int) -> Status;
    fn fmi2GetRealStatus(c: C, kind: c_int, value: *mut f64) -> Status;
}

#[test]
fn a_step_and_its_inputs_and_outputs_allocate_nothing() {
    let guid = CString::new(model::FMUS.models()[0].description().unwrap().guid).unwrap();
    let functions = CallbackFunctions {
        logger: None,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: null_mut(),
    };
    let (input, output, order, kind) = (0, 3, 1, 2);
    let (mut real, mut integer, mut boolean) = (0.5, 1, 1);
    // SAFETY: as a host does.
    unsafe {
        let c = fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &functions, 0, 1);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        let mut time = 0.0;
        let mut step = || {
            for status in [
                fmi2SetReal(c, &input, 1, &real),
                fmi2SetInteger(c, &input, 1, &integer),
                fmi2SetBoolean(c, &input, 1, &boolean),
                fmi2SetRealInputDerivatives(c, &input, 1, &order, &0.25),
                fmi2DoStep(c, time, 1e-3, 1),
                fmi2GetReal(c, &output, 1, &mut real),
                fmi2GetInteger(c, &input, 1, &mut integer),
                fmi2GetBoolean(c, &output, 1, &mut boolean),
                fmi2GetRealOutputDerivatives(c, &output, 1, &order, &mut real),
                fmi2GetDirectionalDerivative(c, &output, 1, &input, 1, &1.0, &mut real),
                fmi2GetRealStatus(c, kind, &mut time),
            ] {
                assert_eq!(status, Status::Ok);
            }
        };
        step();
        assert_ne!(measure(|| _ = black_box(vec![0])).count_total, 0, "nothing is counted");
        assert_eq!(measure(|| (0..1000).for_each(|_| step())).count_total, 0);
        fmi2FreeInstance(c);
    }
}
