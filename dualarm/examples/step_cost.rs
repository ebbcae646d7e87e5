//! What a communication step costs.
//!
//! ```text
//! step_cost count CASE [FOLDER]   steps a case; run under callgrind with --toggle-collect='step_cost_counted*'
//! step_cost time [FOLDER]         wall times of all cases and of the floors, in one run
//! step_cost sizes [FOLDER]        the plant's step against its order and against the number of instances, as CSV
//! ```
//!
//! FOLDER holds the `.fmu` files (default: `dist`). `cargo xtask counts` runs the first form for every case and compares
//! with the history in `docs/performance/instructions.csv`.

#![allow(missing_docs)]

#[path = "../benches/common/mod.rs"]
mod common;

use std::hint::black_box;
use std::iter::empty;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use common::{Case, ModalStep, RUN, Result, Slave, open, transcendentals};
use dualarm::grasp::{NABFC, PLANT};

/// Steps before counting begins: the caches of step sizes are filled, the motion is under way.
const WARM_UP: usize = 100;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let folder = |index: usize| arguments.get(index).map_or_else(common::dist, PathBuf::from);
    let result = match arguments.as_slice() {
        ["count", case, ..] => Case::new(case, &folder(2)).map(|mut case| {
            for _ in 0..WARM_UP {
                case.step();
            }
            step_cost_counted(&mut case);
            println!("{}", RUN - WARM_UP);
        }),
        ["time", ..] => time(&folder(1)),
        ["sizes", ..] => sizes(&folder(1)),
        _ => Err("usage: step_cost count CASE [FOLDER] | step_cost time|sizes [FOLDER]".into()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What callgrind counts: everything that happens in here.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn step_cost_counted(case: &mut Case) {
    for _ in WARM_UP..RUN {
        case.step();
    }
}

/// Nanoseconds of one of `repetitions` in the best of many batches: what the machine does when it does nothing else.
fn nanoseconds(repetitions: u32, mut task: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..60 {
        let begin = Instant::now();
        for _ in 0..repetitions {
            task();
        }
        best = best.min(begin.elapsed().as_secs_f64() * 1e9 / f64::from(repetitions));
    }
    best
}

fn time(folder: &std::path::Path) -> Result<()> {
    println!("{:<44}{:>10}", "", "ns");
    let mut modal = ModalStep::new(8);
    let plant_floor = nanoseconds(2000, || _ = black_box(modal.make(black_box([0.1, -0.1, 0.05]))));
    let controller_floor = nanoseconds(2000, || _ = black_box(transcendentals(black_box(-1e-3))));
    let floor = |name: &str| match name {
        "plant" => Some(plant_floor),
        "nabfc" => Some(controller_floor),
        "coupled" | "master" => Some(plant_floor + controller_floor),
        _ => None,
    };
    println!("{:<44}{plant_floor:>10.0}", "floor plant: 16 blocks, 14 readings");
    println!("{:<44}{controller_floor:>10.0}", "floor nabfc: 38 exp, 3 tanh");
    for name in Case::NAMES.into_iter().chain([Case::DEFAULT]) {
        let mut case = Case::new(name, folder)?;
        let cost = nanoseconds(u32::try_from(RUN)?, || case.step());
        match floor(name) {
            Some(floor) => println!("{:<44}{cost:>10.0}   {:.2} x floor", format!("step, {name}"), cost / floor),
            None => println!("{:<44}{cost:>10.0}", format!("step, {name}")),
        }
    }
    for (name, mut slave) in [("plant", Slave::plant(folder, None)?), ("nabfc", Slave::controller(folder, &NABFC)?)] {
        slave.do_step();
        println!("{:<44}{:>10.0}", format!("fmi2DoStep alone, {name}"), nanoseconds(2000, || slave.do_step()));
        let instance = &mut slave.instance;
        let save = nanoseconds(1000, || {
            let saved = instance.save_state().expect("a state");
            instance.free_state(saved).expect("its own state");
        });
        println!("{:<44}{save:>10.0}", format!("save and free a state, {name}"));
        let saved = instance.save_state()?;
        let restore = nanoseconds(1000, || _ = instance.restore_state(&saved).expect("its own state"));
        println!("{:<44}{restore:>10.0}", format!("restore a state, {name}"));
        instance.free_state(saved)?;
    }
    let mut slave = Slave::plant(folder, None)?;
    let (mut time, mut long) = (0.0, false);
    let alternating = nanoseconds(2000, || {
        let size = if long { 2.0 * common::STEP } else { common::STEP };
        slave.instance.do_step(time, size).expect("a step");
        (time, long) = (time + size, !long);
    });
    println!("{:<44}{alternating:>10.0}", "fmi2DoStep alone, plant, two sizes in turn");
    for (name, file, inputs, outputs) in [
        ("plant", PLANT, &common::COMMANDS[..], &common::MEASURED[..]),
        ("nabfc", NABFC.fmu, &common::MEASURED[..], &common::COMMANDS[..]),
    ] {
        let fmu = open(folder, file)?;
        let start =
            nanoseconds(5, || _ = black_box(Slave::new(&fmu, inputs, outputs, None, empty()).expect("defaults")));
        println!("{:<44}{start:>10.0}", format!("instantiate, initialise, free, {name}"));
    }
    Ok(())
}

/// Plants measured together: of an order, so many in one process.
const SIZES: [(i32, usize); 12] =
    [(4, 1), (6, 1), (8, 1), (10, 1), (12, 1), (16, 1), (20, 1), (24, 1), (8, 10), (8, 100), (8, 1000), (8, 10_000)];

/// How often each of [`SIZES`] is measured, in turns: what disturbs one round may leave another alone.
const ROUNDS: usize = 3;

/// What the plant costs: by order for one instance, by number of instances at order 8. The lowest of the rounds, but for
/// the memory, which only the first round takes from the system.
fn sizes(folder: &std::path::Path) -> Result<()> {
    let mut lowest = Vec::new();
    for round in 0..ROUNDS {
        for (index, (order, count)) in SIZES.into_iter().enumerate() {
            let found = cost(folder, order, count)?;
            match lowest.get_mut(index) {
                None => lowest.push(found),
                Some(row) => {
                    let Cost { step, floor, new_size, start, .. } = row;
                    for (low, now) in [step, floor, new_size, start].into_iter().zip(found.times()) {
                        *low = low.min(now);
                    }
                }
            }
        }
        eprintln!("round {} of {ROUNDS} done", round + 1);
    }
    println!("order,instances,step_ns,floor_ns,new_size_us,start_us,resident_kib");
    for ((order, count), Cost { step, floor, new_size, start, memory }) in SIZES.into_iter().zip(lowest) {
        println!("{order},{count},{step:.0},{floor:.0},{new_size:.0},{start:.0},{memory:.0}");
    }
    Ok(())
}

/// Cost of one plant among some.
struct Cost {
    /// A step \[ns\].
    step: f64,
    /// The bare arithmetic \[ns\].
    floor: f64,
    /// The first step \[µs\].
    new_size: f64,
    /// Instantiation and initialisation \[µs\].
    start: f64,
    /// Resident \[KiB\].
    memory: f64,
}

impl Cost {
    fn times(&self) -> [f64; 4] {
        [self.step, self.floor, self.new_size, self.start]
    }
}

fn cost(folder: &std::path::Path, order: i32, count: usize) -> Result<Cost> {
    let resident = resident_kib();
    let fmu = open(folder, PLANT)?;
    let begin = Instant::now();
    let mut plants = Vec::new();
    for _ in 0..count {
        plants.push(Slave::new(&fmu, &common::COMMANDS, &common::MEASURED, Some(order), empty())?);
    }
    let start = begin.elapsed().as_secs_f64() * 1e6 / count as f64;
    // The first step finds the modes, and what the size does to them.
    let begin = Instant::now();
    plants.iter_mut().for_each(Slave::do_step);
    let new_size = begin.elapsed().as_secs_f64() * 1e6 / count as f64;
    let memory = (resident_kib() - resident) / count as f64;
    let mut outputs = [0.0; 12];
    let rounds = u32::try_from(20_000 / count.min(20_000)).unwrap_or(1).max(1);
    let step = nanoseconds(rounds, || {
        for plant in &mut plants {
            plant.step(&[0.01, -0.01, 0.1], &mut outputs);
        }
    }) / count as f64;
    let mut modal = ModalStep::new(usize::try_from(order).unwrap_or_default());
    let floor = nanoseconds(2000, || _ = black_box(modal.make(black_box([0.1, -0.1, 0.05]))));
    Ok(Cost { step, floor, new_size, start, memory })
}

/// Memory of this process that is in use, where the system tells.
fn resident_kib() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok()).map_or(f64::NAN, |pages| pages * 4.0)
}
