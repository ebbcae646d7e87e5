//! The tables of allowed calls of FMI 2.0.4, sections 3.2.3 and 4.2.4: every function in every state of both interfaces.
//!
//! Where the slave is more generous than the table, the row says so. What is not in the table: a refused call leaves the
//! instance as it was, so the state `error` is entered only when the model itself fails or panics.

mod common;

use std::ffi::c_int;
use std::ptr::{null, null_mut};

use common::misbehaving::{
    ExchangeState, FIXED, INDICATORS, INPUT, INTEGER, LOCAL, OUTPUT, STATES, State, TUNABLE, bring, bring_exchange,
};
use common::{DISCARD, ERROR, EventInfo, Fmu, OK, Slave};

#[path = "../examples/misbehaving.rs"]
#[allow(missing_docs, dead_code)]
mod model;

struct Row {
    what: String,
    /// A letter for each state of co-simulation in which the call is allowed: (i)nstantiated, initialization (m)ode, step
    /// (c)omplete, step (f)ailed, (t)erminated, (e)rror.
    allowed: &'static str,
    /// The same of model exchange, which has (E)vent mode and (C)ontinuous-time mode.
    exchange: &'static str,
    /// The status then.
    status: c_int,
    call: Box<dyn Fn(&Slave) -> c_int>,
}

impl Row {
    fn allows(&self, state: State) -> bool {
        let letter = match state {
            State::Instantiated => 'i',
            State::Initialization => 'm',
            State::StepComplete => 'c',
            State::StepFailed => 'f',
            State::Terminated => 't',
            State::Error | State::Panicked => 'e',
        };
        self.allowed.contains(letter)
    }

    fn allows_exchange(&self, state: ExchangeState) -> bool {
        let letter = match state {
            ExchangeState::Instantiated => 'i',
            ExchangeState::Initialization => 'm',
            ExchangeState::EventMode => 'E',
            ExchangeState::ContinuousTimeMode => 'C',
            ExchangeState::Terminated => 't',
            ExchangeState::Error | ExchangeState::Panicked => 'e',
        };
        self.exchange.contains(letter)
    }
}

