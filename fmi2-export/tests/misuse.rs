//! Whatever a host passes: a defined answer, a message, and no change of the instance.

mod common;

use std::ffi::{c_char, c_int, c_void};
use std::ptr::{null, null_mut, without_provenance, without_provenance_mut};
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, AtomicPtr, Ordering};

use common::misbehaving::{
    DERIVATIVE, ExchangeState, FAULT, FIXED, Fault, INDICATORS, INPUT, INTEGER, LIMITED, OUTPUT, STATE, STATES, State,
    TUNABLE, bring, bring_exchange, instantiate,
};
use common::{Callbacks, DISCARD, ERROR, EventInfo, Fmu, Log, MODEL_EXCHANGE, OK, Slave, callbacks};

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

/// Every function that takes a component, otherwise called with nothing.
fn calls_with_nothing(fmu: &Fmu, c: *mut c_void) -> [c_int; 43] {
    [
        fmu.fmi2SetDebugLogging(c, 0, 0, null()),
        fmu.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
        fmu.fmi2EnterInitializationMode(c),
        fmu.fmi2ExitInitializationMode(c),
        fmu.fmi2Terminate(c),
        fmu.fmi2Reset(c),
        fmu.fmi2GetReal(c, null(), 0, null_mut()),
        fmu.fmi2GetInteger(c, null(), 0, null_mut()),
        fmu.fmi2GetBoolean(c, null(), 0, null_mut()),
        fmu.fmi2GetString(c, null(), 0, null_mut()),
        fmu.fmi2SetReal(c, null(), 0, null()),
        fmu.fmi2SetInteger(c, null(), 0, null()),
        fmu.fmi2SetBoolean(c, null(), 0, null()),
        fmu.fmi2SetString(c, null(), 0, null()),
        fmu.fmi2GetFMUstate(c, null_mut()),
        fmu.fmi2SetFMUstate(c, null_mut()),
        fmu.fmi2FreeFMUstate(c, null_mut()),
        fmu.fmi2SerializedFMUstateSize(c, null_mut(), null_mut()),
        fmu.fmi2SerializeFMUstate(c, null_mut(), null_mut(), 0),
        fmu.fmi2DeSerializeFMUstate(c, null(), 0, null_mut()),
        fmu.fmi2GetDirectionalDerivative(c, null(), 0, null(), 0, null(), null_mut()),
        fmu.fmi2SetRealInputDerivatives(c, null(), 0, null(), null()),
        fmu.fmi2GetRealOutputDerivatives(c, null(), 0, null(), null_mut()),
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
    ]
}

#[test]
fn no_component_is_an_error_for_every_function() {
    let fmu = Fmu::load("misbehaving");
    // A component is a pointer to something aligned.
    for c in [null_mut(), without_provenance_mut(0x1001)] {
        assert_eq!(calls_with_nothing(&fmu, c), [ERROR; 43]);
        fmu.fmi2FreeInstance(c);
    }
}

#[test]
fn instantiation_with_wrong_arguments_gives_null_and_a_reason_even_without_logging() {
    let fmu = Fmu::load("misbehaving");
    let guid = std::ffi::CString::new(fmu.guids()[0].clone()).unwrap();
    let (name, good) = (c"a".as_ptr(), guid.as_ptr());
    for (name, kind, guid, says) in [
        (null(), 1, good, "instanceName is a null pointer or empty"),
        (c"".as_ptr(), 1, good, "instanceName is a null pointer or empty"),
        (c" \t".as_ptr(), 1, good, "instanceName is a null pointer or empty"),
        (name, -1, good, "fmuType is -1"),
        (name, 2, good, "fmuType is 2"),
        (name, 1, null(), "fmuGUID is a null pointer"),
        (name, 1, c"".as_ptr(), "fmuGUID is \"\""),
        (name, 1, c"{100%s#r1#}".as_ptr(), "fmuGUID is \"{100%%s##r1##}\""),
        (name, 1, c"\xff\xfe".as_ptr(), "fmuGUID is not UTF-8"),
    ] {
        let log = Log::default();
        let component = fmu.fmi2Instantiate(name, kind, guid, null(), &callbacks(&log), 0, 0);
        assert!(component.is_null());
        let log = log.lock().unwrap();
        assert_eq!((log.len(), log[0].0, log[0].1.as_str()), (1, ERROR, "logStatusError"));
        assert!(log[0].2.contains(says), "{} does not say {says}", log[0].2);
    }
    assert!(fmu.fmi2Instantiate(name, 1, good, null(), null(), 0, 1).is_null(), "no callbacks at all");
    let misaligned = without_provenance::<Callbacks>(0x1001);
    assert!(fmu.fmi2Instantiate(name, 1, good, null(), misaligned, 0, 1).is_null());
}

