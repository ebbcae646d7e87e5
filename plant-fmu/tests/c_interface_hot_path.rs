//! What a host calls at every communication step allocates nothing, once a step of that size has been made.

use std::ffi::CString;
use std::hint::black_box;
use std::ptr::null;

use allocation_counter::measure;
use fmi2_export::ffi::types::Status;

#[path = "../../fmi2-export/tests/common/linked.rs"]
mod linked;
use linked::*;

/// The value reference of a variable.
fn reference(name: &str) -> u32 {
    let description = plant_fmu::FMUS.models()[0].description().unwrap().xml;
    let (_, rest) = description.split_once(&format!("<ScalarVariable name=\"{name}\" valueReference=\"")).unwrap();
    rest.split_once('"').unwrap().0.parse().unwrap()
}

/// Nor does one in which tips leave the object and hit it again: all modes are ready after the first step.
#[test]
fn bounces_allocate_nothing() {
    let guid = CString::new(plant_fmu::FMUS.models()[0].description().unwrap().guid).unwrap();
    for model in [2, 3] {
        // SAFETY: as a host does.
        unsafe {
            let c = fmi2Instantiate(c"plant".as_ptr(), 1, guid.as_ptr(), null(), &NO_CALLBACKS, 0, 1);
            assert_eq!(fmi2SetInteger(c, [reference("contact_model")].as_ptr(), 1, &raw const model), Status::Ok);
            let starts = [reference("theta1_0"), reference("theta2_0"), reference("restitution")];
            assert_eq!(fmi2SetReal(c, starts.as_ptr(), 3, [-0.01, 0.01, 0.6].as_ptr()), Status::Ok);
            assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
            let outputs = [reference("gap1"), reference("contact_force1"), reference("impact_loss")];
            let mut values = [0.0; 3];
            let mut step = |i: i32| {
                for status in [
                    fmi2SetReal(c, [0, 1].as_ptr(), 2, [0.2, -0.2].as_ptr()),
                    fmi2DoStep(c, f64::from(i) / 1024.0, 1.0 / 1024.0, 1),
                    fmi2GetReal(c, outputs.as_ptr(), 3, values.as_mut_ptr()),
                ] {
                    assert_eq!(status, Status::Ok);
                }
            };
            // A size that comes again has pieces of its own.
            (0..3).for_each(&mut step);
            assert_eq!(measure(|| (3..300).for_each(&mut step)).count_total, 0);
            assert!(values[2] > 0.0, "nothing bounced");
            fmi2FreeInstance(c);
        }
    }
}

#[test]
fn a_step_and_its_inputs_and_outputs_allocate_nothing() {
    let guid = CString::new(plant_fmu::FMUS.models()[0].description().unwrap().guid).unwrap();
    // The inputs come first, then outputs.
    let (inputs, outputs): (Vec<u32>, Vec<u32>) = ((0..6).collect(), (6..60).collect());
    let (mut values, orders, slopes) = (vec![0.0; outputs.len()], [1; 6], [0.5; 6]);
    // SAFETY: as a host does.
    unsafe {
        let c = fmi2Instantiate(c"plant".as_ptr(), 1, guid.as_ptr(), null(), &NO_CALLBACKS, 0, 1);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        let mut step = |i: i32| {
            for status in [
                fmi2SetReal(c, inputs.as_ptr(), 6, [0.2, -0.2, 0.05, 0.0, 0.0, 0.0].as_ptr()),
                fmi2SetRealInputDerivatives(c, inputs.as_ptr(), 6, orders.as_ptr(), slopes.as_ptr()),
                fmi2DoStep(c, f64::from(i) / 1024.0, 1.0 / 1024.0, 1),
                fmi2GetReal(c, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()),
            ] {
                assert_eq!(status, Status::Ok);
            }
        };
        step(0);
        assert_ne!(measure(|| _ = black_box(vec![0])).count_total, 0, "nothing is counted");
        assert_eq!(measure(|| (1..1000).for_each(&mut step)).count_total, 0);
        fmi2FreeInstance(c);
    }
}
