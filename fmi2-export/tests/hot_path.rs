//! What a host calls at every communication step allocates nothing (and so formats nothing), once it has been called once.

use std::ffi::CString;
use std::hint::black_box;
use std::ptr::null;

use allocation_counter::measure;
use fmi2_export::ffi::types::{EventInfo, Status};

#[path = "../examples/misbehaving.rs"]
#[allow(missing_docs, dead_code)]
mod model;

#[path = "common/linked.rs"]
mod linked;
use linked::*;

#[test]
fn a_step_and_its_inputs_and_outputs_allocate_nothing() {
    let guid = CString::new(model::FMUS.models()[0].description().unwrap().guid).unwrap();
    let (input, output, order, kind) = (0, 3, 1, 2);
    let (mut real, mut integer, mut boolean) = (0.5, 1, 1);
    // SAFETY: as a host does.
    unsafe {
        let c = fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &NO_CALLBACKS, 0, 1);
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

#[test]
fn what_a_solver_asks_for_allocates_nothing() {
    let guid = CString::new(model::FMUS.models()[0].description().unwrap().guid).unwrap();
    let (input, output, state, derivative) = (0, 3, 6, 7);
    // SAFETY: as a host does.
    unsafe {
        let c = fmi2Instantiate(c"a".as_ptr(), 0, guid.as_ptr(), null(), &NO_CALLBACKS, 0, 1);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        let (mut x, mut z, mut value) = ([0.25], [0.0; 2], 0.0);
        let (mut info, mut enter, mut terminate) = (EventInfo::default(), 0, 0);
        let mut step = || {
            for status in [
                fmi2NewDiscreteStates(c, &mut info),
                fmi2EnterContinuousTimeMode(c),
                fmi2SetTime(c, 0.5),
                fmi2SetContinuousStates(c, x.as_ptr(), 1),
                fmi2SetReal(c, &input, 1, &0.125),
                fmi2GetDerivatives(c, x.as_mut_ptr(), 1),
                fmi2GetEventIndicators(c, z.as_mut_ptr(), 2),
                fmi2GetDirectionalDerivative(c, &derivative, 1, &state, 1, &1.0, &mut value),
                fmi2CompletedIntegratorStep(c, 1, &mut enter, &mut terminate),
                fmi2GetReal(c, &output, 1, &mut value),
                fmi2EnterEventMode(c),
                fmi2GetContinuousStates(c, x.as_mut_ptr(), 1),
            ] {
                assert_eq!(status, Status::Ok);
            }
        };
        step();
        assert_eq!(measure(|| (0..1000).for_each(|_| step())).count_total, 0);
        fmi2FreeInstance(c);
    }
}
