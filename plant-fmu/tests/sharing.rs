//! What instances of equal parameters share. In a file of its own, because all instances in a process do.

use std::ffi::CString;
use std::ptr::{null, null_mut};

use allocation_counter::measure;
use fmi2_export::ffi::types::Status;

#[path = "../../fmi2-export/tests/common/linked.rs"]
mod linked;
use linked::*;

/// A plant shares its matrices with one of equal parameters, and keeps them when it is reset.
#[test]
fn matrices_are_shared_and_survive_a_reset() {
    let guid = CString::new(plant_fmu::FMUS.models()[0].description().unwrap().guid).unwrap();
    let outputs: Vec<u32> = (6..60).collect();
    // SAFETY: as a host does.
    unsafe {
        let instantiate = || fmi2Instantiate(c"plant".as_ptr(), 1, guid.as_ptr(), null(), &NO_CALLBACKS, 0, 1);
        let run = |c| {
            assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
            let mut values = vec![0.0; outputs.len()];
            for i in 0..5 {
                assert_eq!(fmi2SetReal(c, [0, 2].as_ptr(), 2, [0.2, 0.05].as_ptr()), Status::Ok);
                assert_eq!(fmi2DoStep(c, f64::from(i) / 1024.0, 1.0 / 1024.0, 1), Status::Ok);
            }
            assert_eq!(fmi2GetReal(c, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), Status::Ok);
            values.iter().map(|value| value.to_bits()).collect::<Vec<u64>>()
        };
        let (mut first, mut expected) = (null_mut(), Vec::new());
        let alone = measure(|| {
            first = instantiate();
            expected = run(first);
        });
        println!("an instance alone: {} bytes", alone.bytes_current);
        assert!(alone.bytes_current > 64 << 10, "there is nothing to share: {} bytes", alone.bytes_current);
        let mut second = null_mut();
        let mut found = Vec::new();
        let used = measure(|| {
            second = instantiate();
            found = run(second);
        });
        assert_eq!(found, expected);
        println!("another instance: {} bytes", used.bytes_current);
        assert!(used.bytes_current < 12 << 10, "{} bytes", used.bytes_current);
        fmi2FreeInstance(first);
        let used = measure(|| {
            assert_eq!(fmi2Reset(second), Status::Ok);
            found = run(second);
        });
        assert_eq!(found, expected);
        println!("a reset: {} bytes in all", used.bytes_total);
        assert!(used.bytes_total < 32 << 10, "{} bytes", used.bytes_total);
        fmi2FreeInstance(second);
    }
}
