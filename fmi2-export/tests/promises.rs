//! What the description promises, the code keeps: derivatives in initialization mode, integers, names, sizes.

use std::cell::Cell;
use std::ffi::CString;
use std::ptr::null;

use fmi2_export::{Declare, Experiment, Failure, Info, Model, Step, Variables, describe};
use serde::{Deserialize, Serialize};

mod common;

use common::{ERROR, Fmu, Log, OK, callbacks};

/// ∂unknown/∂known in the current mode, and the status.
fn derivative(slave: &common::Slave<'_>, unknown: u32, known: u32) -> (i32, f64) {
    let mut value = f64::NAN;
    let status = slave.fmu.fmi2GetDirectionalDerivative(slave.component, &unknown, 1, &known, 1, &2.0, &mut value);
    (status, value / 2.0)
}

#[test]
fn outputs_are_derived_by_parameters_in_initialization_mode() {
    let fmu = Fmu::load("first_order_lag");
    let slave = fmu.instantiate(&fmu.guids()[0]);
    let (u, y, k, t, y_start) = (0, 1, 3, 4, 5);
    assert_eq!(slave.set(y_start, 0.7), OK);
    assert_eq!(fmu.fmi2SetupExperiment(slave.component, 0, 0.0, 0.0, 0, 0.0), OK);
    assert_eq!(fmu.fmi2EnterInitializationMode(slave.component), OK);
    let before = slave.blob();
    for (known, expected) in [(y_start, 1.0), (t, 0.0), (k, 0.0), (u, 0.0)] {
        let (status, value) = derivative(&slave, y, known);
        assert_eq!(status, OK, "{}", slave.message());
        // Rounding of values of about 1, divided by widths of about a hundredth.
        assert!((value - expected).abs() < 1e-12, "{known}: {value}");
    }
    assert_eq!(slave.blob(), before, "asking changes nothing");
    assert_eq!(derivative(&slave, y, y).0, ERROR);
    assert_eq!(fmu.fmi2ExitInitializationMode(slave.component), OK);
    assert_eq!(derivative(&slave, y, u), (OK, 0.0));
    assert_eq!(derivative(&slave, y, y_start).0, ERROR, "ModelStructure has no parameters at communication points");
}

#[test]
fn why_a_call_failed_is_told_with_logging_off_too() {
    let fmu = Fmu::load("misbehaving");
    let (log, guid) = (Log::default(), CString::new(fmu.guids()[0].clone()).unwrap());
    let c = fmu.fmi2Instantiate(c"quiet".as_ptr(), 1, guid.as_ptr(), null(), &callbacks(&log), 0, 0);
    assert_eq!(fmu.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
    assert!(log.lock().unwrap().is_empty(), "events and warnings wait to be asked for");
    assert_eq!(fmu.fmi2ExitInitializationMode(c), ERROR);
    let (status, category, message) = log.lock().unwrap().pop().unwrap();
    assert_eq!((status, category.as_str()), (ERROR, "logStatusError"));
    assert!(message.contains("fmi2ExitInitializationMode is not allowed"), "{message}");
    fmu.fmi2FreeInstance(c);
}

#[test]
fn strings_are_looked_up_before_there_is_memory_for_them() {
    let fmu = Fmu::load("two_models");
    let slave = fmu.instantiate(&fmu.guids()[1]);
    slave.initialize();
    // Forty million: their C strings alone would take 640 MB.
    let wrong = vec![7_u32; 40_000_000];
    let status = fmu.fmi2GetString(slave.component, wrong.as_ptr(), wrong.len(), std::ptr::dangling_mut());
    assert_eq!(status, ERROR);
    assert!(slave.message().contains("no variable of this type"), "{}", slave.message());
}

#[test]
fn a_state_is_serialised_into_as_many_bytes_as_it_has() {
    let fmu = Fmu::load("first_order_lag");
    let slave = fmu.instantiate(&fmu.guids()[0]);
    let state = slave.save();
    let bytes = slave.serialize(state);
    for size in [bytes.len() - 1, bytes.len() + 1, 2 * bytes.len()] {
        let mut buffer = vec![0_u8; size];
        assert_eq!(fmu.fmi2SerializeFMUstate(slave.component, state, buffer.as_mut_ptr(), size), ERROR);
        assert!(slave.message().contains("fmi2SerializedFMUstateSize"));
    }
    assert_eq!(slave.load(&bytes), OK);
}

thread_local! {
    /// The start value of [`Computed`].
    static COUNT: Cell<i64> = const { Cell::new(0) };
}

#[derive(Clone, Serialize, Deserialize)]
struct Computed {
    count: i64,
}

impl Default for Computed {
    fn default() -> Self {
        Self { count: COUNT.get() }
    }
}

impl Declare for Computed {
    const INFO: Info = Info { name: "Computed", description: "Starts at what no 32 bits hold", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        variables.parameter("count", |m| &mut m.count).description("An integer of 64 bits");
    }
}

impl Model for Computed {
    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

#[test]
fn integers_that_do_not_fit_are_named() {
    COUNT.set(3_000_000_000);
    let problems = describe::<Computed>().unwrap_err().problems;
    assert_eq!(problems, ["start value of variable count: 3000000000 does not fit into the 32 bits of FMI's integers"]);
    COUNT.set(i64::from(i32::MIN));
    assert!(describe::<Computed>().unwrap().xml.contains("start=\"-2147483648\""));
}

/// As many outputs as parameters, all of which they start from.
#[derive(Clone, Serialize, Deserialize)]
struct Large {
    parameters: Vec<f64>,
    outputs: Vec<f64>,
}

impl Default for Large {
    fn default() -> Self {
        Self { parameters: vec![0.0; 3000], outputs: vec![0.0; 3000] }
    }
}

impl Declare for Large {
    const INFO: Info = Info { name: "Large", description: "Three thousand of each", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|_| ());
        variables.parameter_array("p", |m| &mut m.parameters).description("Parameter {}");
        variables.output_array("y", outputs, |m| &mut m.outputs).description("Output {}");
    }
}

impl Model for Large {
    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

#[test]
fn a_description_grows_with_the_variables_not_with_their_square() {
    let bytes = describe::<Large>().unwrap().xml.len();
    // Some 200 for a variable, and 100 for what an output depends on.
    assert!(bytes < 6000 * 350, "{bytes} bytes");
}

#[derive(Clone, Default, Serialize, Deserialize)]
struct Clock {
    time: f64,
}

impl Declare for Clock {
    const INFO: Info = Info { name: "Clock", description: "Tells the time", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|_| ());
        variables.output("time", outputs, |m| &mut m.time).description("The time");
    }
}

impl Model for Clock {
    fn initialize(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        self.time = experiment.start_time;
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        self.time = step.time + step.size;
        Ok(())
    }
}

#[test]
fn no_variable_has_the_name_under_which_tools_record_the_time() {
    let problems = describe::<Clock>().unwrap_err().problems;
    assert_eq!(problems, ["no variable can be called time: tools record the time under this name"]);
}
