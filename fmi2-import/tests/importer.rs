//! The importer against small FMUs compiled from C.

#[path = "../examples/step.rs"]
#[allow(dead_code)] // its main
mod step;
mod support;

use std::fs;
use std::path::PathBuf;

use fmi2_import::{CallError, Experiment, Fmu, Instance, Status, Value};
use support::{package, package_as};

fn start(fmu: &Fmu) -> Instance {
    let mut instance = fmu.instantiate("it").unwrap();
    instance.setup_experiment(Experiment { start: 0.0, stop: Some(1.0), tolerance: None }).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode().unwrap();
    instance
}

#[test]
fn every_kind_of_value_goes_in_and_out() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = package(folder.path(), "Lag") else { return };
    let fmu = Fmu::open(path).unwrap();
    let mut lag = fmu.instantiate("lag").unwrap();

    lag.set_real(&[0, 1], &[2.0, 0.5]).unwrap();
    let mut reals = [0.0; 3];
    lag.get_real(&[1, 0, 4], &mut reals).unwrap();
    assert_eq!(reals.map(f64::to_bits), [0.5, 2.0, 1e30].map(f64::to_bits));

    lag.set_integer(&[0], &[1]).unwrap();
    let mut integers = [0];
    lag.get_integer(&[0], &mut integers).unwrap();
    assert_eq!(integers, [1]);

    // More booleans than one block holds.
    let references: Vec<u32> = (0..20).collect();
    let values: Vec<bool> = (0..20).map(|index| index % 3 == 0).collect();
    lag.set_boolean(&references, &values).unwrap();
    let mut read = [false; 20];
    lag.get_boolean(&references, &mut read).unwrap();
    assert!(!read[1], "the slave computes number 1 as the opposite of number 0");
    assert_eq!(read[2..], values[2..]);

    lag.set_string(0, "größer").unwrap();
    assert_eq!(lag.get_string(0).unwrap(), "größer");
    assert!(matches!(lag.set_string(0, "a\0b"), Err(CallError::ZeroByte { .. })));
    assert_eq!(lag.get_real(&[], &mut []).unwrap(), Status::Ok);
}

#[test]
fn any_variable_is_read_and_set() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = package(folder.path(), "Lag") else { return };
    let fmu = Fmu::open(path).unwrap();
    let variable = |name: &str| fmu.description().variable(name).unwrap();
    let mut lag = fmu.instantiate("lag").unwrap();
    for (name, given, expected) in [
        ("T", Value::Integer(2), Value::Real(2.0)),
        ("T", Value::from("0.5"), Value::Real(0.5)),
        ("trouble", Value::from("discard"), Value::Integer(2)),
        ("trouble", Value::Real(4.0), Value::Integer(4)),
        ("u_on", Value::from("1"), Value::Boolean(true)),
        ("u_on", Value::Boolean(false), Value::Boolean(false)),
        ("label", Value::Integer(3), Value::from("3")),
    ] {
        lag.set(variable(name), &given).unwrap();
        assert_eq!(lag.get(variable(name)).unwrap(), expected, "{name}");
    }
    for (name, given, expected) in [
        ("trouble_at", Value::from("soon"), "lag: trouble_at needs a number in s, not \"soon\""),
        ("trouble", Value::Integer(9), "lag: trouble needs one of warning, discard, error, fatal, not \"9\""),
        ("u_on", Value::Real(0.5), "lag: u_on needs true or false, not \"0.5\""),
    ] {
        assert_eq!(lag.set(variable(name), &given).unwrap_err().to_string(), expected);
    }
    assert_eq!(variable("trouble").with_name(Value::Integer(2)), Value::from("discard"));
    assert_eq!(variable("T").start(), Some(Value::Real(1.0)));
}

#[test]
fn the_example_runs() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = package(folder.path(), "Lag") else { return };
    let outputs = step::run(&path).unwrap();
    let steps = outputs.iter().find(|(name, _)| name == "steps").unwrap();
    assert_eq!(steps.1, Value::Integer(20), "2 s in steps of 0.1 s, as the description suggests");
}

#[test]
fn resources_are_unpacked_and_vanish_with_the_last_user() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = package(folder.path(), "Lag") else { return };
    let fmu = Fmu::open(path).unwrap();
    let mut lag = fmu.instantiate("lag").unwrap();
    drop(fmu);
    let uri = lag.get_string(1).unwrap();
    let resources = PathBuf::from(uri.strip_prefix("file://").unwrap());
    assert_eq!(fs::read_to_string(resources.join("table.txt")).unwrap(), "1 2 3");
    assert!(!resources.join("../documentation").exists(), "only what is needed is unpacked");
    drop(lag);
    assert!(!resources.parent().unwrap().exists());
}

