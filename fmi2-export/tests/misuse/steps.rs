//! Experiments and steps that cannot be.

use std::ffi::c_int;

use crate::common::misbehaving::{INPUT, LIMITED, instantiate};
use crate::common::{Fmu, OK};
use crate::{refused, stepping};

#[test]
fn experiments_that_cannot_be_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = instantiate(&fmu);
    let setup = |tolerance: Option<f64>, start, stop: Option<f64>| {
        let (has_tolerance, has_stop) = (c_int::from(tolerance.is_some()), c_int::from(stop.is_some()));
        let c = slave.component;
        // What is not defined is meaningless, so it may be anything.
        let nan = f64::NAN;
        fmu.fmi2SetupExperiment(c, has_tolerance, tolerance.unwrap_or(nan), start, has_stop, stop.unwrap_or(nan))
    };
    for start in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(&slave, "startTime", || setup(None, start, None));
    }
    for stop in [f64::NAN, 0.5, f64::NEG_INFINITY] {
        refused(&slave, "stopTime", || setup(None, 1.0, Some(stop)));
    }
    for tolerance in [f64::NAN, 0.0, -1e-6, f64::INFINITY] {
        refused(&slave, "tolerance", || setup(Some(tolerance), 0.0, None));
    }
    for (start, stop) in [(0.0, Some(f64::INFINITY)), (-5.0, Some(-5.0)), (1e300, None), (0.0, None)] {
        assert_eq!(setup(Some(1e-3), start, stop), OK, "may be called again before initialization");
    }
}

#[test]
fn steps_that_cannot_be_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    for size in [0.0, -0.0, -0.1, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(&slave, "communicationStepSize", || slave.step(0.5, size));
    }
    for size in [5e-324, f64::MIN_POSITIVE, 1e-17] {
        refused(&slave, "is too small to change the time 0.5", || slave.step(0.5, size));
    }
    for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(&slave, "currentCommunicationPoint", || slave.step(time, 0.5));
    }
    for time in [0.0, 0.49, 0.51, -0.5, 1e300] {
        refused(&slave, "the last step ended at 0.5", || slave.step(time, 0.5));
    }
    // A host that computes its points as start + i h is off by a few units in the last place.
    assert_eq!(slave.step(0.5 + 1e-16, 0.5), OK);
    assert_eq!(slave.step(1.0 - 1e-16, 0.5), OK);
}

#[test]
fn the_first_step_starts_at_the_start_and_none_goes_past_the_stop() {
    let fmu = Fmu::load("misbehaving");
    let slave = instantiate(&fmu);
    assert_eq!(fmu.fmi2SetupExperiment(slave.component, 0, 0.0, 2.0, 1, 3.0), OK);
    assert_eq!(fmu.fmi2EnterInitializationMode(slave.component), OK);
    assert_eq!(fmu.fmi2ExitInitializationMode(slave.component), OK);
    refused(&slave, "the last step ended at 2.0", || slave.step(0.0, 0.5));
    refused(&slave, "the step ends at 3.5, past the stop time 3.0", || slave.step(2.0, 1.5));
    let h = 0.1;
    for i in 0..10 {
        assert_eq!(slave.step(2.0 + f64::from(i) * h, h), OK);
    }
    refused(&slave, "past the stop time", || slave.step(3.0, h));
    assert_eq!(fmu.fmi2Terminate(slave.component), OK);
    refused(&slave, "fmi2DoStep is not allowed after termination; fmi2Reset", || slave.step(3.0, h));
}

/// Was: the step was made and the time became infinite.
#[test]
fn a_step_to_the_end_of_all_numbers_is_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    assert_eq!(slave.step(0.5, f64::MAX), OK, "a huge step");
    refused(&slave, "has no finite end", || slave.step(f64::MAX, f64::MAX));
    assert_eq!(slave.load(&slave.blob()), OK);
}

/// Was: the input became infinite, or left its range, at the end of the step.
#[test]
fn a_ramp_that_leads_an_input_out_of_its_range_is_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let ramp = |vr: u32, slope: f64| fmu.fmi2SetRealInputDerivatives(slave.component, &vr, 1, &1, &slope);
    assert_eq!(slave.set(LIMITED, 0.5), OK);
    assert_eq!(ramp(LIMITED, 2.0), OK);
    refused(&slave, "real.limited cannot be 1.5: it must be between -1.0 and 1.0", || slave.step(0.5, 0.5));
    assert_eq!(slave.step(0.5, 0.25), OK);
    assert_eq!(slave.get(LIMITED), 1.0);

    assert_eq!(slave.set(INPUT, f64::MAX), OK);
    assert_eq!(ramp(INPUT, f64::MAX), OK);
    refused(&slave, "real.input cannot be inf", || slave.step(0.75, 0.5));
    assert_eq!(ramp(INPUT, 0.0), OK);
    assert_eq!(slave.step(0.75, 0.5), OK);
}