#[allow(clippy::too_many_lines)] // It is a long table.
fn table() -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |what: &str, allowed, exchange, status, call: Box<dyn Fn(&Slave) -> c_int>| {
        rows.push(Row { what: what.to_owned(), allowed, exchange, status, call });
    };
    macro_rules! row {
        ($what:expr, $allowed:expr, $exchange:expr, $status:expr, |$fmu:ident, $c:ident| $call:expr) => {
            add(
                $what,
                $allowed,
                $exchange,
                $status,
                Box::new(move |slave: &Slave| {
                    let ($fmu, $c) = (slave.fmu, slave.component);
                    $call
                }),
            )
        };
    }
    row!("fmi2GetTypesPlatform", "imcfte", "imECte", OK, |fmu, _c| c_int::from(fmu.fmi2GetTypesPlatform().is_null()));
    row!("fmi2GetVersion", "imcfte", "imECte", OK, |fmu, _c| c_int::from(fmu.fmi2GetVersion().is_null()));
    // The table is about one instance; another can be made at any time.
    row!("fmi2Instantiate", "imcfte", "imECte", OK, |fmu, _c| {
        drop(fmu.instantiate(&fmu.guids()[0]));
        OK
    });
    // fmi2FreeInstance is called in every state by `Slave`'s destructor.
    row!("fmi2SetDebugLogging", "imcfte", "imECte", OK, |fmu, c| fmu.fmi2SetDebugLogging(c, 1, 0, null()));
    row!("fmi2SetupExperiment", "i", "i", OK, |fmu, c| fmu.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0));
    row!("fmi2EnterInitializationMode", "i", "i", OK, |fmu, c| fmu.fmi2EnterInitializationMode(c));
    row!("fmi2ExitInitializationMode", "m", "m", OK, |fmu, c| fmu.fmi2ExitInitializationMode(c));
    row!("fmi2Terminate", "cf", "EC", OK, |fmu, c| fmu.fmi2Terminate(c));
    row!("fmi2Reset", "imcfte", "imECte", OK, |fmu, c| fmu.fmi2Reset(c));
    // Condition 2 restricts the initialization mode to outputs; here every variable can be read then.
    for (kind, vr) in [("input", INPUT), ("fixed", FIXED), ("tunable", TUNABLE), ("output", OUTPUT), ("local", LOCAL)] {
        row!(&format!("fmi2GetReal of {kind}"), "mcfte", "mECte", OK, |fmu, c| fmu.fmi2GetReal(c, &vr, 1, &mut 0.0));
        if vr == LOCAL {
            continue;
        }
        row!(&format!("fmi2GetInteger of {kind}"), "mcfte", "mECte", OK, |fmu, c| {
            fmu.fmi2GetInteger(c, &(vr + INTEGER), 1, &mut 0)
        });
        row!(&format!("fmi2GetBoolean of {kind}"), "mcfte", "mECte", OK, |fmu, c| fmu
            .fmi2GetBoolean(c, &vr, 1, &mut 0));
        row!(&format!("fmi2GetString of {kind}"), "mcfte", "mECte", OK, |fmu, c| fmu.fmi2GetString(
            c,
            &vr,
            1,
            &mut null()
        ));
    }
    // Conditions 1, 3 and 6; by condition 1, inputs could not be set in `instantiated`, but hosts do that.
    // In continuous-time mode nothing is set that jumps.
    for (kind, vr, allowed, real, other) in [
        ("input", INPUT, "imc", "imEC", "imE"),
        ("fixed", FIXED, "im", "im", "im"),
        ("tunable", TUNABLE, "imc", "imE", "imE"),
        ("output", OUTPUT, "", "", ""),
        ("local", LOCAL, "", "", ""),
    ] {
        row!(&format!("fmi2SetReal of {kind}"), allowed, real, OK, |fmu, c| fmu.fmi2SetReal(c, &vr, 1, &0.25));
        if vr == LOCAL {
            continue;
        }
        row!(&format!("fmi2SetInteger of {kind}"), allowed, other, OK, |fmu, c| {
            fmu.fmi2SetInteger(c, &(vr + INTEGER), 1, &1)
        });
        row!(&format!("fmi2SetBoolean of {kind}"), allowed, other, OK, |fmu, c| fmu.fmi2SetBoolean(c, &vr, 1, &1));
        row!(&format!("fmi2SetString of {kind}"), allowed, other, OK, |fmu, c| {
            fmu.fmi2SetString(c, &vr, 1, &c"text".as_ptr())
        });
    }
    row!("fmi2GetFMUstate, fmi2FreeFMUstate", "imcfte", "imECte", OK, |fmu, c| {
        let mut state = null_mut();
        fmu.fmi2GetFMUstate(c, &mut state).max(fmu.fmi2FreeFMUstate(c, &mut state))
    });
    row!("fmi2SetFMUstate", "imcfte", "imECte", OK, |fmu, c| {
        let mut state = null_mut();
        assert_eq!(fmu.fmi2GetFMUstate(c, &mut state), OK);
        fmu.fmi2SetFMUstate(c, state)
    });
    row!("fmi2Serialized…, fmi2Serialize…, fmi2DeSerializeFMUstate", "imcfte", "imECte", OK, |fmu, c| {
        let (mut state, mut size, mut bytes) = (null_mut(), 0, vec![0; 10_000]);
        assert_eq!(fmu.fmi2GetFMUstate(c, &mut state), OK);
        let mut worst = fmu.fmi2SerializedFMUstateSize(c, state, &mut size);
        worst = worst.max(fmu.fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size));
        worst.max(fmu.fmi2DeSerializeFMUstate(c, bytes.as_ptr(), size, &mut null_mut()))
    });
    row!("fmi2GetDirectionalDerivative", "mcfte", "mECte", OK, |fmu, c| {
        fmu.fmi2GetDirectionalDerivative(c, &OUTPUT, 1, &INPUT, 1, &1.0, &mut 0.0)
    });
    row!("fmi2SetRealInputDerivatives", "imc", "", OK, |fmu, c| fmu
        .fmi2SetRealInputDerivatives(c, &INPUT, 1, &1, &0.5));
    row!("fmi2GetRealOutputDerivatives", "cfte", "", OK, |fmu, c| {
        fmu.fmi2GetRealOutputDerivatives(c, &OUTPUT, 1, &1, &mut 0.0)
    });
    row!("fmi2DoStep", "c", "", OK, |fmu, c| fmu.fmi2DoStep(c, 0.5, 0.5, 1));
    // Only in `stepInProgress`, which a slave with synchronous steps is never in.
    row!("fmi2CancelStep", "", "", OK, |fmu, c| fmu.fmi2CancelStep(c));
    // fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated, and one there is not: each has one
    // type, and the first two are about steps in progress. "If a status is required which cannot be retrieved by the
    // slave it returns fmi2Discard."
    for kind in 0..5 {
        let discard_unless = |its: c_int| if kind == its { OK } else { DISCARD };
        row!(&format!("fmi2GetStatus {kind}"), "cft", "", DISCARD, |fmu, c| fmu.fmi2GetStatus(c, kind, &mut 0));
        row!(&format!("fmi2GetRealStatus {kind}"), "cft", "", discard_unless(2), |fmu, c| {
            fmu.fmi2GetRealStatus(c, kind, &mut 0.0)
        });
        row!(&format!("fmi2GetIntegerStatus {kind}"), "cft", "", DISCARD, |fmu, c| {
            fmu.fmi2GetIntegerStatus(c, kind, &mut 0)
        });
        row!(&format!("fmi2GetBooleanStatus {kind}"), "cft", "", discard_unless(3), |fmu, c| {
            fmu.fmi2GetBooleanStatus(c, kind, &mut 0)
        });
        row!(&format!("fmi2GetStringStatus {kind}"), "cft", "", DISCARD, |fmu, c| {
            fmu.fmi2GetStringStatus(c, kind, &mut null())
        });
    }
    // What only model exchange has. A mode that is entered already can be entered; nominal values are told from the first.
    row!("fmi2EnterEventMode", "", "EC", OK, |fmu, c| fmu.fmi2EnterEventMode(c));
    row!("fmi2NewDiscreteStates", "", "E", OK, |fmu, c| fmu.fmi2NewDiscreteStates(c, &mut EventInfo::default()));
    row!("fmi2EnterContinuousTimeMode", "", "E", OK, |fmu, c| fmu.fmi2EnterContinuousTimeMode(c));
    row!("fmi2CompletedIntegratorStep", "", "C", OK, |fmu, c| {
        fmu.fmi2CompletedIntegratorStep(c, 1, &mut 0, &mut 0)
    });
    row!("fmi2SetTime", "", "EC", OK, |fmu, c| fmu.fmi2SetTime(c, 0.25));
    row!("fmi2SetContinuousStates", "", "C", OK, |fmu, c| fmu.fmi2SetContinuousStates(c, &0.5, STATES));
    row!("fmi2GetDerivatives", "", "ECte", OK, |fmu, c| fmu.fmi2GetDerivatives(c, &mut 0.0, STATES));
    row!("fmi2GetEventIndicators", "", "mECte", OK, |fmu, c| {
        fmu.fmi2GetEventIndicators(c, [0.0; INDICATORS].as_mut_ptr(), INDICATORS)
    });
    row!("fmi2GetContinuousStates", "", "mECte", OK, |fmu, c| fmu.fmi2GetContinuousStates(c, &mut 0.0, STATES));
    row!("fmi2GetNominalsOfContinuousStates", "", "imECte", OK, |fmu, c| {
        fmu.fmi2GetNominalsOfContinuousStates(c, &mut 0.0, STATES)
    });
    rows
}

