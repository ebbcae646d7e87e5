//! The calls of a host at every communication step allocate nothing.

use std::ffi::CString;
use std::hint::black_box;
use std::ptr::null;

use allocation_counter::measure;
use fmi2_export::ffi::types::Status;

#[path = "../../fmi2-export/tests/common/linked.rs"]
mod linked;
use linked::*;

/// Steps of 1/1024 s of an FMU with real parameters and, as its first integer, a profile.
fn steps(model: usize, inputs: u32, real: &[(u32, f64)], profile: i32) {
    let guid = CString::new(instruments_fmu::FMUS.models()[model].description().unwrap().guid).unwrap();
    // The inputs come first, then as many outputs.
    let n = inputs as usize;
    let (inputs, outputs): (Vec<u32>, Vec<u32>) = ((0..inputs).collect(), (inputs..2 * inputs).collect());
    let (mut values, orders, slopes, given) = (vec![0.0; n], vec![1; n], vec![0.5; n], vec![0.2; n]);
    // SAFETY: as a host does.
    unsafe {
        let c = fmi2Instantiate(c"between".as_ptr(), 1, guid.as_ptr(), null(), &NO_CALLBACKS, 0, 1);
        for (reference, value) in real {
            assert_eq!(fmi2SetReal(c, reference, 1, value), Status::Ok);
        }
        assert_eq!(fmi2SetInteger(c, &0, 1, &profile), Status::Ok);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        let mut step = |i: i32| {
            for status in [
                fmi2SetReal(c, inputs.as_ptr(), n, given.as_ptr()),
                fmi2SetRealInputDerivatives(c, inputs.as_ptr(), n, orders.as_ptr(), slopes.as_ptr()),
                fmi2DoStep(c, f64::from(i) / 1024.0, 1.0 / 1024.0, 1),
                fmi2GetReal(c, outputs.as_ptr(), n, values.as_mut_ptr()),
            ] {
                assert_eq!(status, Status::Ok);
            }
        };
        assert_ne!(measure(|| _ = black_box(vec![0])).count_total, 0, "nothing is counted");
        assert_eq!(measure(|| (0..1000).for_each(&mut step)).count_total, 0);
        fmi2FreeInstance(c);
    }
}

/// References of a description's real parameters whose names have these endings.
fn parameters(model: usize, wanted: &[(&str, f64)]) -> Vec<(u32, f64)> {
    let xml = &instruments_fmu::FMUS.models()[model].description().unwrap().xml;
    let attribute = |line: &str, key: &str| {
        let rest = line.split_once(&format!(" {key}=\""))?.1;
        Some(rest.split_once('"')?.0.to_owned())
    };
    let mut found = Vec::new();
    for line in xml.lines().filter(|line| line.contains("causality=\"parameter\"")) {
        let (Some(name), Some(reference)) = (attribute(line, "name"), attribute(line, "valueReference")) else {
            continue;
        };
        if let Some((_, value)) = wanted.iter().find(|(end, _)| name.ends_with(end)) {
            found.push((reference.parse().unwrap(), *value));
        }
    }
    assert!(found.len() >= wanted.len());
    found
}

const PARAMETERS: i32 = 1;

#[test]
fn steps_of_sensors_allocate_nothing() {
    let everything =
        [("sample_time", 1e-4), ("_noise", 0.1), ("_lsb", 0.01), ("_bandwidth", 300.0), ("_delay", 2.5e-3)];
    steps(0, 14, &parameters(0, &everything), PARAMETERS);
    for profile in 2..=4 {
        steps(0, 14, &[], profile);
    }
}

#[test]
fn steps_of_actuators_allocate_nothing() {
    let everything = [("sample_time", 1e-4), ("_delay", 2.5e-3), ("_rate_limit", 50.0), ("_bandwidth", 300.0)];
    steps(1, 3, &parameters(1, &everything), PARAMETERS);
    for profile in 2..=3 {
        steps(1, 3, &[], profile);
    }
}
