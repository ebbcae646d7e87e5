//! Arguments that no call can use: no component, null pointers, arrays that are none.

use std::ffi::c_char;
use std::ptr::{null, null_mut, without_provenance, without_provenance_mut};

use crate::common::misbehaving::{FAULT, Fault, INPUT, OUTPUT};
use crate::common::{Callbacks, ERROR, Fmu, Log, OK, Slave, callbacks};
use crate::{calls_for_no_variable, calls_with_nothing, refused, stepping};

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
    assert_eq!(calls_for_no_variable(&fmu, c), [OK; 11]);
    assert_eq!(fmu.fmi2FreeFMUstate(c, &mut null_mut()), OK);
    assert_eq!(slave.blob(), before);
}