/// Names in `<LogCategories>`.
fn declared_categories() -> Vec<String> {
    let xml = model::FMUS.models()[0].description().unwrap().xml;
    xml.split("<Category name=\"").skip(1).map(|part| part.split('"').next().unwrap().to_owned()).collect()
}

#[test]
fn every_function_in_every_state() {
    let fmu = Fmu::load("misbehaving");
    let guid = &fmu.guids()[0];
    let categories = declared_categories();
    for row in table() {
        for state in State::ALL {
            let slave = bring(&fmu, guid, state);
            let case = format!("{} in {state:?}", row.what);
            if !is_as_the_table_says(&row, row.allows(state), &slave, &categories, &case) {
                works_on(&slave, state, &case);
            }
            slave.start_again();
        }
        for state in ExchangeState::ALL {
            let slave = bring_exchange(&fmu, guid, state);
            let case = format!("{} in {state:?} of model exchange", row.what);
            if !is_as_the_table_says(&row, row.allows_exchange(state), &slave, &categories, &case) {
                exchange_works_on(&slave, state, &case);
            }
            assert_eq!(fmu.fmi2Reset(slave.component), OK);
            slave.start();
            assert_eq!(slave.derivatives(STATES), [0.0], "{case}");
        }
    }
}

/// Makes the call; whether it went well.
fn is_as_the_table_says(row: &Row, is_allowed: bool, slave: &Slave, categories: &[String], case: &str) -> bool {
    let (before, told) = (slave.blob(), slave.messages().len());
    let status = (row.call)(slave);
    let case = format!("{case}: {:?}", slave.log);
    assert_eq!(status, if is_allowed { row.status } else { ERROR }, "{case}");
    if status == OK {
        return true;
    }
    assert_eq!(slave.blob(), before, "the state has changed: {case}");
    let news = &slave.messages()[told..];
    assert_eq!(news.len(), 1, "one message: {case}");
    let (logged, category, message) = &news[0];
    assert!(*logged == status && categories.contains(category) && !message.is_empty(), "{case}");
    false
}

