//! Model exchange and co-simulation refuse each other's functions; states, times and counts that cannot be.

use std::ptr::{null, null_mut};

use crate::common::misbehaving::{
    DERIVATIVE, ExchangeState, FAULT, Fault, INDICATORS, INPUT, INTEGER, OUTPUT, STATE, STATES, TUNABLE, bring_exchange,
};
use crate::common::{DISCARD, ERROR, EventInfo, Fmu, MODEL_EXCHANGE, OK};
use crate::{refused, refused_with, stepping};

#[test]
fn a_model_without_continuous_states_is_for_co_simulation_only() {
    let fmu = Fmu::load("first_order_lag");
    let log = fmu.instantiate_as(MODEL_EXCHANGE, &fmu.guids()[0]).err().unwrap();
    let log = log.lock().unwrap();
    assert!(log[0].2.contains("this FMU is for co-simulation (fmi2CoSimulation) only"), "{log:?}");
}

#[test]
fn each_interface_refuses_the_functions_of_the_other() {
    let fmu = Fmu::load("misbehaving");
    let guid = &fmu.guids()[0];
    let slave = stepping(&fmu);
    let says = "is for model exchange; this instance is for co-simulation";
    refused(&slave, says, || fmu.fmi2EnterEventMode(slave.component));
    refused(&slave, says, || slave.set_time(1.0));
    refused(&slave, says, || slave.set_states(&[0.0]));
    let exchange = bring_exchange(&fmu, guid, ExchangeState::ContinuousTimeMode);
    refused(&exchange, "is not allowed in continuous-time mode", || exchange.step(0.0, 0.5));
    let says = "is for co-simulation; this instance is for model exchange";
    refused(&exchange, says, || fmu.fmi2GetRealStatus(exchange.component, 2, &mut 0.0));
    refused(&exchange, says, || fmu.fmi2SetRealInputDerivatives(exchange.component, &INPUT, 1, &1, &0.0));
    refused(&exchange, says, || fmu.fmi2GetRealOutputDerivatives(exchange.component, &OUTPUT, 1, &1, &mut 0.0));
    // A saved state of the one is none of the other.
    let mut state = slave.save();
    refused(&exchange, "is of an instance for co-simulation", || fmu.fmi2SetFMUstate(exchange.component, state));
    let blob = slave.blob();
    refused(&exchange, "is of an instance for co-simulation", || exchange.load(&blob));
    assert_eq!(fmu.fmi2FreeFMUstate(slave.component, &raw mut state), OK);
    let blob = exchange.blob();
    refused(&slave, "is of an instance for model exchange", || slave.load(&blob));
}

#[test]
fn states_times_and_counts_that_cannot_be_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = bring_exchange(&fmu, &fmu.guids()[0], ExchangeState::ContinuousTimeMode);
    let c = slave.component;
    for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(&slave, "it must be finite", || slave.set_time(time));
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused_with(DISCARD, &slave, "the state state cannot be", || slave.set_states(&[bad]));
    }
    for count in [0, 2, 100] {
        let mut buffer = vec![7.0; 100];
        let says = format!("the model has {STATES} continuous states, not {count}");
        refused(&slave, &says, || slave.set_states(&buffer[..count]));
        refused(&slave, &says, || fmu.fmi2GetContinuousStates(c, buffer.as_mut_ptr(), count));
        refused(&slave, &says, || fmu.fmi2GetDerivatives(c, buffer.as_mut_ptr(), count));
        refused(&slave, &says, || fmu.fmi2GetNominalsOfContinuousStates(c, buffer.as_mut_ptr(), count));
        assert!(buffer.iter().all(|value| *value == 7.0), "written though refused");
    }
    let says = format!("the model has {INDICATORS} event indicators, not 1");
    refused(&slave, &says, || fmu.fmi2GetEventIndicators(c, &mut 0.0, 1));
    refused(&slave, "x is a null pointer", || fmu.fmi2SetContinuousStates(c, null(), STATES));
    refused(&slave, "x is a null pointer", || fmu.fmi2GetContinuousStates(c, null_mut(), STATES));
    refused(&slave, "derivatives is a null pointer", || fmu.fmi2GetDerivatives(c, null_mut(), STATES));
    refused(&slave, "eventIndicators is a null pointer", || fmu.fmi2GetEventIndicators(c, null_mut(), INDICATORS));
    refused(&slave, "x_nominal is a null pointer", || fmu.fmi2GetNominalsOfContinuousStates(c, null_mut(), STATES));
    let mut flag = 0;
    refused(&slave, "enterEventMode is a null pointer", || {
        fmu.fmi2CompletedIntegratorStep(c, 1, null_mut(), &raw mut flag)
    });
    refused(&slave, "terminateSimulation is a null pointer", || {
        fmu.fmi2CompletedIntegratorStep(c, 1, &raw mut flag, null_mut())
    });
    assert_eq!(fmu.fmi2EnterEventMode(c), OK);
    refused(&slave, "eventInfo is a null pointer", || fmu.fmi2NewDiscreteStates(c, null_mut()));
    // What jumps is set in event mode only; what does not, in both.
    assert_eq!(slave.set_integer(INTEGER, 3), OK);
    assert_eq!(slave.set(TUNABLE, 0.5), OK);
    slave.update();
    refused(&slave, "what jumps is set in event mode", || slave.set(TUNABLE, 0.25));
    refused(&slave, "is not allowed in continuous-time mode", || slave.set_integer(INTEGER, 4));
    assert_eq!(slave.set(INPUT, 0.25), OK);
}