#[test]
fn states_are_saved_restored_and_serialised() {
    let folder = tempfile::tempdir().unwrap();
    let able = |text: String| {
        let more = r#"canSerializeFMUstate="true" providesDirectionalDerivative="true" canGetAndSetFMUstate="true""#;
        text.replace(r#"canGetAndSetFMUstate="true""#, more)
    };
    let Some(path) = package_as(folder.path(), "Lag", able) else { return };
    let fmu = Fmu::open(path).unwrap();
    let mut lag = start(&fmu);
    let mut other = start(&fmu);
    let value = |lag: &mut Instance| {
        let mut value = [0.0];
        lag.get_real(&[2], &mut value).unwrap();
        value[0]
    };

    lag.set_real(&[0], &[1.0]).unwrap();
    lag.do_step(0.0, 0.1).unwrap();
    let (saved, before) = (lag.save_state().unwrap(), value(&mut lag));
    lag.do_step(0.1, 0.1).unwrap();
    assert!(value(&mut lag) > before);
    lag.restore_state(&saved).unwrap();
    assert_eq!(value(&mut lag).to_bits(), before.to_bits());

    let bytes = lag.serialize_state(&saved).unwrap();
    assert!(matches!(other.restore_state(&saved), Err(CallError::ForeignState { .. })));
    lag.free_state(saved).unwrap();
    let copy = other.deserialize_state(&bytes).unwrap();
    other.restore_state(&copy).unwrap();
    assert_eq!(value(&mut other).to_bits(), before.to_bits());
    other.free_state(copy).unwrap();

    let mut derivative = [0.0];
    lag.directional_derivative(&[2], &[0], &[2.0], &mut derivative).unwrap();
    assert!((derivative[0] + 2.0).abs() < 1e-15);
    assert!(matches!(lag.output_derivatives(&[2], &[1], &mut derivative), Err(CallError::Unsupported { .. })));
}

#[test]
fn refusals_carry_the_slaves_own_formatted_words() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = package(folder.path(), "Lag") else { return };
    let fmu = Fmu::open(path).unwrap();
    let mut lag = fmu.instantiate("lag").unwrap();
    let message = lag.set_real(&[1], &[-0.5]).unwrap_err().to_string();
    assert_eq!(message, "lag: fmi2SetReal returned fmi2Error: T = -0.5 must be positive, # 100 %");

    let mut warns = start(&fmu);
    warns.set_real(&[4], &[0.0]).unwrap();
    warns.set_integer(&[0], &[1]).unwrap();
    assert_eq!(warns.do_step(0.0, 0.1).unwrap(), Status::Warning);
    let log = warns.take_log();
    assert_eq!((log[0].status, log[0].category.as_str()), (Status::Warning, "logStatusError"));
    assert_eq!(log[0].text.len(), "trouble at t = 0".len() + 2999, "long messages are not cut");
    assert!(warns.take_log().is_empty());

    // After a fatal error nothing may be called, not even the release.
    let mut dies = start(&fmu);
    dies.set_real(&[4], &[0.0]).unwrap();
    dies.set_integer(&[0], &[4]).unwrap();
    assert_eq!(dies.do_step(0.0, 0.1).unwrap_err().status(), Some(Status::Fatal));
}

#[test]
fn a_wrong_guid_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = package_as(folder.path(), "Lag", |text| text.replace("{fixture}", "{other}")) else { return };
    let message = Fmu::open(path).unwrap().instantiate("lag").unwrap_err().to_string();
    assert_eq!(message, "lag: the FMU refuses to be instantiated: GUID {other} is not {fixture}");
}

/// The library has the functions, but its description does not say that they may be called.
#[test]
fn what_an_fmu_does_not_say_it_can_is_not_asked_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = package_as(folder.path(), "Lag", |text| text.replace(r#" canGetAndSetFMUstate="true""#, ""))
    else {
        return;
    };
    let mut lag = start(&Fmu::open(path).unwrap());
    let message = lag.save_state().unwrap_err().to_string();
    assert_eq!(message, "it: the FMU does not offer fmi2GetFMUstate");
    assert!(lag.directional_derivative(&[2], &[0], &[2.0], &mut [0.0]).is_err());
    assert!(lag.set_input_derivatives(&[0], &[1], &[0.0]).is_err());
}

/// Six thousand variables of one enumeration of six thousand items: the items are there once.
#[test]
fn large_enumerations_are_shared() {
    let (items, variables) = (0..6000).map(|index| {
        (
            format!("<Item name=\"i{index}\" value=\"{index}\"/>"),
            format!("<ScalarVariable name=\"v{index}\" valueReference=\"{index}\"><Enumeration declaredType=\"Large\" start=\"1\"/></ScalarVariable>"),
        )
    }).collect::<(Vec<_>, Vec<_>)>();
    let xml = format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"m\" guid=\"g\"><TypeDefinitions><SimpleType name=\"Large\"><Enumeration>{}</Enumeration></SimpleType></TypeDefinitions><ModelVariables>{}</ModelVariables></fmiModelDescription>",
        items.concat(),
        variables.concat()
    );
    let model = fmi2_import::ModelDescription::parse(&xml).unwrap();
    let (first, last) = (model.variables[0].items(), model.variables[5999].items());
    assert!(std::ptr::eq(first, last) && first.len() == 6000);
}
