//! A model that fails, panics or warns anywhere: the host gets a status and a message, and never anything worse.

mod common;

use std::ffi::c_int;
use std::ptr::null_mut;

use common::misbehaving::{FAULT, FIXED, Fault, INPUT, OUTPUT, State, TUNABLE, bring, instantiate};
use common::{DISCARD, ERROR, Fmu, OK, Slave, WARNING};

fn with_fault(fmu: &Fmu, state: State, fault: Fault) -> Slave<'_> {
    let slave = bring(fmu, &fmu.guids()[0], state);
    assert_eq!(slave.set_integer(FAULT, fault as i32), OK);
    slave
}

/// Whether the instance is in the state `error`: it can be read and reset, but not stepped.
fn has_failed(slave: &Slave) -> bool {
    slave.get(OUTPUT);
    let failed = slave.step(0.5, 0.5) == ERROR && slave.message().contains("after an error");
    slave.start_again();
    failed
}

#[test]
fn a_failed_initialization_can_be_corrected() {
    let fmu = Fmu::load("misbehaving");
    // Only a step can be discarded: fmi2Discard is not among the answers to the calls that initialize.
    for fault in [Fault::InitializeFails, Fault::InitializeDiscards] {
        let slave = with_fault(&fmu, State::Instantiated, fault);
        let before = slave.blob();
        assert_eq!(fmu.fmi2EnterInitializationMode(slave.component), ERROR, "{fault:?}");
        assert_eq!(slave.message(), "initialize");
        assert_eq!(slave.blob(), before, "what the failed initialization did is undone");
        assert_eq!(slave.set_integer(FAULT, Fault::None as i32), OK);
        slave.initialize();

        let slave = with_fault(&fmu, State::Initialization, fault);
        let before = slave.blob();
        let mut value = -1.0;
        assert_eq!(fmu.fmi2GetReal(slave.component, &OUTPUT, 1, &mut value), ERROR);
        assert_eq!(fmu.fmi2ExitInitializationMode(slave.component), ERROR);
        assert_eq!((slave.blob(), value), (before, -1.0));
        assert_eq!(slave.set_integer(FAULT, Fault::None as i32), OK);
        assert_eq!(slave.set(FIXED, 3.0), OK);
        assert_eq!(slave.get(OUTPUT), 3.0);
        assert_eq!(fmu.fmi2ExitInitializationMode(slave.component), OK);
        assert_eq!(slave.step(0.0, 0.5), OK);
    }
}

#[test]
fn a_discarded_step_can_be_repeated_from_a_saved_state() {
    let fmu = Fmu::load("misbehaving");
    let slave = with_fault(&fmu, State::StepComplete, Fault::StepDiscards);
    let before = slave.save();
    assert_eq!(slave.step(0.5, 0.5), DISCARD);
    let (status, category, message) = slave.messages().pop().unwrap();
    assert_eq!((status, category.as_str(), message.as_str()), (DISCARD, "logStatusDiscard", "step"));
    assert_eq!(slave.step(0.5, 0.25), ERROR, "not without going back");
    assert_eq!(fmu.fmi2SetFMUstate(slave.component, before), OK);
    assert_eq!(slave.set_integer(FAULT, Fault::None as i32), OK);
    assert_eq!(slave.step(0.5, 0.25), OK);
}

#[test]
fn a_failed_step_can_be_repeated_from_a_saved_state() {
    let fmu = Fmu::load("misbehaving");
    for fault in [Fault::StepFails, Fault::StepPanics, Fault::PayloadPanics] {
        let slave = with_fault(&fmu, State::StepComplete, fault);
        let before = slave.save();
        assert_eq!(slave.step(0.5, 0.5), ERROR, "{fault:?}");
        assert_eq!(slave.step(0.5, 0.5), ERROR);
        assert_eq!(fmu.fmi2Terminate(slave.component), ERROR, "not after fmi2Error");
        assert_eq!(fmu.fmi2SetFMUstate(slave.component, before), OK);
        assert_eq!(slave.set_integer(FAULT, Fault::None as i32), OK);
        assert_eq!(slave.step(0.5, 0.5), OK);
    }
}

/// A call that runs into a fault.
type Provoke = fn(&Slave) -> c_int;

#[test]
fn a_panic_wherever_it_happens_is_an_error_with_its_message() {
    let fmu = Fmu::load("misbehaving");
    let cases: [(Fault, State, &str, Provoke); 9] = [
        (Fault::StepPanics, State::StepComplete, "step", |s| s.step(0.5, 0.5)),
        (Fault::PayloadPanics, State::StepComplete, "no message", |s| s.step(0.5, 0.5)),
        (Fault::InitializePanics, State::Instantiated, "initialize", |s| {
            s.fmu.fmi2EnterInitializationMode(s.component)
        }),
        (Fault::EvaluationPanics, State::StepComplete, "evaluation", |s| {
            s.fmu.fmi2GetReal(s.component, &OUTPUT, 1, &mut 0.0)
        }),
        (Fault::DerivativePanics, State::StepComplete, "derivative", |s| {
            s.fmu.fmi2GetDirectionalDerivative(s.component, &OUTPUT, 1, &INPUT, 1, &1.0, &mut 0.0)
        }),
        (Fault::RetunePanics, State::StepComplete, "retune", |s| s.set(TUNABLE, 1.0)),
        (Fault::ClonePanics, State::StepComplete, "clone", |s| s.fmu.fmi2GetFMUstate(s.component, &mut null_mut())),
        (Fault::SerializePanics, State::StepComplete, "serialize", |s| {
            s.fmu.fmi2SerializedFMUstateSize(s.component, s.save(), &mut 0)
        }),
        (Fault::DropPanics, State::StepComplete, "drop", |s| s.fmu.fmi2Reset(s.component)),
    ];
    for (fault, state, message, provoke) in cases {
        let slave = with_fault(&fmu, state, fault);
        assert_eq!(provoke(&slave), ERROR, "{fault:?}");
        let expected = format!("internal error in the model: {message}");
        assert_eq!(slave.messages().pop().unwrap(), (ERROR, "logStatusError".into(), expected), "{fault:?}");
        assert!(has_failed(&slave), "{fault:?}");
    }
}