#[test]
fn the_jacobian_is_asked_for_by_states_and_their_derivatives() {
    let fmu = Fmu::load("misbehaving");
    for slave in [bring_exchange(&fmu, &fmu.guids()[0], ExchangeState::ContinuousTimeMode), stepping(&fmu)] {
        let derivative = |unknown: u32, known: u32| {
            let mut value = f64::NAN;
            let status = fmu.fmi2GetDirectionalDerivative(
                slave.component,
                &raw const unknown,
                1,
                &raw const known,
                1,
                &2.0,
                &raw mut value,
            );
            assert_eq!(status, OK, "{:?}", slave.log);
            value
        };
        assert_eq!(derivative(DERIVATIVE, STATE), -2.0);
        assert_eq!(derivative(DERIVATIVE, INPUT), 2.0);
        assert_eq!(derivative(OUTPUT, STATE), 2.0);
        let refuse = |unknown: u32, known: u32, says: &str| {
            refused(&slave, says, || {
                fmu.fmi2GetDirectionalDerivative(
                    slave.component,
                    &raw const unknown,
                    1,
                    &raw const known,
                    1,
                    &1.0,
                    &mut 0.0,
                )
            });
        };
        refuse(STATE, INPUT, "state is no output");
        refuse(OUTPUT, DERIVATIVE, "der(state) is no input");
    }
}

#[test]
fn a_model_that_cannot_compute_is_heard_of_and_the_solver_may_try_again() {
    let fmu = Fmu::load("misbehaving");
    let guid = &fmu.guids()[0];
    let with = |fault: Fault| {
        let slave = bring_exchange(&fmu, guid, ExchangeState::EventMode);
        assert_eq!(slave.set_integer(FAULT, fault as i32), OK);
        slave.update();
        slave
    };
    let mut buffer = [7.0; 2];
    let slave = with(Fault::DerivativesAreNan);
    let says = "der(state) is NaN at t = 0.0 s";
    refused_with(DISCARD, &slave, says, || fmu.fmi2GetDerivatives(slave.component, buffer.as_mut_ptr(), STATES));
    let slave = with(Fault::IndicatorsAreInfinite);
    let says = "event indicator 2 is inf";
    refused_with(DISCARD, &slave, says, || {
        fmu.fmi2GetEventIndicators(slave.component, buffer.as_mut_ptr(), INDICATORS)
    });
    assert_eq!(buffer, [7.0; 2], "written though refused");
    let slave = with(Fault::StatesAreRefused);
    refused_with(DISCARD, &slave, "states", || slave.set_states(&[0.5]));
    assert_eq!(slave.states(STATES), [0.0], "the old state is put back");
    let slave = with(Fault::CompletedEnds);
    let (mut enter, mut terminate) = (7, 7);
    assert_eq!(fmu.fmi2CompletedIntegratorStep(slave.component, 1, &raw mut enter, &raw mut terminate), OK);
    assert_eq!((enter, terminate), (0, 1));
    let slave = bring_exchange(&fmu, guid, ExchangeState::EventMode);
    assert_eq!(slave.set_integer(FAULT, Fault::UpdateNeverEnds as i32), OK);
    let mut info = EventInfo::default();
    assert_eq!(fmu.fmi2NewDiscreteStates(slave.component, &raw mut info), OK);
    assert_eq!(info, EventInfo { again: 1, terminate: 1, ..EventInfo::default() });
    assert_eq!(slave.set_integer(FAULT, Fault::StepWarns as i32), OK);
    assert_eq!(slave.update(), EventInfo { has_next_time: 1, next_time: 1.0, ..EventInfo::default() });
    assert_eq!(slave.message(), "100 %%s of ##r1##");
    let slave = bring_exchange(&fmu, guid, ExchangeState::EventMode);
    assert_eq!(slave.set_integer(FAULT, Fault::UpdateNeverComes as i32), OK);
    assert_eq!(slave.update(), EventInfo::default());
    for (fault, says) in [
        (Fault::UpdateLosesTime, "its next event comes at t = NaN"),
        (Fault::StepGivesNan, "state is NaN after an event at t = 0.0 s"),
    ] {
        let slave = bring_exchange(&fmu, guid, ExchangeState::EventMode);
        assert_eq!(slave.set_integer(FAULT, fault as i32), OK);
        let mut info = EventInfo { again: 7, ..EventInfo::default() };
        assert_eq!(fmu.fmi2NewDiscreteStates(slave.component, &raw mut info), ERROR);
        assert!(slave.message().contains(says), "{}", slave.message());
        assert_eq!(info.again, 7, "written though failed");
        assert_eq!(
            fmu.fmi2EnterContinuousTimeMode(slave.component),
            ERROR,
            "nothing leads on but a saved state or a reset"
        );
    }
    let slave = with(Fault::None);
    let mut nominal = f64::NAN;
    assert_eq!(fmu.fmi2GetNominalsOfContinuousStates(slave.component, &raw mut nominal, 1), OK);
    assert_eq!(nominal, 2.0, "an order of magnitude has no sign");
}
