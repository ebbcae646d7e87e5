//! Loading and unloading libraries: what they export, that they go away again, and that no memory is left behind.
//!
//! A library that has registered a destructor for a thread-local variable is not unloaded while the thread lives, so that
//! it is gone from the process's memory map proves that there was none.
//!
//! `FMI2_CYCLES` limits the number of repetitions.

mod common;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::{Mutex, MutexGuard, PoisonError};

use common::misbehaving::{FAULT, Fault};
use common::real::{all_libraries, count, libraries, trajectory};
use common::{ERROR, Fmu, OK, example};
use object::Object as _;

/// The functions of the tables in FMI 2.0.4, sections 2.1, 3.2 and 4.2: all of `fmi2Functions.h`.
const FUNCTIONS: [&str; 44] = [
    "fmi2CancelStep",
    "fmi2CompletedIntegratorStep",
    "fmi2DeSerializeFMUstate",
    "fmi2DoStep",
    "fmi2EnterContinuousTimeMode",
    "fmi2EnterEventMode",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2FreeFMUstate",
    "fmi2FreeInstance",
    "fmi2GetBoolean",
    "fmi2GetBooleanStatus",
    "fmi2GetContinuousStates",
    "fmi2GetDerivatives",
    "fmi2GetDirectionalDerivative",
    "fmi2GetEventIndicators",
    "fmi2GetFMUstate",
    "fmi2GetInteger",
    "fmi2GetIntegerStatus",
    "fmi2GetNominalsOfContinuousStates",
    "fmi2GetReal",
    "fmi2GetRealOutputDerivatives",
    "fmi2GetRealStatus",
    "fmi2GetStatus",
    "fmi2GetString",
    "fmi2GetStringStatus",
    "fmi2GetTypesPlatform",
    "fmi2GetVersion",
    "fmi2Instantiate",
    "fmi2NewDiscreteStates",
    "fmi2Reset",
    "fmi2SerializeFMUstate",
    "fmi2SerializedFMUstateSize",
    "fmi2SetBoolean",
    "fmi2SetContinuousStates",
    "fmi2SetDebugLogging",
    "fmi2SetFMUstate",
    "fmi2SetInteger",
    "fmi2SetReal",
    "fmi2SetRealInputDerivatives",
    "fmi2SetString",
    "fmi2SetTime",
    "fmi2SetupExperiment",
    "fmi2Terminate",
];

/// Tests that load and unload must not do so at the same time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[test]
fn exactly_the_functions_of_the_standard_are_exported_and_no_threads_imported() {
    for path in all_libraries() {
        let bytes = std::fs::read(&path).unwrap();
        let file = object::File::parse(&*bytes).unwrap();
        let text = |name: &[u8]| String::from_utf8_lossy(name).trim_start_matches('_').to_owned();
        let exports: BTreeSet<String> = file.exports().unwrap().iter().map(|e| text(e.name())).collect();
        assert_eq!(exports, FUNCTIONS.map(str::to_owned).into(), "{}", path.display());
        let imports: BTreeSet<String> = file.imports().unwrap().iter().map(|i| text(i.name())).collect();
        for thread in ["pthread_create", "CreateThread"] {
            assert!(!imports.contains(thread), "{} can start threads", path.display());
        }
    }
}

/// Uses a library for all that could touch a thread-local variable of the standard library: instances, descriptions
/// (hash maps), failures, panics, saved states.
fn use_everything(path: &Path) {
    let fmu = Fmu::open(path);
    for guid in fmu.guids() {
        let slave = fmu.instantiate(&guid);
        slave.initialize();
        assert_eq!(slave.step(0.0, 1e-3), OK);
        assert_eq!(slave.step(7.0, 1e-3), ERROR);
        let blob = slave.blob();
        assert_eq!(slave.load(&blob), OK);
        assert_eq!(slave.load(&blob[1..]), ERROR);
        slave.save();
        if path.to_string_lossy().contains("misbehaving") {
            assert_eq!(slave.set_integer(FAULT, Fault::StepPanics as i32), OK);
            assert_eq!(slave.step(1e-3, 1e-3), ERROR);
        }
    }
}

#[cfg(target_os = "linux")]
fn is_loaded(path: &Path) -> bool {
    let name = path.file_name().unwrap().to_str().unwrap();
    std::fs::read_to_string("/proc/self/maps").unwrap().contains(name)
}

#[test]
#[cfg(target_os = "linux")]
fn a_library_is_unloaded_though_it_was_used_in_threads_that_live_on() {
    let _alone = alone();
    for path in all_libraries() {
        use_everything(&path);
        assert!(!is_loaded(&path), "{} stays loaded", path.display());
        let (used, proceed) = (std::sync::Barrier::new(2), std::sync::Barrier::new(2));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                use_everything(&path);
                used.wait();
                proceed.wait();
            });
            used.wait();
            let loaded = is_loaded(&path);
            proceed.wait();
            assert!(!loaded, "{} stays loaded while a thread lives", path.display());
        });
    }
}

