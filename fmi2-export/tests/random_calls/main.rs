//! Random calls with random arguments, checked against a model of the state machine that knows nothing of the slave's code.
//!
//! Every call is either refused (fmi2Error, a message, nothing changed) or has the effect it should have: the reference
//! below tracks the state, the clock and the value of every variable that can be set, through saved states and resets.
//! The sequences are the same at every run. `FMI2_CALLS` changes their number, `FMI2_SEED` their beginning, `FMI2_TRACE=1`
//! prints each call. Libraries of real FMUs are driven as well if there are any, see `common::real`.
//!
//! Memory errors. What can be used, from strongest to weakest, as of Rust 1.95:
//! * Miri cannot load libraries and needs a nightly toolchain: not used.
//! * `AddressSanitizer` is a `-Z` option, so it needs a nightly toolchain. It sees the stack and the heap, but not into the
//!   standard library, which is precompiled. `all_calls_under_address_sanitizer`; compiling takes minutes.
//! * valgrind's memcheck is the strongest that works with stable Rust: all code including the standard library's, on the
//!   heap only, and it also finds uses of uninitialised memory and leaks. `all_calls_under_valgrind`, both in `memory.rs`.
//!
//! Both run with
//!
//! ```text
//! cargo test --release -p fmi2-export --test random_calls -- --ignored --nocapture
//! ```
//!
//! and say what was not checked if the tool is not there.

mod checks;
#[path = "../common/mod.rs"]
mod common;
mod memory;
mod moves;
mod profile;
mod random;
mod saved;
mod values;

use std::collections::HashMap;
use std::ffi::{CString, c_int, c_void};
use std::path::Path;

use common::real::{Counts, all_libraries};
use common::{Fmu, Slave};
use random::Random;

/// Calls to each library, and the beginning of their sequence.
const CALLS: u64 = 340_000;
const SEED: u64 = 20_260_101;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Instantiated,
    Initialization,
    Stepping,
    Discarded,
    Terminated,
    Failed,
    /// Of model exchange.
    Event,
    Continuous,
}

use Phase::{Continuous, Discarded, Event, Failed, Initialization, Instantiated, Stepping, Terminated};

/// When a variable can be set: found out by trying.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "one answer per phase")]
struct Settable {
    before: bool,
    stepping: bool,
    event: bool,
    continuous: bool,
}

impl Settable {
    fn in_phase(self, phase: Phase) -> bool {
        match phase {
            Instantiated | Initialization => self.before,
            Stepping => self.stepping,
            Event => self.event,
            Continuous => self.continuous,
            Discarded | Terminated | Failed => false,
        }
    }
}

/// A value as the reference knows it; a Boolean is 0 or 1.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Real(u64),
    Integer(c_int),
    Text(CString),
}

/// What is known of a model.
struct Profile {
    guid: String,
    counts: Counts,
    /// By type (0 Real, 1 Integer, 2 Boolean, 3 String) and value reference.
    settable: [Vec<Settable>; 4],
    ramped: Vec<bool>,
    /// Start values of all that can be set.
    start: HashMap<(usize, u32), Value>,
    /// It panics when it is told to, even at being looked at.
    misbehaves: bool,
    /// Numbers of continuous states and event indicators, if it offers model exchange.
    exchange: Option<(usize, usize)>,
}

/// What an instance's state should be.
#[derive(Clone)]
struct Expected {
    /// Of model exchange.
    exchange: bool,
    phase: Phase,
    experiment: bool,
    time: f64,
    stop: f64,
    values: HashMap<(usize, u32), Value>,
    slopes: HashMap<u32, f64>,
}

impl Expected {
    fn fresh(profile: &Profile, exchange: bool) -> Self {
        Self {
            exchange,
            phase: Instantiated,
            experiment: false,
            time: 0.0,
            stop: f64::INFINITY,
            values: profile.start.clone(),
            slopes: HashMap::new(),
        }
    }
}

struct Instance<'f> {
    slave: Slave<'f>,
    model: usize,
    expected: Expected,
}

/// How a call may end.
enum Allowed {
    /// Refused.
    No,
    Yes,
    /// The model may fail, or has a range that is not known here.
    Perhaps,
}

/// A host that is drunk.
struct Host<'f> {
    fmu: &'f Fmu,
    profiles: &'f [Profile],
    random: Random,
    instances: Vec<Instance<'f>>,
    /// Handle, model and state of what has been saved, with its owner's component.
    saved: Vec<(*mut c_void, usize, Expected, *mut c_void)>,
    /// Serialised states, and whether the model has to accept them.
    blobs: Vec<(Vec<u8>, usize, Expected, bool)>,
    calls: u64,
    trace: bool,
}

impl Host<'_> {
    fn one_call(&mut self) {
        if self.instances.len() < 2 {
            self.instantiate();
        }
        let i = self.random.below(self.instances.len());
        match self.random.below(100) {
            0..18 => self.set(i),
            18..30 => self.get(i),
            30..34 => self.get_many_ways(i),
            // In either interface what moves it on, but now and then what it does not have.
            34..64 if self.instances[i].expected.exchange != self.random.rarely(20) => self.be_integrated(i),
            34..64 => self.step(i),
            64..80 => self.change_phase(i),
            80..94 => self.states(i),
            94..97 => self.ramp(i),
            97 => self.debug_logging(i),
            98 if self.random.rarely(10) => self.free(i),
            _ => self.status(i),
        }
    }
}

fn variable<T: std::str::FromStr>(name: &str, default: T) -> T {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Makes random calls to a library's instances; how many were made.
fn drive(path: &Path, calls: u64, seed: u64) -> u64 {
    let fmu = Fmu::open(path);
    let misbehaves = path.to_string_lossy().contains("misbehaving");
    let profiles: Vec<Profile> = fmu.guids().iter().map(|guid| Profile::explore(&fmu, guid, misbehaves)).collect();
    println!("{}: {calls} calls, seed {seed}", path.file_name().unwrap().display());
    let mut host = Host {
        fmu: &fmu,
        profiles: &profiles,
        random: Random(seed),
        instances: Vec::new(),
        saved: Vec::new(),
        blobs: Vec::new(),
        calls: 0,
        trace: variable("FMI2_TRACE", 0) != 0,
    };
    while host.calls < calls {
        host.one_call();
    }
    host.calls
}

#[test]
fn random_calls_have_the_effect_they_should_or_none() {
    let calls = variable("FMI2_CALLS", CALLS);
    let mut total = 0;
    for (i, path) in (0..).zip(all_libraries()) {
        // Real FMUs compute more in a call.
        let calls = if i < 3 { calls } else { calls / 10 };
        total += drive(&path, calls, variable("FMI2_SEED", SEED) + i);
    }
    println!("{total} calls");
}