#[test]
fn a_host_without_logger_or_memory_functions_is_served() {
    let fmu = Fmu::load("misbehaving");
    let guid = std::ffi::CString::new(fmu.guids()[0].clone()).unwrap();
    let functions = Callbacks {
        logger: None,
        allocate_memory: null(),
        free_memory: null(),
        step_finished: null(),
        environment: null_mut(),
    };
    let instantiate = |name: *const c_char, guid: *const c_char| {
        fmu.fmi2Instantiate(name, 1, guid, c"file:///nowhere".as_ptr(), &functions, 1, 1)
    };
    assert!(instantiate(c"a".as_ptr(), c"wrong".as_ptr()).is_null());
    // The instance's name is the host's affair.
    let component = instantiate(c"\xff%s%n#".as_ptr(), guid.as_ptr());
    let slave = Slave { fmu: &fmu, component, log: Log::default() };
    assert_eq!(slave.step(0.0, 0.1), ERROR);
    slave.initialize();
    assert_eq!(slave.step(0.0, 0.1), OK);
}

#[test]
fn only_failures_are_logged_with_logging_off_and_what_is_wanted_with_it_on() {
    let fmu = Fmu::load("misbehaving");
    let log = Log::default();
    let guid = std::ffi::CString::new(fmu.guids()[0].clone()).unwrap();
    let component = fmu.fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &callbacks(&log), 0, 0);
    let slave = Slave { fmu: &fmu, component, log };
    slave.initialize();
    assert_eq!(slave.messages(), [], "events wait to be asked for");
    assert_eq!(slave.step(7.0, 0.1), ERROR);
    assert_eq!(slave.messages().len(), 1, "the reason of a failure does not");
    slave.log.lock().unwrap().clear();

    let switch = |on, categories: &[*const c_char]| {
        fmu.fmi2SetDebugLogging(slave.component, on, categories.len(), categories.as_ptr())
    };
    assert_eq!(slave.set_integer(FAULT, Fault::StepWarns as i32), OK);
    let time = std::cell::Cell::new(0.0);
    let count_warnings = || {
        let before = slave.messages().len();
        assert_eq!(slave.step(time.get(), 0.125), OK);
        time.set(time.get() + 0.125);
        slave.messages().len() - before
    };
    assert_eq!(switch(1, &[c"logStatusError".as_ptr(), c"logEvents".as_ptr()]), OK);
    assert_eq!(count_warnings(), 0);
    assert_eq!(switch(1, &[c"logStatusWarning".as_ptr()]), OK);
    assert_eq!(count_warnings(), 1);
    for wrong in [c"logNothing", c"", c"\xff%n", c"LOGSTATUSERROR"] {
        refused(&slave, "there is no log category", || switch(0, &[c"logStatusWarning".as_ptr(), wrong.as_ptr()]));
    }
    refused(&slave, "categories is a null pointer", || switch(0, &[c"logStatusWarning".as_ptr(), null()]));
    refused(&slave, "categories is a null pointer", || fmu.fmi2SetDebugLogging(slave.component, 0, 1, null()));
    assert_eq!(count_warnings(), 1, "what is refused switches nothing");
    assert_eq!(switch(0, &[c"logStatusWarning".as_ptr()]), OK);
    assert_eq!(count_warnings(), 0);
    assert_eq!(switch(1, &[c"logAll".as_ptr()]), OK);
    assert_eq!(count_warnings(), 1);
    assert_eq!(
        fmu.fmi2SetDebugLogging(slave.component, 0, 0, without_provenance(1)),
        OK,
        "the array is undefined then"
    );
    assert_eq!(count_warnings(), 0);
}