/// Memory in use by this process.
#[cfg(target_os = "linux")]
fn resident_bytes() -> usize {
    let pages: usize = std::fs::read_to_string("/proc/self/statm").unwrap().split(' ').nth(1).unwrap().parse().unwrap();
    pages * 4096
}

/// Repeats, and tells by how much the memory in use grew from a tenth of the repetitions to the last.
#[cfg(target_os = "linux")]
fn growth(repetitions: u32, mut action: impl FnMut()) -> usize {
    for _ in 0..repetitions / 10 {
        action();
    }
    let before = resident_bytes();
    for _ in repetitions / 10..repetitions {
        action();
    }
    resident_bytes().saturating_sub(before)
}

/// So many repetitions, or as many as are allowed.
#[cfg(target_os = "linux")]
fn limited(repetitions: u32) -> u32 {
    std::env::var("FMI2_CYCLES")
        .ok()
        .and_then(|most| most.parse().ok())
        .map_or(repetitions, |most| repetitions.min(most))
}

/// The allocator may keep some pages; a leak of one pointer per cycle in 3000 would be missed, one of 130 bytes not.
const TOLERANCE: usize = 300_000;

/// Of instances. No block is shorter than 32 bytes, so one left behind by each of five thousand is found.
const TOLERANCE_OF_INSTANCES: usize = 120_000;

#[cfg(target_os = "linux")]
fn load_cycles(path: &Path, cycles: u32) {
    let (mut counts, cycles) = (None, limited(cycles));
    let growth = growth(cycles, || {
        let fmu = Fmu::open(path);
        let guid = &fmu.guids()[0];
        let counts = *counts.get_or_insert_with(|| count(&fmu, guid));
        let slave = fmu.instantiate(guid);
        trajectory(&slave, counts, 2, 0);
        slave.save();
        assert_eq!(slave.load(&slave.blob()), OK);
    });
    println!("{}: {growth} bytes more after {cycles} load cycles", path.display());
    assert!(growth < TOLERANCE, "{}: grew by {growth} bytes", path.display());
    assert!(!is_loaded(path));
}

#[test]
#[cfg(target_os = "linux")]
fn load_use_unload_3000_times_leaves_no_memory_behind() {
    let _alone = alone();
    load_cycles(&example("first_order_lag"), 3000);
    for path in libraries() {
        load_cycles(&path, 300);
    }
}

/// Whether another instance of the model lives meanwhile. What the instances of a model share is made for the first one, and
/// freed with the last.
#[cfg(target_os = "linux")]
#[derive(Clone, Copy, PartialEq)]
enum Beside {
    None,
    Another,
}

#[cfg(target_os = "linux")]
fn instance_cycles(path: &Path, cycles: u32, beside: Beside) {
    let (fmu, cycles) = (Fmu::open(path), limited(cycles));
    for guid in fmu.guids() {
        let _another = (beside == Beside::Another).then(|| fmu.instantiate(&guid));
        let guid = std::ffi::CString::new(guid).unwrap();
        let log = common::Log::default();
        let callbacks = common::callbacks(&log);
        let growth = growth(cycles, || {
            let c = fmu.fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &callbacks, 0, 0);
            let mut state = null_mut();
            assert_eq!(fmu.fmi2GetFMUstate(c, &mut state), OK);
            assert_eq!(fmu.fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
            fmu.fmi2FreeInstance(c);
        });
        println!("{} {guid:?}: {growth} bytes more after {cycles} instances", path.display());
        assert!(growth < TOLERANCE_OF_INSTANCES, "{}: grew by {growth} bytes", path.display());
    }
}

#[test]
#[cfg(target_os = "linux")]
fn instantiate_and_free_100000_times_leaves_no_memory_behind() {
    let _alone = alone();
    instance_cycles(&example("first_order_lag"), 100_000, Beside::None);
    instance_cycles(&example("two_models"), 100_000, Beside::None);
    for path in libraries() {
        instance_cycles(&path, 5_000, Beside::None);
    }
}

#[test]
#[ignore = "one minute; with FMU libraries built: cargo test --release -p fmi2-export --test loading -- --ignored --nocapture"]
#[cfg(target_os = "linux")]
fn the_same_with_real_fmus_in_full() {
    let _alone = alone();
    for path in libraries() {
        load_cycles(&path, 3000);
        // In the test above each is alone, and what is shared is made anew: that takes most of the time.
        instance_cycles(&path, 100_000, Beside::Another);
    }
}

#[test]
fn libraries_live_side_by_side() {
    let _alone = alone();
    let libraries: Vec<PathBuf> = all_libraries();
    let fmus: Vec<Fmu> = libraries.iter().map(|path| Fmu::open(path)).collect();
    let slaves: Vec<_> =
        fmus.iter().flat_map(|fmu| fmu.guids().into_iter().map(|guid| fmu.instantiate(&guid))).collect();
    for slave in &slaves {
        slave.initialize();
    }
    for i in 0..10 {
        for slave in &slaves {
            assert_eq!(slave.step(f64::from(i) * 1e-3, 1e-3), OK, "{:?}", slave.log);
        }
    }
}
