//! What a communication step costs.
//!
//! ```text
//! step_cost count CASE [FOLDER]   steps a case; run under callgrind with --toggle-collect='step_cost_counted*'
//! step_cost same [FOLDER]         whether the same in C gives the same commands, if there is a C compiler
//! step_cost time [FOLDER]         wall times of all cases and of the same in C, in one run
//! step_cost sizes [FOLDER]        the plant's step against its order, and that of pairs against their number, as CSV
//! ```
//!
//! FOLDER holds the `.fmu` files (default: `dist`). `cargo xtask counts` runs the first form for every case and compares
//! with the history in `docs/performance/instructions.csv`.

#![allow(missing_docs)]

#[path = "../benches/common/mod.rs"]
mod common;

use std::hint::black_box;
use std::iter::empty;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use common::peer::{Pair as PeerPair, Peers, has_wide_registers};
use common::replay::Steps;
use common::{Case, Pair, RUN, Result, Slave, open};
use dualarm::grasp::{Controller, NABFC, NABFC_R, PLANT};

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
        ["same", ..] => same(&folder(1)),
        ["time", ..] => time(&folder(1)),
        ["sizes", ..] => sizes(&folder(1)),
        _ => Err("usage: step_cost count CASE [FOLDER] | step_cost same|time|sizes [FOLDER]".into()),
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

/// What the same costs in C.
struct InC {
    plant: f64,
    paper: f64,
    coupled: f64,
}

impl InC {
    fn measure(folder: &Path, wide: bool) -> Result<Self> {
        let peers = Peers::compile(wide, 8)?;
        let (mut plant, mut paper) = (peers.alone("plant", folder)?, peers.alone("nabfc", folder)?);
        let mut pair = PeerPair::new(&peers, folder)?;
        let steps = u32::try_from(RUN)?;
        Ok(Self {
            plant: nanoseconds(steps, || plant.step()),
            paper: nanoseconds(steps, || paper.step()),
            coupled: nanoseconds(steps, || pair.step()),
        })
    }

    fn of(&self, name: &str) -> Option<f64> {
        match name {
            "plant" => Some(self.plant),
            "nabfc" => Some(self.paper),
            "coupled" | "get_first" | "master" => Some(self.coupled),
            _ => None,
        }
    }
}

/// Commands may differ by this share of the largest: the sums have another order, and a squeeze forgets rounding.
const SAME: f64 = 1e-12;

/// Whether the same in C gives the commands that ours do.
fn same(folder: &Path) -> Result<()> {
    for wide in [false, true] {
        if wide && !has_wide_registers() {
            continue;
        }
        let peers = match Peers::compile(wide, 8) {
            Ok(peers) => peers,
            Err(error) => {
                println!("SKIPPED: the same in C: {error}");
                return Ok(());
            }
        };
        let difference = PeerPair::new(&peers, folder)?.difference();
        println!("commands in C differ from ours by {difference:.0e} of the largest");
        if difference.is_nan() || difference > SAME {
            return Err("benches/peer/peer.c is no longer the law that the FMU has".into());
        }
    }
    Ok(())
}