#[test]
fn arrays_that_are_null_misaligned_or_impossible_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let c = slave.component;
    refused(&slave, "vr is a null pointer", || fmu.fmi2GetReal(c, null(), 1, &mut 0.0));
    refused(&slave, "value is a null pointer", || fmu.fmi2GetReal(c, &INPUT, 1, null_mut()));
    refused(&slave, "vr is a null pointer", || fmu.fmi2GetInteger(c, null(), 1, &mut 0));
    refused(&slave, "value is a null pointer", || fmu.fmi2GetInteger(c, &FAULT, 1, null_mut()));
    refused(&slave, "vr is a null pointer", || fmu.fmi2GetBoolean(c, null(), 1, &mut 0));
    refused(&slave, "value is a null pointer", || fmu.fmi2GetBoolean(c, &INPUT, 1, null_mut()));
    refused(&slave, "vr is a null pointer", || fmu.fmi2GetString(c, null(), 1, &mut null()));
    refused(&slave, "value is a null pointer", || fmu.fmi2GetString(c, &INPUT, 1, null_mut()));
    refused(&slave, "vr is a null pointer", || fmu.fmi2SetReal(c, null(), 1, &0.0));
    refused(&slave, "value is a null pointer", || fmu.fmi2SetReal(c, &INPUT, 1, null()));
    refused(&slave, "vr is a null pointer", || fmu.fmi2SetInteger(c, null(), 1, &0));
    refused(&slave, "value is a null pointer", || fmu.fmi2SetInteger(c, &FAULT, 1, null()));
    refused(&slave, "vr is a null pointer", || fmu.fmi2SetBoolean(c, null(), 1, &0));
    refused(&slave, "value is a null pointer", || fmu.fmi2SetBoolean(c, &INPUT, 1, null()));
    refused(&slave, "vr is a null pointer", || fmu.fmi2SetString(c, null(), 1, &c"".as_ptr()));
    refused(&slave, "value is a null pointer", || fmu.fmi2SetString(c, &INPUT, 1, null()));
    refused(&slave, "value is a null pointer", || fmu.fmi2SetString(c, &INPUT, 1, &null()));
    refused(&slave, "order is a null pointer", || fmu.fmi2SetRealInputDerivatives(c, &INPUT, 1, null(), &0.0));
    refused(&slave, "value is a null pointer", || fmu.fmi2SetRealInputDerivatives(c, &INPUT, 1, &1, null()));
    refused(&slave, "order is a null pointer", || fmu.fmi2GetRealOutputDerivatives(c, &OUTPUT, 1, null(), &mut 0.0));
    refused(&slave, "value is a null pointer", || fmu.fmi2GetRealOutputDerivatives(c, &OUTPUT, 1, &1, null_mut()));
    let (y, u): (*const u32, *const u32) = (&OUTPUT, &INPUT);
    for (unknowns, knowns, seed, value, says) in [
        (null(), u, 1.0, 0.0, "vUnknown_ref"),
        (y, null(), 1.0, 0.0, "vKnown_ref"),
        (y, u, f64::NAN, 0.0, "dvKnown"),
        (y, u, 1.0, f64::NAN, "dvUnknown"),
    ] {
        // Not a number stands for no pointer.
        let seed = if seed.is_nan() { null() } else { &raw const seed };
        let mut value = value;
        let value = if value.is_nan() { null_mut() } else { &raw mut value };
        refused(&slave, &format!("{says} is a null pointer"), || {
            fmu.fmi2GetDirectionalDerivative(c, unknowns, 1, knowns, 1, seed, value)
        });
    }
    let odd = [0_u8; 64];
    let odd = odd.as_ptr().wrapping_add(1 + odd.as_ptr().align_offset(8));
    refused(&slave, "value is not aligned", || fmu.fmi2SetReal(c, &INPUT, 1, odd.cast()));
    refused(&slave, "vr is not aligned", || fmu.fmi2SetReal(c, odd.cast(), 1, &0.0));
    refused(&slave, "vr cannot have", || fmu.fmi2GetReal(c, &INPUT, usize::MAX, &mut 0.0));
    refused(&slave, "vr cannot have", || fmu.fmi2SetString(c, &INPUT, usize::MAX / 4, &c"".as_ptr()));
    for status in [
        fmu.fmi2GetStatus(c, 0, null_mut()),
        fmu.fmi2GetRealStatus(c, 2, null_mut()),
        fmu.fmi2GetIntegerStatus(c, 0, null_mut()),
        fmu.fmi2GetBooleanStatus(c, 3, null_mut()),
        fmu.fmi2GetStringStatus(c, 1, null_mut()),
    ] {
        assert_eq!(status, ERROR);
        assert_eq!(slave.message(), "value is a null pointer");
    }
}

