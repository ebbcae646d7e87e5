//! Time of one step through the C interface: the plant, each controller, and a coupled step of plant and controller with
//! every wired signal fetched and handed over.
//!
//! `cargo run --release -- package && cargo bench -p benchmarks`

mod common;

use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use dualarm::grasp::{CONTROLLERS, Controller, PLANT};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Coupling, Master};
use fmi2_import::{Fmu, Instance};

/// Step size in s.
const STEP: f64 = 1e-4;

fn open(file: &str) -> Option<Fmu> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../dist").join(file);
    match Fmu::open(&path) {
        Ok(fmu) => Some(fmu),
        Err(error) => {
            eprintln!("SKIPPED: {error}; run `cargo run --release -- package` first");
            None
        }
    }
}

fn initialized(fmus: &[Fmu], scenario: Option<&Controller>, coupling: Coupling) -> Master {
    let mut master = Master::new(fmus, coupling).expect("the FMUs are wired by name");
    for setting in scenario.into_iter().flat_map(Controller::settings) {
        master.apply(&setting).expect("presets are valid");
    }
    master.initialize(&TimeGrid::new(0.0, 1e6, STEP).expect("a valid grid")).expect("defaults are valid");
    master
}

/// One `fmi2DoStep` alone.
fn step_alone(criterion: &mut Criterion, name: &str, instance: &mut Instance) {
    let mut index = 0.0;
    criterion.bench_function(&format!("fmi2DoStep/{name}"), |bencher| {
        bencher.iter(|| {
            instance.do_step(index * STEP, STEP).expect("a step");
            index += 1.0;
        });
    });
}

fn coupled(criterion: &mut Criterion, name: &str, mut master: Master) {
    let mut index = 0.0;
    criterion.bench_function(&format!("coupled step/{name}"), |bencher| {
        bencher.iter(|| {
            master.step(index * STEP, STEP).expect("a step");
            index += 1.0;
        });
    });
}

/// The same algorithms in C: see `common::peer`.
fn peers(criterion: &mut Criterion) {
    let peers = match common::peer::Peers::compile(common::peer::has_wide_registers(), 8) {
        Ok(peers) => peers,
        Err(error) => return eprintln!("SKIPPED: no peer in C: {error}"),
    };
    let mut plant = peers.alone("plant", &common::dist()).expect("a plant");
    criterion.bench_function("peer in C/plant", |bencher| bencher.iter(|| plant.step()));
    let mut pair = common::peer::Pair::new(&peers, &common::dist()).expect("a pair");
    criterion.bench_function("peer in C/coupled", |bencher| bencher.iter(|| pair.step()));
}

/// A step with every wired signal handed over and fetched.
fn whole_steps(criterion: &mut Criterion) {
    for name in common::Case::NAMES.into_iter().chain(common::Case::DEFAULT) {
        match common::Case::new(name, &common::dist()) {
            Ok(mut case) => {
                _ = criterion.bench_function(&format!("step/{name}"), |bencher| bencher.iter(|| case.step()));
            }
            Err(error) => return eprintln!("SKIPPED: {error}"),
        }
    }
}

fn benches(criterion: &mut Criterion) {
    peers(criterion);
    whole_steps(criterion);
    let Some(plant) = open(PLANT) else { return };
    let mut alone = initialized(std::slice::from_ref(&plant), None, Coupling::GaussSeidel);
    step_alone(criterion, "DualArmPlant", alone.instance(0));
    for scenario in CONTROLLERS {
        let Some(controller) = open(scenario.fmu) else { return };
        let mut alone = initialized(std::slice::from_ref(&controller), Some(scenario), Coupling::GaussSeidel);
        step_alone(criterion, scenario.key, alone.instance(0));
        for (coupling, suffix) in [(Coupling::GaussSeidel, "gauss-seidel"), (Coupling::Jacobi, "jacobi")] {
            let master = initialized(&[plant.clone(), controller.clone()], Some(scenario), coupling);
            coupled(criterion, &format!("{}, {suffix}", scenario.key), master);
        }
    }
}

criterion_group!(group, benches);
criterion_main!(group);
