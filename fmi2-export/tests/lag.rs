//! The first-order lag through its C interface, against its closed-form solution.

mod common;

#[path = "../examples/first_order_lag.rs"]
#[allow(missing_docs)]
mod model;

use std::ptr::{null, null_mut};

use common::{DISCARD, ERROR, Fmu, OK};

// Value references: reals in the order of their declaration.
const U: u32 = 0;
const Y: u32 = 1;
const DER_Y: u32 = 2;
const K: u32 = 3;
const T: u32 = 4;
const Y_START: u32 = 5;

fn guid() -> String {
    model::FMUS.models()[0].description().unwrap().guid
}

#[test]
fn step_response_is_the_exponential() {
    let fmu = Fmu::load("first_order_lag");
    let slave = fmu.instantiate(&guid());
    assert_eq!(slave.set(K, 2.0), OK);
    assert_eq!(slave.set(T, 0.5), OK);
    slave.initialize();
    assert_eq!(slave.set(U, 3.0), OK);
    for i in 0..10 {
        assert_eq!(slave.step(f64::from(i) * 0.1, 0.1), OK);
    }
    // y(t) = k u (1 − e^{−t/T})
    assert!((slave.get(Y) - 6.0 * (1.0 - (-2.0_f64).exp())).abs() < 1e-14);
}

#[test]
fn a_ramp_is_followed_exactly_and_ends_at_its_end() {
    let fmu = Fmu::load("first_order_lag");
    let slave = fmu.instantiate(&guid());
    slave.initialize();
    let (order, slope) = (1, 2.0);
    assert_eq!(fmu.fmi2SetRealInputDerivatives(slave.component, &U, 1, &order, &slope), OK);
    assert_eq!(slave.step(0.0, 0.5), OK);
    // T ẏ + y = 2 t  ⇒  y = 2 (t − 1 + e^{−t})
    assert!((slave.get(Y) - 2.0 * (0.5 - 1.0 + (-0.5_f64).exp())).abs() < 1e-15);
    assert_eq!(slave.get(U), 1.0);
    // The slope was for one step.
    let before = slave.get(Y);
    assert_eq!(slave.step(0.5, 1e3), OK);
    assert!((slave.get(Y) - 1.0).abs() < 1e-12 && before < 1.0);
}

#[test]
fn output_derivative_follows_the_input_at_once_the_output_does_not() {
    let fmu = Fmu::load("first_order_lag");
    let slave = fmu.instantiate(&guid());
    slave.initialize();
    assert_eq!(slave.set(U, 4.0), OK);
    assert_eq!(slave.get(Y), 0.0);
    assert_eq!(slave.get(DER_Y), 4.0);
    let (order, mut rate) = (1, 0.0);
    assert_eq!(fmu.fmi2GetRealOutputDerivatives(slave.component, &Y, 1, &order, &mut rate), OK);
    assert_eq!(rate, 4.0);
    let order = 2;
    assert_eq!(fmu.fmi2GetRealOutputDerivatives(slave.component, &Y, 1, &order, &mut rate), OK);
    assert_eq!(rate, 0.0, "orders above the slave's are zero");
}

#[test]
fn refused_calls_say_why_and_change_nothing() {
    let fmu = Fmu::load("first_order_lag");
    let slave = fmu.instantiate(&guid());
    let before: [(i32, &str); 5] = [
        (slave.set(T, 0.0), "T cannot be 0.0: it must be between 1e-9 and 1000000000.0"),
        (slave.set(T, f64::NAN), "T cannot be NaN"),
        (slave.set(Y, 1.0), "it is computed by the model"),
        (slave.set(99, 1.0), "no variable of this type with value reference 99"),
        (slave.step(0.0, 0.1), "fmi2DoStep is not allowed before initialization"),
    ];
    let log: Vec<String> = slave.log.lock().unwrap().iter().skip(1).map(|(_, _, message)| message.clone()).collect();
    for ((status, part), message) in before.iter().zip(log) {
        assert_eq!(*status, ERROR);
        assert!(message.contains(part), "{message} does not say {part}");
    }
    slave.initialize();
    for (call, part) in [
        (Box::new(|| slave.step(0.0, 0.0)) as Box<dyn Fn() -> i32>, "communicationStepSize is 0.0"),
        (Box::new(|| slave.step(0.0, f64::INFINITY)), "communicationStepSize is inf"),
        (Box::new(|| slave.step(0.5, 0.1)), "the last step ended at 0.0"),
        (Box::new(|| slave.set(T, 2.0)), "T cannot be set while stepping: it is fixed"),
        (Box::new(|| slave.set(U, f64::NAN)), "u cannot be NaN"),
        (Box::new(|| fmu.fmi2SetReal(slave.component, null(), 1, &1.0)), "vr is a null pointer"),
        (Box::new(|| fmu.fmi2CancelStep(slave.component)), "no step is in progress"),
    ] {
        assert_eq!(call(), ERROR);
        assert!(slave.message().contains(part), "{} does not say {part}", slave.message());
        assert_eq!(slave.get(U), 0.0);
    }
    assert_eq!(slave.step(0.0, 0.1), OK, "the instance works on");
    let mut status = 0;
    assert_eq!(fmu.fmi2GetStatus(slave.component, 0, &mut status), DISCARD);
    let mut time = 0.0;
    assert_eq!(fmu.fmi2GetRealStatus(slave.component, 2, &mut time), OK);
    assert_eq!(time, 0.1);
}

#[test]
fn a_saved_state_continues_bit_for_bit_in_another_instance() {
    let fmu = Fmu::load("first_order_lag");
    let (a, b) = (fmu.instantiate(&guid()), fmu.instantiate(&guid()));
    assert_eq!(a.set(Y_START, 0.25), OK);
    a.initialize();
    assert_eq!(a.set(U, 1.0), OK);
    assert_eq!(a.step(0.0, 0.1), OK);
    let bytes = a.serialize(a.save());
    assert_eq!(a.step(0.1, 0.1), OK);

    let mut state = null_mut();
    assert_eq!(fmu.fmi2DeSerializeFMUstate(b.component, bytes.as_ptr(), bytes.len(), &mut state), OK);
    assert_eq!(fmu.fmi2SetFMUstate(b.component, state), OK);
    assert_eq!(fmu.fmi2FreeFMUstate(b.component, &mut state), OK);
    assert!(state.is_null());
    assert_eq!(b.step(0.1, 0.1), OK);
    assert_eq!(a.get(Y).to_bits(), b.get(Y).to_bits());

    let mut state = null_mut();
    assert_eq!(fmu.fmi2DeSerializeFMUstate(b.component, bytes.as_ptr(), bytes.len() - 1, &mut state), ERROR);
    assert!(b.message().contains("truncated"), "{}", b.message());
    assert!(state.is_null());
}

#[test]
fn a_wrong_guid_is_told_about_even_without_logging() {
    let fmu = Fmu::load("first_order_lag");
    let log = common::Log::default();
    let callbacks = common::callbacks(&log);
    let component = fmu.fmi2Instantiate(c"test".as_ptr(), 1, c"{wrong}".as_ptr(), null(), &raw const callbacks, 0, 0);
    assert!(component.is_null());
    assert!(log.lock().unwrap()[0].2.contains("modelDescription.xml and binary are not of the same build"));
}