#[test]
fn nothing_may_be_asked_for_with_null_pointers() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let c = slave.component;
    let before = slave.blob();
    for status in [
        fmu.fmi2GetReal(c, null(), 0, null_mut()),
        fmu.fmi2GetInteger(c, null(), 0, null_mut()),
        fmu.fmi2GetBoolean(c, null(), 0, null_mut()),
        fmu.fmi2GetString(c, null(), 0, null_mut()),
        fmu.fmi2SetReal(c, null(), 0, null()),
        fmu.fmi2SetInteger(c, null(), 0, null()),
        fmu.fmi2SetBoolean(c, null(), 0, null()),
        fmu.fmi2SetString(c, null(), 0, null()),
        fmu.fmi2SetRealInputDerivatives(c, null(), 0, null(), null()),
        fmu.fmi2GetRealOutputDerivatives(c, null(), 0, null(), null_mut()),
        fmu.fmi2GetDirectionalDerivative(c, null(), 0, null(), 0, null(), null_mut()),
        fmu.fmi2FreeFMUstate(c, &mut null_mut()),
    ] {
        assert_eq!(status, OK);
    }
    assert_eq!(slave.blob(), before);
}

#[test]
fn references_to_no_variable_of_the_type_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let c = slave.component;
    let says = "there is no variable of this type with value reference";
    for (first, kind) in [(8, 'r'), (5, 'i'), (4, 'b'), (4, 's')] {
        for vr in [first, first + 1, u32::MAX / 2, u32::MAX] {
            refused(&slave, says, || match kind {
                'r' => fmu.fmi2GetReal(c, &vr, 1, &mut 0.0),
                'i' => fmu.fmi2GetInteger(c, &vr, 1, &mut 0),
                'b' => fmu.fmi2GetBoolean(c, &vr, 1, &mut 0),
                _ => fmu.fmi2GetString(c, &vr, 1, &mut null()),
            });
            refused(&slave, says, || match kind {
                'r' => fmu.fmi2SetReal(c, &vr, 1, &0.0),
                'i' => fmu.fmi2SetInteger(c, &vr, 1, &0),
                'b' => fmu.fmi2SetBoolean(c, &vr, 1, &0),
                _ => fmu.fmi2SetString(c, &vr, 1, &c"".as_ptr()),
            });
        }
    }
    refused(&slave, says, || fmu.fmi2SetRealInputDerivatives(c, &8, 1, &1, &0.0));
    refused(&slave, says, || fmu.fmi2GetRealOutputDerivatives(c, &8, 1, &1, &mut 0.0));
    refused(&slave, says, || fmu.fmi2GetDirectionalDerivative(c, &8, 1, &INPUT, 1, &1.0, &mut 0.0));
    refused(&slave, says, || fmu.fmi2GetDirectionalDerivative(c, &OUTPUT, 1, &8, 1, &1.0, &mut 0.0));
    refused(&slave, "real.input is no output", || {
        fmu.fmi2GetDirectionalDerivative(c, &INPUT, 1, &INPUT, 1, &1.0, &mut 0.0)
    });
    refused(&slave, "real.fixed is no input", || {
        fmu.fmi2GetDirectionalDerivative(c, &OUTPUT, 1, &FIXED, 1, &1.0, &mut 0.0)
    });
    refused(&slave, "real.input cannot be NaN", || {
        fmu.fmi2GetDirectionalDerivative(c, &OUTPUT, 1, &INPUT, 1, &f64::NAN, &mut 0.0)
    });
    refused(&slave, "real.fixed takes no derivatives", || fmu.fmi2SetRealInputDerivatives(c, &FIXED, 1, &1, &0.0));
    refused(&slave, "real.input provides no derivative", || {
        fmu.fmi2GetRealOutputDerivatives(c, &INPUT, 1, &1, &mut 0.0)
    });
    for order in [0, -1, 2, c_int::MAX, c_int::MIN] {
        refused(&slave, &format!("derivative of order {order}"), || {
            fmu.fmi2SetRealInputDerivatives(c, &INPUT, 1, &order, &0.0)
        });
        if order < 1 {
            refused(&slave, &format!("derivative of order {order}"), || {
                fmu.fmi2GetRealOutputDerivatives(c, &OUTPUT, 1, &order, &mut 0.0)
            });
        }
    }
}