#[test]
fn a_failed_model_is_not_asked_to_compute_again() {
    let fmu = Fmu::load("misbehaving");
    let slave = with_fault(&fmu, State::StepComplete, Fault::DerivativePanics);
    let derivative = || {
        let mut value = f64::NAN;
        (fmu.fmi2GetDirectionalDerivative(slave.component, &OUTPUT, 1, &INPUT, 1, &1.0, &mut value), value)
    };
    assert_eq!(derivative().0, ERROR);
    assert_eq!(derivative(), (OK, 0.0), "in the state error, values are for debugging only");
}

#[test]
fn tunable_parameters_that_are_not_accepted_are_put_back() {
    let fmu = Fmu::load("misbehaving");
    for fault in [Fault::RetuneFails, Fault::RetuneDiscards] {
        let slave = with_fault(&fmu, State::StepComplete, fault);
        let before = slave.blob();
        assert_eq!(slave.set(TUNABLE, 1.0), ERROR, "{fault:?}");
        assert_eq!(slave.message(), "retune");
        assert_eq!(slave.blob(), before);
        assert_eq!(slave.step(0.5, 0.5), OK);
    }
}

#[test]
fn a_warning_is_told_the_step_is_ok_and_the_text_is_safe_for_printf() {
    let fmu = Fmu::load("misbehaving");
    let slave = with_fault(&fmu, State::StepComplete, Fault::StepWarns);
    assert_eq!(slave.step(0.5, 0.5), OK, "the step was done");
    let expected = (WARNING, "logStatusWarning".to_owned(), "100 %%s of ##r1##".to_owned());
    assert_eq!(slave.messages().pop().unwrap(), expected);
    assert_eq!(slave.step(1.0, 0.5), OK);
}

#[test]
fn a_state_that_cannot_be_serialised_or_restored_is_an_error_and_no_change() {
    let fmu = Fmu::load("misbehaving");
    let slave = with_fault(&fmu, State::StepComplete, Fault::SerializeFails);
    let mut size = 7;
    assert_eq!(fmu.fmi2SerializedFMUstateSize(slave.component, slave.save(), &mut size), ERROR);
    assert_eq!(size, 7);
    assert_eq!(slave.step(0.5, 0.5), OK, "the instance works on");

    let blob = with_fault(&fmu, State::StepComplete, Fault::RestoreFails).blob();
    let slave = bring(&fmu, &fmu.guids()[0], State::StepComplete);
    let before = slave.blob();
    assert_eq!(slave.load(&blob), ERROR);
    assert_eq!(slave.message(), "the state cannot be used: restore");
    assert_eq!(slave.blob(), before);

    let blob = with_fault(&fmu, State::StepComplete, Fault::RestorePanics).blob();
    assert_eq!(slave.load(&blob), ERROR);
    assert_eq!(slave.message(), "internal error in the model: restore");
    slave.start_again();
}

#[test]
fn destructors_that_panic_harm_neither_saved_states_nor_other_instances() {
    let fmu = Fmu::load("misbehaving");
    let other = instantiate(&fmu);
    other.initialize();
    let others = other.save();
    {
        let slave = with_fault(&fmu, State::StepComplete, Fault::DropPanics);
        let (mut first, mut second, _third) = (slave.save(), slave.save(), slave.save());
        // The first is kept for its memory until there is the second.
        for state in [&mut first, &mut second] {
            assert_eq!(fmu.fmi2FreeFMUstate(slave.component, state), OK);
            assert!(state.is_null());
        }
        let saved = slave.save();
        assert_eq!(fmu.fmi2SetFMUstate(slave.component, saved), ERROR, "the state before is dropped");
        // The others go with the instance.
    }
    assert_eq!(fmu.fmi2SetFMUstate(other.component, others), OK);
    assert_eq!(other.step(0.0, 0.5), OK);
}

#[test]
fn nan_from_the_model_passes_through_and_does_not_stick() {
    let fmu = Fmu::load("misbehaving");
    let slave = with_fault(&fmu, State::StepComplete, Fault::StepGivesNan);
    assert_eq!(slave.step(0.5, 0.5), OK);
    assert!(slave.get(OUTPUT).is_nan());
    slave.start_again();
    assert!(slave.get(OUTPUT).is_finite());
}