/// What the state of model exchange allows next.
fn exchange_works_on(slave: &Slave, state: ExchangeState, case: &str) {
    let (fmu, c) = (slave.fmu, slave.component);
    match state {
        ExchangeState::Instantiated => slave.initialize(),
        ExchangeState::Initialization => assert_eq!(fmu.fmi2ExitInitializationMode(c), OK, "{case}"),
        ExchangeState::EventMode => _ = slave.update(),
        ExchangeState::ContinuousTimeMode => assert_eq!(slave.set_states(&[0.125]), OK, "{case}"),
        ExchangeState::Terminated | ExchangeState::Error | ExchangeState::Panicked => _ = slave.states(STATES),
    }
}

/// What the state allows next.
fn works_on(slave: &Slave, state: State, case: &str) {
    let (fmu, c) = (slave.fmu, slave.component);
    match state {
        State::Instantiated => slave.initialize(),
        State::Initialization => assert_eq!(fmu.fmi2ExitInitializationMode(c), OK, "{case}"),
        State::StepComplete => assert_eq!(slave.step(0.5, 0.1), OK, "{case}"),
        State::StepFailed => assert_eq!(fmu.fmi2Terminate(c), OK, "{case}"),
        // In the state error, "retrieved values are usable for debugging only".
        State::Terminated | State::Error | State::Panicked => _ = slave.get(OUTPUT),
    }
}

#[test]
fn a_state_saved_in_any_state_can_be_restored_in_any_other() {
    let fmu = Fmu::load("misbehaving");
    let guid = &fmu.guids()[0];
    for from in State::ALL {
        let blob = bring(&fmu, guid, from).blob();
        for to in State::ALL {
            let slave = bring(&fmu, guid, to);
            assert_eq!(slave.load(&blob), OK, "{from:?} to {to:?}: {:?}", slave.log);
            assert_eq!(slave.blob(), blob, "{from:?} to {to:?}");
            for row in table().iter().filter(|row| row.status == OK && row.allows(from)) {
                assert_eq!(slave.load(&blob), OK);
                assert_eq!((row.call)(&slave), OK, "{} in {from:?} restored in {to:?}: {:?}", row.what, slave.log);
            }
        }
    }
}

#[test]
fn a_state_of_model_exchange_saved_in_any_state_can_be_restored_in_any_other() {
    let fmu = Fmu::load("misbehaving");
    let guid = &fmu.guids()[0];
    for from in ExchangeState::ALL {
        let blob = bring_exchange(&fmu, guid, from).blob();
        for to in ExchangeState::ALL {
            let slave = bring_exchange(&fmu, guid, to);
            assert_eq!(slave.load(&blob), OK, "{from:?} to {to:?}: {:?}", slave.log);
            assert_eq!(slave.blob(), blob, "{from:?} to {to:?}");
            for row in table().iter().filter(|row| row.status == OK && row.allows_exchange(from)) {
                assert_eq!(slave.load(&blob), OK);
                assert_eq!((row.call)(&slave), OK, "{} in {from:?} restored in {to:?}: {:?}", row.what, slave.log);
            }
        }
    }
}

#[test]
fn initialization_needs_an_experiment() {
    let fmu = Fmu::load("misbehaving");
    let slave = fmu.instantiate(&fmu.guids()[0]);
    assert_eq!(fmu.fmi2EnterInitializationMode(slave.component), ERROR);
    assert!(slave.message().contains("fmi2SetupExperiment"), "{}", slave.message());
    slave.initialize();
}

#[test]
fn the_tables_last_rows_report_time_and_no_wish_to_terminate() {
    let fmu = Fmu::load("misbehaving");
    let slave = bring(&fmu, &fmu.guids()[0], State::StepFailed);
    let (mut time, mut wish) = (f64::NAN, 7);
    assert_eq!(fmu.fmi2GetRealStatus(slave.component, 2, &mut time), OK);
    assert_eq!(fmu.fmi2GetBooleanStatus(slave.component, 3, &mut wish), OK);
    assert_eq!((time, wish), (0.5, 0), "end of the last successful step");
}