#[test]
fn one_bad_value_of_several_changes_none() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let c = slave.component;
    for bad in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for vr in [INPUT, TUNABLE] {
            refused(&slave, "it must be finite", || fmu.fmi2SetReal(c, [vr, vr].as_ptr(), 2, [2.0, bad].as_ptr()));
        }
        refused(&slave, "it must be finite", || {
            fmu.fmi2SetRealInputDerivatives(c, [INPUT, INPUT].as_ptr(), 2, [1, 1].as_ptr(), [2.0, bad].as_ptr())
        });
    }
    let two = [INPUT, LIMITED];
    for bad in [1.0 + f64::EPSILON, -1.5, f64::MAX] {
        refused(&slave, "between -1.0 and 1.0", || fmu.fmi2SetReal(c, two.as_ptr(), 2, [2.0, bad].as_ptr()));
    }
    for vr in [FIXED, OUTPUT, STATE, 8] {
        refused(&slave, "", || fmu.fmi2SetReal(c, [INPUT, vr].as_ptr(), 2, [2.0, 2.0].as_ptr()));
        refused(&slave, "", || fmu.fmi2SetInteger(c, [INPUT + INTEGER, vr + INTEGER].as_ptr(), 2, [2, 2].as_ptr()));
        refused(&slave, "", || fmu.fmi2SetBoolean(c, [INPUT, vr].as_ptr(), 2, [1, 1].as_ptr()));
        let texts = [c"a".as_ptr(), c"b".as_ptr()];
        refused(&slave, "", || fmu.fmi2SetString(c, [INPUT, vr].as_ptr(), 2, texts.as_ptr()));
    }
    for bad in [0, 37, -1, c_int::MAX, c_int::MIN] {
        refused(&slave, "is no item of Fault", || {
            fmu.fmi2SetInteger(c, [INPUT + INTEGER, FAULT].as_ptr(), 2, [2, bad].as_ptr())
        });
    }
    for bad in [2, -1, c_int::MIN] {
        refused(&slave, "is no fmi2Boolean", || fmu.fmi2SetBoolean(c, [INPUT, INPUT].as_ptr(), 2, [1, bad].as_ptr()));
    }
    let texts = [c"good".as_ptr(), c"\xc3\x28".as_ptr()];
    refused(&slave, "not UTF-8", || fmu.fmi2SetString(c, [INPUT, INPUT].as_ptr(), 2, texts.as_ptr()));
    let slave = instantiate(&fmu);
    for bad in [10, -10] {
        refused(&slave, "out of range, the least is -9, the greatest 9", || slave.set_integer(FIXED + INTEGER, bad));
    }
    // Reading is the same: nothing is written if one reference is bad.
    slave.initialize();
    let mut values = [7.0, 7.0];
    assert_eq!(fmu.fmi2GetReal(slave.component, [INPUT, 8].as_ptr(), 2, values.as_mut_ptr()), ERROR);
    assert_eq!(values, [7.0, 7.0]);
}

#[test]
fn extreme_values_that_are_legal_are_taken_as_they_are() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    for value in [f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, -0.0] {
        assert_eq!(slave.set(INPUT, value), OK);
        assert_eq!(slave.get(INPUT).to_bits(), value.to_bits());
    }
    for value in [c_int::MAX, c_int::MIN] {
        assert_eq!(slave.set_integer(INPUT + INTEGER, value), OK);
    }
    let long = std::ffi::CString::new("€ß%s#%n\n\u{1}".repeat(10_000)).unwrap();
    for text in [c"", c"%n%s##r1#", long.as_c_str()] {
        assert_eq!(fmu.fmi2SetString(slave.component, &INPUT, 1, &text.as_ptr()), OK);
        let mut back = null();
        assert_eq!(fmu.fmi2GetString(slave.component, &INPUT, 1, &mut back), OK);
        // SAFETY: just returned, and no call since.
        assert_eq!(unsafe { std::ffi::CStr::from_ptr(back) }, text);
    }
}

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

