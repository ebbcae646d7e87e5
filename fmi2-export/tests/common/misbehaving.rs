//! The example `misbehaving`: its value references and its faults.
#![allow(dead_code)] // Each test binary uses a part.

use super::{DISCARD, ERROR, EventInfo, Fmu, MODEL_EXCHANGE, OK, Slave};

pub const INPUT: u32 = 0;
pub const FIXED: u32 = 1;
pub const TUNABLE: u32 = 2;
pub const OUTPUT: u32 = 3;
/// Reals only.
pub const LOCAL: u32 = 4;
/// A Real input in [−1, 1].
pub const LIMITED: u32 = 5;
/// The continuous state and its time derivative.
pub const STATE: u32 = 6;
pub const DERIVATIVE: u32 = 7;
/// How many continuous states and event indicators it has.
pub const STATES: usize = 1;
pub const INDICATORS: usize = 2;
/// The first of the Integers: the other kinds' references are one up.
pub const FAULT: u32 = 0;
pub const INTEGER: u32 = 1;

/// Items of the enumeration, as FMI counts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Fault {
    None = 1,
    StepDiscards,
    StepFails,
    StepPanics,
    StepWarns,
    StepGivesNan,
    InitializeDiscards,
    InitializeFails,
    InitializePanics,
    EvaluationPanics,
    DerivativePanics,
    RetuneFails,
    RetuneDiscards,
    RetunePanics,
    ClonePanics,
    SerializeFails,
    SerializePanics,
    RestoreFails,
    RestorePanics,
    DropPanics,
    PayloadPanics,
    DerivativesAreNan,
    DerivativesPanic,
    IndicatorsAreInfinite,
    IndicatorsPanic,
    StatesAreRefused,
    StatesPanic,
    UpdateFails,
    UpdatePanics,
    UpdateNeverEnds,
    UpdateLosesTime,
    UpdateNeverComes,
    CompletedFails,
    CompletedPanics,
    CompletedEnds,
    JacobianPanics,
}

/// States of the standard's state machine that a slave with synchronous steps can be in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    Instantiated,
    Initialization,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
    Panicked,
}

impl State {
    pub const ALL: [Self; 7] = [
        Self::Instantiated,
        Self::Initialization,
        Self::StepComplete,
        Self::StepFailed,
        Self::Terminated,
        Self::Error,
        Self::Panicked,
    ];
}

pub fn instantiate(fmu: &Fmu) -> Slave<'_> {
    fmu.instantiate(&fmu.guids()[0])
}

/// Brings a fresh instance into a state.
pub fn bring<'f>(fmu: &'f Fmu, guid: &str, state: State) -> Slave<'f> {
    let slave = fmu.instantiate(guid);
    let c = slave.component;
    assert_eq!(fmu.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
    if state == State::Instantiated {
        return slave;
    }
    assert_eq!(fmu.fmi2EnterInitializationMode(c), OK);
    if state == State::Initialization {
        return slave;
    }
    assert_eq!(fmu.fmi2ExitInitializationMode(c), OK);
    assert_eq!(slave.step(0.0, 0.5), OK);
    let fails = |fault: Fault, status| {
        assert_eq!(slave.set_integer(FAULT, fault as i32), OK);
        assert_eq!(slave.step(0.5, 0.5), status);
    };
    match state {
        State::Terminated => assert_eq!(fmu.fmi2Terminate(c), OK),
        State::StepFailed => fails(Fault::StepDiscards, DISCARD),
        State::Error => fails(Fault::StepFails, ERROR),
        State::Panicked => fails(Fault::StepPanics, ERROR),
        _ => {}
    }
    slave
}

/// States of the standard's state machine of model exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExchangeState {
    Instantiated,
    Initialization,
    EventMode,
    ContinuousTimeMode,
    Terminated,
    Error,
    Panicked,
}

impl ExchangeState {
    pub const ALL: [Self; 7] = [
        Self::Instantiated,
        Self::Initialization,
        Self::EventMode,
        Self::ContinuousTimeMode,
        Self::Terminated,
        Self::Error,
        Self::Panicked,
    ];
}

/// Brings a fresh instance for model exchange into a state.
pub fn bring_exchange<'f>(fmu: &'f Fmu, guid: &str, state: ExchangeState) -> Slave<'f> {
    let slave = fmu.instantiate_as(MODEL_EXCHANGE, guid).unwrap();
    let c = slave.component;
    assert_eq!(fmu.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
    if state == ExchangeState::Instantiated {
        return slave;
    }
    assert_eq!(fmu.fmi2EnterInitializationMode(c), OK);
    if state == ExchangeState::Initialization {
        return slave;
    }
    assert_eq!(fmu.fmi2ExitInitializationMode(c), OK);
    let fails = |fault: Fault| {
        assert_eq!(slave.set_integer(FAULT, fault as i32), OK);
        assert_eq!(fmu.fmi2NewDiscreteStates(c, &mut EventInfo::default()), ERROR);
    };
    match state {
        ExchangeState::ContinuousTimeMode => _ = slave.update(),
        ExchangeState::Terminated => assert_eq!(fmu.fmi2Terminate(c), OK),
        ExchangeState::Error => fails(Fault::UpdateFails),
        ExchangeState::Panicked => fails(Fault::UpdatePanics),
        _ => {}
    }
    slave
}
