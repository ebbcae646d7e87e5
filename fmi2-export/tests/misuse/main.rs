//! Whatever a host passes: a defined answer, a message, and no change of the instance.

mod arguments;
#[path = "../common/mod.rs"]
mod common;
mod exchange;
mod reentry;
mod states;
mod steps;
mod values;

use std::ffi::{c_int, c_void};
use std::ptr::{null, null_mut};

use common::misbehaving::{INPUT, State, bring};
use common::{ERROR, Fmu, Slave};

/// A call is refused with a message that says this, and changes nothing.
#[track_caller]
fn refused(slave: &Slave, says: &str, status: impl FnOnce() -> c_int) {
    refused_with(ERROR, slave, says, status);
}

/// As [`refused`], with this status.
#[track_caller]
fn refused_with(expected: c_int, slave: &Slave, says: &str, status: impl FnOnce() -> c_int) {
    let before = slave.blob();
    let told = slave.messages().len();
    assert_eq!(status(), expected, "expected: {says}");
    let news = &slave.messages()[told..];
    assert_eq!(news.len(), 1, "{news:?}");
    assert!(news[0].2.contains(says), "{:?} does not say {says:?}", news[0].2);
    assert!(slave.blob() == before, "the state has changed, though: {}", news[0].2);
}

fn stepping(fmu: &Fmu) -> Slave<'_> {
    bring(fmu, &fmu.guids()[0], State::StepComplete)
}

/// Every function that takes arrays of variables, called with empty ones.
fn calls_for_no_variable(fmu: &Fmu, c: *mut c_void) -> [c_int; 11] {
    [
        fmu.fmi2GetReal(c, null(), 0, null_mut()),
        fmu.fmi2GetInteger(c, null(), 0, null_mut()),
        fmu.fmi2GetBoolean(c, null(), 0, null_mut()),
        fmu.fmi2GetString(c, null(), 0, null_mut()),
        fmu.fmi2SetReal(c, null(), 0, null()),
        fmu.fmi2SetInteger(c, null(), 0, null()),
        fmu.fmi2SetBoolean(c, null(), 0, null()),
        fmu.fmi2SetString(c, null(), 0, null()),
        fmu.fmi2GetDirectionalDerivative(c, null(), 0, null(), 0, null(), null_mut()),
        fmu.fmi2SetRealInputDerivatives(c, null(), 0, null(), null()),
        fmu.fmi2GetRealOutputDerivatives(c, null(), 0, null(), null_mut()),
    ]
}

/// Every function that takes a component, otherwise called with nothing.
fn calls_with_nothing(fmu: &Fmu, c: *mut c_void) -> Vec<c_int> {
    let others = [
        fmu.fmi2SetDebugLogging(c, 0, 0, null()),
        fmu.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
        fmu.fmi2EnterInitializationMode(c),
        fmu.fmi2ExitInitializationMode(c),
        fmu.fmi2Terminate(c),
        fmu.fmi2Reset(c),
        fmu.fmi2GetFMUstate(c, null_mut()),
        fmu.fmi2SetFMUstate(c, null_mut()),
        fmu.fmi2FreeFMUstate(c, null_mut()),
        fmu.fmi2SerializedFMUstateSize(c, null_mut(), null_mut()),
        fmu.fmi2SerializeFMUstate(c, null_mut(), null_mut(), 0),
        fmu.fmi2DeSerializeFMUstate(c, null(), 0, null_mut()),
        fmu.fmi2DoStep(c, 0.0, 0.1, 1),
        fmu.fmi2CancelStep(c),
        fmu.fmi2GetStatus(c, 0, null_mut()),
        fmu.fmi2GetRealStatus(c, 2, null_mut()),
        fmu.fmi2GetIntegerStatus(c, 0, null_mut()),
        fmu.fmi2GetBooleanStatus(c, 3, null_mut()),
        fmu.fmi2GetStringStatus(c, 1, null_mut()),
        fmu.fmi2EnterEventMode(c),
        fmu.fmi2NewDiscreteStates(c, null_mut()),
        fmu.fmi2EnterContinuousTimeMode(c),
        fmu.fmi2CompletedIntegratorStep(c, 1, null_mut(), null_mut()),
        fmu.fmi2SetTime(c, 0.0),
        fmu.fmi2SetContinuousStates(c, null(), 0),
        fmu.fmi2GetDerivatives(c, null_mut(), 0),
        fmu.fmi2GetEventIndicators(c, null_mut(), 0),
        fmu.fmi2GetContinuousStates(c, null_mut(), 0),
        fmu.fmi2GetNominalsOfContinuousStates(c, null_mut(), 0),
        // Reading into and from somewhere, of no component.
        fmu.fmi2GetReal(c, &INPUT, 1, &mut 0.0),
        fmu.fmi2SetReal(c, &INPUT, 1, &0.0),
        fmu.fmi2GetRealStatus(c, 2, &mut 0.0),
    ];
    [&others[..], &calls_for_no_variable(fmu, c)].concat()
}