#[test]
fn handles_of_states_that_are_not_there_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let c = slave.component;
    let mut freed = slave.save();
    let copy = freed;
    assert_eq!(fmu.fmi2FreeFMUstate(c, &mut freed), OK);
    assert!(freed.is_null());
    assert_eq!(fmu.fmi2FreeFMUstate(c, &mut freed), OK, "null is ignored");
    let of_the_dead = {
        let other = stepping(&fmu);
        other.save()
    };
    let garbage = without_provenance_mut(0xdead_beef);
    let own = std::ptr::from_ref(&slave).cast_mut().cast();
    let says = "FMUstate is none that";
    for handle in [copy, of_the_dead, garbage, own, c] {
        let mut again = handle;
        refused(&slave, says, || fmu.fmi2FreeFMUstate(c, &mut again));
        assert_eq!(again, handle);
        refused(&slave, says, || fmu.fmi2SetFMUstate(c, handle));
        refused(&slave, says, || fmu.fmi2GetFMUstate(c, &mut again));
        refused(&slave, says, || fmu.fmi2SerializedFMUstateSize(c, handle, &mut 0));
        refused(&slave, says, || fmu.fmi2SerializeFMUstate(c, handle, [0; 9999].as_mut_ptr(), 9999));
    }
    refused(&slave, says, || fmu.fmi2SetFMUstate(c, null_mut()));
    refused(&slave, "FMUstate is a null pointer", || fmu.fmi2GetFMUstate(c, null_mut()));
    refused(&slave, "FMUstate is a null pointer", || fmu.fmi2FreeFMUstate(c, null_mut()));
    let blob = slave.blob();
    refused(&slave, "FMUstate is a null pointer", || {
        fmu.fmi2DeSerializeFMUstate(c, blob.as_ptr(), blob.len(), null_mut())
    });
    refused(&slave, "serializedState is a null pointer", || fmu.fmi2DeSerializeFMUstate(c, null(), 9, &mut null_mut()));
    refused(&slave, "this is not a saved FMU state", || fmu.fmi2DeSerializeFMUstate(c, null(), 0, &mut null_mut()));
    let state = slave.save();
    refused(&slave, "size is a null pointer", || fmu.fmi2SerializedFMUstateSize(c, state, null_mut()));
    refused(&slave, "serializedState is a null pointer", || fmu.fmi2SerializeFMUstate(c, state, null_mut(), 999));
    let mut short = vec![7; blob.len() - 1];
    refused(&slave, "bytes, size is", || fmu.fmi2SerializeFMUstate(c, state, short.as_mut_ptr(), short.len()));
    assert!(short.iter().all(|byte| *byte == 7), "nothing is written");
}

#[test]
fn states_of_another_model_in_the_same_library_are_refused() {
    let fmu = Fmu::load("two_models");
    let guids = fmu.guids();
    let (integrator, counter) = (fmu.instantiate(&guids[0]), fmu.instantiate(&guids[1]));
    let state = counter.save();
    refused(&integrator, "belongs to another model", || fmu.fmi2SetFMUstate(integrator.component, state));
    refused(&integrator, "belongs to another model", || {
        fmu.fmi2SerializedFMUstateSize(integrator.component, state, &mut 0)
    });
    refused(&integrator, "the state was saved by the FMU with GUID", || integrator.load(&counter.blob()));
    // The place of a state can be used again by any instance; it is that instance's then.
    let mut reused = state;
    assert_eq!(fmu.fmi2GetFMUstate(integrator.component, &mut reused), OK);
    assert_eq!(reused, state);
    assert_eq!(fmu.fmi2SetFMUstate(integrator.component, reused), OK);
    refused(&counter, "belongs to another model", || fmu.fmi2SetFMUstate(counter.component, reused));
}

#[test]
fn states_of_another_library_are_refused() {
    let (fmu, other) = (Fmu::load("misbehaving"), Fmu::load("two_models"));
    let (slave, stranger) = (stepping(&fmu), other.instantiate(&other.guids()[0]));
    // The same number of states on both sides: what is counted alike must not be mistaken for one's own.
    let (own, foreign) = (slave.save(), stranger.save());
    let mut again = foreign;
    let says = "FMUstate is none that";
    refused(&slave, says, || fmu.fmi2SetFMUstate(slave.component, foreign));
    refused(&slave, says, || fmu.fmi2FreeFMUstate(slave.component, &mut again));
    refused(&slave, says, || fmu.fmi2GetFMUstate(slave.component, &mut again));
    assert_eq!(fmu.fmi2SetFMUstate(slave.component, own), OK);
    assert_eq!(other.fmi2SetFMUstate(stranger.component, foreign), OK);
}

