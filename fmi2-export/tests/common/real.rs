//! FMU libraries beyond the examples, known by nothing but their C functions.
#![allow(dead_code)] // Each test binary uses a part.

use std::path::PathBuf;
use std::ptr::null;

use super::{Fmu, OK, Slave, example};

/// The examples.
pub const EXAMPLES: [&str; 3] = ["first_order_lag", "two_models", "misbehaving"];

/// Libraries of real FMUs: those that the environment variable `FMU_LIBRARIES` lists (separated as in `PATH`), or else
/// those that `cargo build --profile fmu` has left in the target directory. Says so if there are none.
pub fn libraries() -> Vec<PathBuf> {
    let found: Vec<PathBuf> = if let Some(list) = std::env::var_os("FMU_LIBRARIES") {
        std::env::split_paths(&list).filter(|path| path.is_file()).collect()
    } else {
        let exe = std::env::current_exe().unwrap();
        let folder = exe.ancestors().nth(3).unwrap().join("fmu");
        let files = std::fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
        let mut files: Vec<PathBuf> =
            files.filter(|file| file.extension().is_some_and(|e| e == std::env::consts::DLL_EXTENSION)).collect();
        files.sort();
        files
    };
    if found.is_empty() {
        println!(
            "not checked with real FMUs: there are none. Build them with `cargo build --profile fmu -p CRATE`, or list \
             their libraries in FMU_LIBRARIES."
        );
    }
    found
}

/// The examples' libraries and the real ones.
pub fn all_libraries() -> Vec<PathBuf> {
    EXAMPLES.iter().map(|name| example(name)).chain(libraries()).collect()
}

/// How many variables of each type a model has.
#[derive(Clone, Copy, Debug)]
pub struct Counts {
    pub reals: u32,
    pub integers: u32,
    pub booleans: u32,
    pub strings: u32,
}

/// Counts a model's variables by trying value references.
pub fn count(fmu: &Fmu, guid: &str) -> Counts {
    let slave = fmu.instantiate(guid);
    slave.initialize();
    let c = slave.component;
    let first_bad = |get: &dyn Fn(u32) -> i32| (0..1_000_000).find(|vr| get(*vr) != OK).unwrap();
    Counts {
        reals: first_bad(&|vr| fmu.fmi2GetReal(c, &vr, 1, &mut 0.0)),
        integers: first_bad(&|vr| fmu.fmi2GetInteger(c, &vr, 1, &mut 0)),
        booleans: first_bad(&|vr| fmu.fmi2GetBoolean(c, &vr, 1, &mut 0)),
        strings: first_bad(&|vr| fmu.fmi2GetString(c, &vr, 1, &mut null())),
    }
}

/// All real variables.
pub fn reals(slave: &Slave, counts: Counts) -> Vec<f64> {
    let references: Vec<u32> = (0..counts.reals).collect();
    let mut values = vec![f64::NAN; references.len()];
    let (vr, n) = (references.as_ptr(), references.len());
    assert_eq!(slave.fmu.fmi2GetReal(slave.component, vr, n, values.as_mut_ptr()), OK, "{:?}", slave.log);
    values
}

/// Sets every real variable that can be set while stepping: inputs, mostly.
pub fn set_reals(slave: &Slave, counts: Counts, value: impl Fn(u32) -> f64) {
    for vr in 0..counts.reals {
        slave.set(vr, value(vr));
    }
}

/// A short simulation that sets inputs: the bits of all real variables after each step.
pub fn trajectory(slave: &Slave, counts: Counts, steps: u32, seed: u32) -> Vec<u64> {
    slave.initialize();
    let (h, mut time, mut bits) = (1e-3, 0.0, Vec::new());
    for i in 0..steps {
        set_reals(slave, counts, |vr| 1e-3 * f64::from((vr * 7 + i * 3 + seed) % 11));
        let status = slave.step(time, h);
        assert!(status == OK, "{:?}", slave.log);
        time += h;
        bits.extend(reals(slave, counts).iter().map(|value| value.to_bits()));
    }
    bits
}