fn time(folder: &Path) -> Result<()> {
    same(folder)?;
    println!("{:<44}{:>10}", "", "ns");
    let wide = has_wide_registers();
    let in_c = InC::measure(folder, wide);
    match &in_c {
        Ok(InC { plant, paper, coupled }) => {
            println!("{:<44}{plant:>10.0}", "in C, plant");
            println!("{:<44}{paper:>10.0}", "in C, nabfc");
            println!("{:<44}{coupled:>10.0}", "in C, coupled");
        }
        Err(error) => println!("SKIPPED: the same in C: {error}"),
    }
    if wide && let Ok(InC { plant, paper, coupled }) = InC::measure(folder, false) {
        println!("{:<44}{plant:>10.0}", "in C without wide registers, plant");
        println!("{:<44}{paper:>10.0}", "in C without wide registers, nabfc");
        println!("{:<44}{coupled:>10.0}", "in C without wide registers, coupled");
    }
    for name in Case::NAMES.into_iter().chain(Case::DEFAULT) {
        let mut case = Case::new(name, folder)?;
        let cost = nanoseconds(u32::try_from(RUN)?, || case.step());
        match in_c.as_ref().ok().and_then(|in_c| in_c.of(name)) {
            Some(peer) => println!("{:<44}{cost:>10.0}   {:.2} x C", format!("step, {name}"), cost / peer),
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
    // A reset takes parameters back to their defaults: the default law.
    for (name, mut slave) in [("plant", Slave::plant(folder, None)?), ("nabfc-r", Slave::controller(folder, &NABFC_R)?)]
    {
        let (reset, initialise) = restart(&mut slave);
        println!("{:<44}{reset:>10.0}", format!("fmi2Reset after a step, {name}"));
        println!("{:<44}{initialise:>10.0}", format!("initialise after it, {name}"));
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
        ("plant", PLANT, &common::COMMANDS[..], common::MEASURED),
        ("nabfc", NABFC.fmu, common::MEASURED, &common::COMMANDS[..]),
    ] {
        let fmu = open(folder, file)?;
        let start =
            nanoseconds(5, || _ = black_box(Slave::new(&fmu, inputs, outputs, None, empty()).expect("defaults")));
        println!("{:<44}{start:>10.0}", format!("instantiate, initialise, free, {name}"));
    }
    Ok(())
}

/// Nanoseconds of `fmi2Reset` of a slave that has stepped, and of its initialisation afterwards: the lowest of many, each with two looks
/// at the clock.
fn restart(slave: &mut Slave) -> (f64, f64) {
    let (mut reset, mut initialise) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..500 {
        slave.do_step();
        let begin = Instant::now();
        slave.instance.reset().expect("a reset");
        reset = reset.min(begin.elapsed().as_secs_f64() * 1e9);
        let begin = Instant::now();
        slave.start().expect("an initialisation");
        initialise = initialise.min(begin.elapsed().as_secs_f64() * 1e9);
    }
    (reset, initialise)
}

/// Orders of a plant alone.
const ORDERS: [i32; 8] = [4, 6, 8, 10, 12, 16, 20, 24];

/// Numbers of pairs in one process.
const PAIRS: [usize; 5] = [1, 10, 100, 1000, 10_000];

/// How often each of these is measured, in turns: what disturbs one round may leave another alone.
const ROUNDS: usize = 3;

/// What a step costs: of one plant by its order, of pairs of plant (order 8) and NABFC (the paper's law, and the default law) by their number.
/// The lowest of the rounds, but for the memory, which only the first round takes from the system.
fn sizes(folder: &Path) -> Result<()> {
    let mut lowest: Vec<Cost> = Vec::new();
    for round in 0..ROUNDS {
        let mut found = Vec::new();
        for order in ORDERS {
            found.push(plant_cost(folder, order)?);
        }
        for (what, scenario) in [("pair", &NABFC), ("pair-r", &NABFC_R)] {
            for count in PAIRS {
                found.push(pair_cost(folder, what, scenario, count)?);
            }
        }
        if lowest.is_empty() {
            lowest = found;
        } else {
            for (low, found) in lowest.iter_mut().zip(found) {
                low.step = low.step.min(found.step);
                low.in_c = low.in_c.min(found.in_c);
                low.start = low.start.min(found.start);
            }
        }
        eprintln!("round {} of {ROUNDS} done", round + 1);
    }
    println!("what,order,instances,step_ns,in_c_ns,start_us,kib_each");
    for Cost { what, order, count, step, in_c, start, memory } in lowest {
        println!("{what},{order},{count},{step:.0},{in_c:.0},{start:.0},{memory:.1}");
    }
    Ok(())
}

/// Cost of one among some.
struct Cost {
    what: &'static str,
    order: i32,
    count: usize,
    /// A step \[ns\].
    step: f64,
    /// The same in C \[ns\]; NaN without a C compiler.
    in_c: f64,
    /// Instantiation, initialisation and the first step \[µs\].
    start: f64,
    /// Memory beyond that of the first \[KiB\]; for one alone what it takes; NaN where it is not known.
    memory: f64,
}

fn plant_cost(folder: &Path, order: i32) -> Result<Cost> {
    let resident = resident_kib();
    let fmu = open(folder, PLANT)?;
    let begin = Instant::now();
    let mut plant = Slave::new(&fmu, &common::COMMANDS, common::MEASURED, Some(order), empty())?;
    plant.do_step();
    let start = begin.elapsed().as_secs_f64() * 1e6;
    let memory = resident_kib() - resident;
    let mut outputs = [0.0; 12];
    let step = nanoseconds(10_000, || plant.step(&[0.01, -0.01, 0.1], &mut outputs));
    let peer = Peers::compile(has_wide_registers(), usize::try_from(order)?).and_then(|peers| peers.plant());
    let in_c = peer.map_or(f64::NAN, |mut peer| nanoseconds(10_000, || peer.step(&[0.01, -0.01, 0.1], &mut outputs)));
    Ok(Cost { what: "plant", order, count: 1, step, in_c, start, memory })
}

fn pair_cost(folder: &Path, what: &'static str, scenario: &Controller, count: usize) -> Result<Cost> {
    let fmus = (open(folder, PLANT)?, open(folder, scenario.fmu)?);
    let mut pairs = vec![Pair::of(&fmus, scenario)?];
    pairs[0].step();
    let resident = resident_kib();
    let begin = Instant::now();
    while pairs.len() < count {
        let mut pair = pairs[0].another(&fmus, scenario)?;
        pair.step();
        pairs.push(pair);
    }
    let more = (count - 1).max(1) as f64;
    let start = begin.elapsed().as_secs_f64() * 1e6 / more;
    // Of the second law it would be what the first has left behind.
    let memory = if what == "pair" { (resident_kib() - resident) / more } else { f64::NAN };
    // All pairs take a step, then all the next: each finds the caches as the others left them.
    let rounds = u32::try_from(4000 / count.min(4000)).unwrap_or(1).max(1);
    let step = nanoseconds(rounds, || pairs.iter_mut().for_each(Pair::step)) / count as f64;
    let in_c = if count == 1 && what == "pair" {
        let peer = Peers::compile(has_wide_registers(), 8).and_then(|peers| PeerPair::new(&peers, folder));
        peer.map_or(f64::NAN, |mut peer| nanoseconds(4000, || peer.step()))
    } else {
        f64::NAN
    };
    Ok(Cost { what, order: 8, count, step, in_c, start, memory })
}

/// Memory of this process that is in use, where the system tells.
fn resident_kib() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok()).map_or(f64::NAN, |pages| pages * 4.0)
}