#[test]
fn a_state_is_shared_by_the_instances_of_a_model_while_its_owner_lives() {
    let fmu = Fmu::load("misbehaving");
    let (a, b) = (stepping(&fmu), instantiate(&fmu));
    let mut state = a.save();
    assert_eq!(fmu.fmi2SetFMUstate(b.component, state), OK);
    assert_eq!(a.blob(), b.blob());
    assert_eq!(fmu.fmi2FreeFMUstate(b.component, &mut state), OK);
}

/// What the logger of the tests below calls, and what it is answered.
struct Reentry {
    call: extern "C" fn(&Self),
    fmu: *const Fmu,
    component: AtomicPtr<c_void>,
    answer: AtomicI32,
}

unsafe extern "C" fn call_back(environment: *mut c_void, _: *const c_char, _: c_int, _: *const c_char) {
    // SAFETY: set below to something that outlives the instance.
    let reentry = unsafe { &*environment.cast::<Reentry>() };
    (reentry.call)(reentry);
}

extern "C" fn everything(reentry: &Reentry) {
    // SAFETY: lives as long as the test.
    let (fmu, c) = (unsafe { &*reentry.fmu }, reentry.component.load(Ordering::Relaxed));
    if c.is_null() {
        return; // Still in fmi2Instantiate.
    }
    let answers = calls_with_nothing(fmu, c);
    fmu.fmi2FreeInstance(c);
    reentry.answer.store(*answers.iter().min().unwrap(), Ordering::Relaxed);
}

/// Was: two mutable references to the instance, and its memory freed under a running call.
#[test]
fn a_logger_that_calls_back_into_the_instance_is_refused() {
    let fmu = Fmu::load("misbehaving");
    let reentry = Reentry {
        call: everything,
        fmu: &raw const fmu,
        component: AtomicPtr::new(null_mut()),
        answer: AtomicI32::new(-1),
    };
    let mut functions = callbacks(&Log::default());
    // SAFETY: see `common::callbacks`.
    functions.logger = Some(unsafe { std::mem::transmute::<*const (), common::Logger>(call_back as *const ()) });
    functions.environment = (&raw const reentry).cast_mut().cast();
    let guid = std::ffi::CString::new(fmu.guids()[0].clone()).unwrap();
    let component = fmu.fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &functions, 0, 1);
    let slave = Slave { fmu: &fmu, component, log: Log::default() };
    reentry.component.store(component, Ordering::Relaxed);
    let answer = || reentry.answer.swap(-1, Ordering::Relaxed);

    slave.initialize(); // Logs events.
    assert_eq!(answer(), ERROR);
    assert_eq!(slave.step(0.7, 0.1), ERROR); // Refused.
    assert_eq!(answer(), ERROR);
    assert_eq!(slave.set_integer(FAULT, Fault::StepWarns as i32), OK);
    assert_eq!(slave.step(0.0, 0.1), OK); // In the middle of a step.
    assert_eq!(answer(), ERROR);
    assert_eq!(slave.set_integer(FAULT, Fault::StepPanics as i32), OK);
    assert_eq!(slave.step(0.1, 0.1), ERROR);
    assert_eq!(answer(), ERROR);
    slave.start_again();
}

#[test]
fn an_instance_used_by_two_threads_at_once_refuses_one_of_them() {
    let fmu = Arc::new(Fmu::load("misbehaving"));
    let slave = stepping(&fmu);
    let component = slave.component.expose_provenance();
    let refusals: usize = std::thread::scope(|scope| {
        let run = || {
            let c = std::ptr::with_exposed_provenance_mut(component);
            (0..50_000).filter(|_| fmu.fmi2GetReal(c, &OUTPUT, 1, &mut 0.0) != OK).count()
        };
        let threads = [scope.spawn(run), scope.spawn(run)];
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    });
    println!("{refusals} of 100000 calls met another one");
    assert_eq!(slave.step(0.5, 0.5), OK);
}

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
