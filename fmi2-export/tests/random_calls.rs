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
//!   standard library, which is precompiled. `all_calls_under_address_sanitizer` below; compiling takes minutes.
//! * valgrind's memcheck is the strongest that works with stable Rust: all code including the standard library's, on the
//!   heap only, and it also finds uses of uninitialised memory and leaks. `all_calls_under_valgrind` below.
//!
//! Both run with
//!
//! ```text
//! cargo test --release -p fmi2-export --test random_calls -- --ignored --nocapture
//! ```
//!
//! and say what was not checked if the tool is not there.

mod common;

use std::collections::{HashMap, VecDeque};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::process::Command;
use std::ptr::{null, null_mut, without_provenance_mut};
use std::sync::Mutex;

use common::real::{Counts, EXAMPLES, all_libraries, count, libraries, reals};
use common::{CO_SIMULATION, DISCARD, ERROR, EventInfo, Fmu, MODEL_EXCHANGE, OK, Slave};

/// Calls to each library, and the beginning of their sequence.
const CALLS: u64 = 340_000;
const SEED: u64 = 20_260_101;

/// A generator of random numbers: `SplitMix64`.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next() % n as u64).unwrap()
    }

    /// True once in n times.
    fn rarely(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    fn number(&mut self) -> f64 {
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        match self.below(40) {
            0 => f64::NAN,
            1 => self.pick(&[f64::INFINITY, f64::NEG_INFINITY]),
            2 => self.pick(&[f64::MAX, f64::MIN, 1e300, -1e200]),
            3 => self.pick(&[5e-324, -5e-324, f64::MIN_POSITIVE, -0.0]),
            4 => f64::from_bits(self.next()),
            5..8 => self.pick(&[0.0, 1.0, -1.0]),
            _ => 2.0 * unit - 1.0,
        }
    }

    fn size(&mut self) -> f64 {
        match self.below(20) {
            0 => self.pick(&[0.0, -0.1, f64::NAN, f64::INFINITY, -0.0]),
            1 => self.pick(&[5e-324, 1e-300, 1e-18]),
            2 => self.pick(&[1e3, 1e9, 1e300, f64::MAX]),
            3 => self.number(),
            _ => self.pick(&[1e-4, 1e-4, 1e-3, 0.01, 0.1]),
        }
    }
}

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

impl Profile {
    fn explore(fmu: &Fmu, guid: &str, misbehaves: bool) -> Self {
        let counts = count(fmu, guid);
        let fresh = fmu.instantiate(guid);
        fresh.initialize();
        let (before, stepping) = (fmu.instantiate(guid), fmu.instantiate(guid));
        stepping.initialize();
        let in_mode = |continuous: bool| {
            let slave = fmu.instantiate_as(MODEL_EXCHANGE, guid).ok()?;
            if continuous {
                slave.start();
            } else {
                slave.initialize();
            }
            Some(slave)
        };
        let (event, continuous) = (in_mode(false), in_mode(true));
        let exchange = continuous.as_ref().map(|slave| {
            let (c, mut buffer) = (slave.component, vec![0.0; 10_000]);
            let buffer = buffer.as_mut_ptr();
            let count = |get: &dyn Fn(usize) -> c_int| (0..10_000).find(|n| get(*n) == OK).unwrap();
            let states = count(&|n| fmu.fmi2GetContinuousStates(c, buffer, n));
            (states, count(&|n| fmu.fmi2GetEventIndicators(c, buffer, n)))
        });
        let mut start = HashMap::new();
        let lengths = [counts.reals, counts.integers, counts.booleans, counts.strings];
        let settable = std::array::from_fn(|kind| {
            (0..lengths[kind])
                .map(|vr| {
                    let value = read(&fresh, kind, vr);
                    let takes = |slave: &Slave| write(slave, kind, &[vr], std::slice::from_ref(&value)) == OK;
                    let settable = Settable {
                        before: takes(&before),
                        stepping: takes(&stepping),
                        event: event.as_ref().is_some_and(takes),
                        continuous: continuous.as_ref().is_some_and(takes),
                    };
                    if settable.before {
                        start.insert((kind, vr), value);
                    }
                    settable
                })
                .collect()
        });
        let ramped = (0..counts.reals)
            .map(|vr| fmu.fmi2SetRealInputDerivatives(stepping.component, &raw const vr, 1, &1, &0.0) == OK)
            .collect();
        Self { guid: guid.to_owned(), counts, settable, ramped, start, misbehaves, exchange }
    }

    fn length(&self, kind: usize) -> u32 {
        let Counts { reals, integers, booleans, strings } = self.counts;
        [reals, integers, booleans, strings][kind]
    }
}

fn read(slave: &Slave, kind: usize, vr: u32) -> Value {
    let (fmu, c) = (slave.fmu, slave.component);
    let (mut real, mut integer, mut text) = (0.0, 0, null());
    let status = match kind {
        0 => fmu.fmi2GetReal(c, &raw const vr, 1, &raw mut real),
        1 => fmu.fmi2GetInteger(c, &raw const vr, 1, &raw mut integer),
        2 => fmu.fmi2GetBoolean(c, &raw const vr, 1, &raw mut integer),
        _ => fmu.fmi2GetString(c, &raw const vr, 1, &raw mut text),
    };
    assert_eq!(status, OK, "{:?}", slave.log);
    match kind {
        0 => Value::Real(real.to_bits()),
        1 | 2 => Value::Integer(integer),
        // SAFETY: just returned, and no call since.
        _ => Value::Text(unsafe { CStr::from_ptr(text) }.to_owned()),
    }
}

fn write(slave: &Slave, kind: usize, vr: &[u32], values: &[Value]) -> c_int {
    let (fmu, c, n) = (slave.fmu, slave.component, vr.len());
    let reals: Vec<f64> =
        values.iter().map(|v| if let Value::Real(v) = v { f64::from_bits(*v) } else { 0.0 }).collect();
    let integers: Vec<c_int> = values.iter().map(|v| if let Value::Integer(v) = v { *v } else { 0 }).collect();
    let texts: Vec<*const c_char> =
        values.iter().map(|v| if let Value::Text(v) = v { v.as_ptr() } else { null() }).collect();
    match kind {
        0 => fmu.fmi2SetReal(c, vr.as_ptr(), n, reals.as_ptr()),
        1 => fmu.fmi2SetInteger(c, vr.as_ptr(), n, integers.as_ptr()),
        2 => fmu.fmi2SetBoolean(c, vr.as_ptr(), n, integers.as_ptr()),
        _ => fmu.fmi2SetString(c, vr.as_ptr(), n, texts.as_ptr()),
    }
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
    fn instantiate(&mut self) {
        let model = self.random.below(self.profiles.len());
        let profile = &self.profiles[model];
        let exchange = profile.exchange.is_some() && self.random.rarely(2);
        let kind = if exchange { MODEL_EXCHANGE } else { CO_SIMULATION };
        let slave = self.fmu.instantiate_as(kind, &profile.guid).unwrap_or_else(|log| panic!("{log:?}"));
        self.instances.push(Instance { slave, model, expected: Expected::fresh(profile, exchange) });
    }

    /// Compares what a call did with what it should have done, and says whether it succeeded.
    fn check(&mut self, i: usize, what: &str, allowed: &Allowed, before: Option<&[u8]>, status: c_int) -> bool {
        self.calls += 1;
        if self.trace {
            println!("{} {i} {:?} {what} -> {status}", self.calls, self.instances[i].expected.phase);
        }
        let case = || format!("call {} on {:?}: {what} -> {status}", self.calls, self.instances[i].expected.phase);
        let log = std::mem::take(&mut *self.instances[i].slave.log.lock().unwrap());
        assert!([OK, DISCARD, ERROR].contains(&status), "{}", case());
        if status != OK {
            let known = ["logStatusWarning", "logStatusDiscard", "logStatusError", "logEvents"];
            let told = log
                .iter()
                .any(|(s, category, text)| *s == status && known.contains(&category.as_str()) && !text.is_empty());
            assert!(told, "{}: {log:?}", case());
        }
        if status == ERROR && log.iter().any(|(_, _, message)| message.starts_with("internal error")) {
            assert!(self.profiles[self.instances[i].model].misbehaves, "{}: {log:?}", case());
            let expected = &mut self.instances[i].expected;
            // It has failed, in the midst of something.
            (expected.phase, expected.values) = (Failed, HashMap::new());
            return false;
        }
        let good = status == OK;
        match allowed {
            Allowed::No => assert!(status == ERROR, "{}: {log:?}", case()),
            Allowed::Yes => assert!(good, "{}: {log:?}", case()),
            Allowed::Perhaps => {}
        }
        if let (ERROR, Some(before)) = (status, before) {
            assert!(self.instances[i].slave.blob() == before, "{}: changed the state", case());
            self.instances[i].slave.log.lock().unwrap().clear();
        }
        good
    }

    /// The state before a call, now and then.
    fn before(&mut self, i: usize) -> Option<Vec<u8>> {
        (self.random.rarely(8) && self.can_be_saved(i)).then(|| self.instances[i].slave.blob())
    }

    /// Whether saving and serialising cannot fail: see the faults of `misbehaving`.
    fn can_be_saved(&self, i: usize) -> bool {
        let Instance { model, expected, .. } = &self.instances[i];
        !self.profiles[*model].misbehaves
            || matches!(expected.values.get(&(1, 0)), Some(Value::Integer(fault)) if *fault < 12)
    }

    /// Whether a model has to accept the state from bytes: it may refuse one with which it could not be initialized, or
    /// that has numbers beyond all bounds.
    fn is_sound(&self, i: usize) -> bool {
        let Instance { slave, model, expected } = &self.instances[i];
        let profile = &self.profiles[*model];
        profile.misbehaves
            || !matches!(expected.phase, Instantiated | Initialization)
                && reals(slave, profile.counts).iter().all(|value| value.is_finite())
    }

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

    fn references(&mut self, kind: usize, model: usize) -> Vec<u32> {
        let n = self.profiles[model].length(kind);
        let random = &mut self.random;
        let length = random.below(5);
        (0..length)
            .map(|_| match random.below(60) {
                0 => random.pick(&[n, n + 1, u32::MAX, u32::MAX / 2]),
                _ if n > 0 => u32::try_from(random.below(n as usize)).unwrap(),
                _ => 0,
            })
            .collect()
    }

    fn set(&mut self, i: usize) {
        let (model, phase) = (self.instances[i].model, self.instances[i].expected.phase);
        let kind = self.random.pick(&[0, 0, 0, 0, 1, 2, 3]);
        let mut references = self.references(kind, model);
        // Mostly what can be set: else hardly anything would be.
        if !self.random.rarely(4) {
            references
                .retain(|vr| self.profiles[model].settable[kind].get(*vr as usize).is_some_and(|s| s.in_phase(phase)));
        }
        let values: Vec<Value> = references.iter().map(|_| self.value(kind)).collect();
        let settable = references
            .iter()
            .all(|vr| self.profiles[model].settable[kind].get(*vr as usize).is_some_and(|s| s.in_phase(phase)));
        let valid = values.iter().all(|value| match value {
            Value::Real(bits) => f64::from_bits(*bits).is_finite(),
            Value::Integer(value) => kind == 1 || matches!(value, 0 | 1),
            Value::Text(text) => text.to_str().is_ok(),
        });
        let in_order =
            matches!(phase, Instantiated | Initialization | Stepping | Event) || phase == Continuous && kind == 0;
        let allowed = match (in_order && settable && valid, references.is_empty()) {
            (false, _) => Allowed::No,
            (true, true) => Allowed::Yes,
            (true, false) => Allowed::Perhaps,
        };
        let before = self.before(i);
        let status = write(&self.instances[i].slave, kind, &references, &values);
        let what = format!("set {kind} {references:?} {values:?}");
        if self.check(i, &what, &allowed, before.as_deref(), status) {
            let known = &mut self.instances[i].expected.values;
            known.extend(references.iter().zip(values).map(|(vr, value)| ((kind, *vr), value)));
        }
    }

    fn value(&mut self, kind: usize) -> Value {
        let random = &mut self.random;
        match kind {
            0 => Value::Real(random.number().to_bits()),
            1 => Value::Integer(match random.below(10) {
                0 => random.pick(&[c_int::MAX, c_int::MIN, -1, 0]),
                1 => random.pick(&[100, 1000, 24, 25]),
                // Mostly no fault.
                2..6 => 1,
                _ => c_int::try_from(random.below(36)).unwrap(),
            }),
            2 => Value::Integer(if random.rarely(30) { random.pick(&[-1, 2]) } else { random.pick(&[0, 1]) }),
            _ => Value::Text(random.pick(&[c"", c"text", c"%s%n#r1#", c"\xff\xfe", c"größer", c"\x01"]).into()),
        }
    }

    fn get(&mut self, i: usize) {
        let (model, phase) = (self.instances[i].model, self.instances[i].expected.phase);
        let kind = self.random.pick(&[0, 0, 0, 1, 2, 3]);
        let references = self.references(kind, model);
        let known = references.iter().all(|vr| *vr < self.profiles[model].length(kind));
        // In initialization mode, the model may refuse to be initialized with these parameters.
        let allowed = match (phase, known) {
            (Instantiated, _) | (_, false) => Allowed::No,
            (Initialization, _) => Allowed::Perhaps,
            _ if self.profiles[model].misbehaves => Allowed::Perhaps,
            _ => Allowed::Yes,
        };
        let before = self.before(i);
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let n = references.len();
        let (mut reals, mut integers, mut texts) = (vec![0.5; n], vec![77; n], vec![null(); n]);
        let vr = references.as_ptr();
        let status = match kind {
            0 => fmu.fmi2GetReal(c, vr, n, reals.as_mut_ptr()),
            1 => fmu.fmi2GetInteger(c, vr, n, integers.as_mut_ptr()),
            2 => fmu.fmi2GetBoolean(c, vr, n, integers.as_mut_ptr()),
            _ => fmu.fmi2GetString(c, vr, n, texts.as_mut_ptr()),
        };
        let values: Vec<Value> = (0..n)
            .map(|k| match kind {
                0 => Value::Real(reals[k].to_bits()),
                1 | 2 => Value::Integer(integers[k]),
                _ if texts[k].is_null() => Value::Text(CString::default()),
                // SAFETY: just returned, and no call since.
                _ => Value::Text(unsafe { CStr::from_ptr(texts[k]) }.to_owned()),
            })
            .collect();
        if self.check(i, &format!("get {kind} {references:?}"), &allowed, before.as_deref(), status) {
            for (vr, value) in references.iter().zip(&values) {
                let expected = self.instances[i].expected.values.get(&(kind, *vr));
                assert!(
                    expected.is_none_or(|e| e == value),
                    "call {}: {kind} {vr}: {value:?} {expected:?}",
                    self.calls
                );
            }
        } else {
            assert!(reals.iter().all(|v| *v == 0.5) && integers.iter().all(|v| *v == 77), "written though refused");
        }
    }

    fn get_many_ways(&mut self, i: usize) {
        let (model, phase) = (self.instances[i].model, self.instances[i].expected.phase);
        let (a, b) = (self.references(0, model), self.references(0, model));
        let seed: Vec<f64> = b.iter().map(|_| self.random.number()).collect();
        let orders: Vec<c_int> = a.iter().map(|_| self.random.pick(&[1, 1, 1, 2, 0, -1])).collect();
        let mut values = vec![0.0; a.len()];
        let before = self.before(i);
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let (status, legal) = if self.random.rarely(2) {
            let (n, k) = (a.len(), b.len());
            let (seed, values) = (seed.as_ptr(), values.as_mut_ptr());
            (fmu.fmi2GetDirectionalDerivative(c, a.as_ptr(), n, b.as_ptr(), k, seed, values), phase != Instantiated)
        } else {
            let (vr, order, values) = (a.as_ptr(), orders.as_ptr(), values.as_mut_ptr());
            let status = fmu.fmi2GetRealOutputDerivatives(c, vr, a.len(), order, values);
            (status, !self.instances[i].expected.exchange && !matches!(phase, Instantiated | Initialization))
        };
        let allowed = if legal { Allowed::Perhaps } else { Allowed::No };
        self.check(i, &format!("derivatives {a:?} {b:?} {seed:?} {orders:?}"), &allowed, before.as_deref(), status);
    }

    fn ramp(&mut self, i: usize) {
        let (model, phase) = (self.instances[i].model, self.instances[i].expected.phase);
        let references = self.references(0, model);
        let values: Vec<f64> = references.iter().map(|_| self.random.number()).collect();
        let orders: Vec<c_int> = references.iter().map(|_| self.random.pick(&[1, 1, 1, 1, 2, 0])).collect();
        let ramped = references.iter().all(|vr| self.profiles[model].ramped.get(*vr as usize) == Some(&true));
        let valid = ramped && values.iter().all(|v| v.is_finite()) && orders.iter().all(|order| *order == 1);
        let legal = !self.instances[i].expected.exchange && matches!(phase, Instantiated | Initialization | Stepping);
        let before = self.before(i);
        let (vr, n) = (references.as_ptr(), references.len());
        let c = self.instances[i].slave.component;
        let status = self.fmu.fmi2SetRealInputDerivatives(c, vr, n, orders.as_ptr(), values.as_ptr());
        let allowed = if legal && valid { Allowed::Yes } else { Allowed::No };
        let what = format!("ramps {references:?} {orders:?} {values:?}");
        if self.check(i, &what, &allowed, before.as_deref(), status) {
            self.instances[i].expected.slopes.extend(references.iter().copied().zip(values));
        }
    }

    fn step(&mut self, i: usize) {
        let Expected { phase, time: now, stop, ref slopes, .. } = self.instances[i].expected;
        let ramped = slopes.values().any(|slope| *slope != 0.0);
        let size = self.random.size();
        let (time, right) = match self.random.below(30) {
            0 => (self.random.pick(&[f64::NAN, f64::INFINITY]), false),
            // Clearly elsewhere.
            1 => (now + (0.5 * size.abs()).max(1e-3 * now.abs()).max(1e-3), false),
            _ => (now, true),
        };
        let end = now + size;
        // Past the stop time by more than rounding.
        let past = end > stop + (1.1e-6 + 2e-7 * stop.abs()).min(0.5 * size) + 1e-14 * end.abs();
        let possible = right && size > 0.0 && end > now && end.is_finite() && !past;
        let allowed = if phase == Stepping && possible { Allowed::Perhaps } else { Allowed::No };
        let before = self.before(i);
        let slave = &self.instances[i].slave;
        let status = self.fmu.fmi2DoStep(slave.component, time, size, c_int::from(self.random.rarely(2)));
        // A step that the model fails at leaves the state behind; one that is refused does not.
        let message = self.instances[i].slave.message();
        let refused = phase != Stepping
            || ["communicationStepSize", "currentCommunicationPoint", "the step ends at"]
                .iter()
                .any(|start| message.starts_with(start))
            || (ramped && message.contains("at the end of this step"));
        let before = before.filter(|_| refused);
        if self.check(i, &format!("step {time:?} {size:?}"), &allowed, before.as_deref(), status) {
            let expected = &mut self.instances[i].expected;
            expected.time = end;
            for (vr, slope) in expected.slopes.drain().filter(|(_, slope)| *slope != 0.0) {
                if let Some(Value::Real(bits)) = expected.values.get_mut(&(0, vr)) {
                    *bits = (f64::from_bits(*bits) + slope * size).to_bits();
                }
            }
        } else if status == DISCARD {
            self.instances[i].expected.phase = Discarded;
        } else if !refused {
            self.instances[i].expected.phase = Failed;
        }
    }

    /// What only model exchange has.
    fn be_integrated(&mut self, i: usize) {
        let Instance { model, expected, slave } = &self.instances[i];
        let (phase, exchange) = (expected.phase, expected.exchange);
        let (states, indicators) = self.profiles[*model].exchange.unwrap_or((1, 1));
        let (fmu, c) = (self.fmu, slave.component);
        let running = matches!(phase, Event | Continuous);
        let for_debugging = matches!(phase, Terminated | Failed);
        let initialization = phase == Initialization;
        // Mostly what there is.
        let wrong_count = self.random.rarely(30);
        let n = |right: usize| if wrong_count { right + 1 } else { right };
        let mut numbers = vec![7.0; states.max(indicators) + 1];
        let before = self.before(i);
        let before = before.as_deref();
        let when = |legal| if exchange && legal { Allowed::Yes } else { Allowed::No };
        let perhaps = |legal| if exchange && legal && !wrong_count { Allowed::Perhaps } else { Allowed::No };
        match (self.random.below(16), phase) {
            (0, _) => {
                let status = fmu.fmi2EnterEventMode(c);
                if self.check(i, "enter event mode", &when(running), before, status) {
                    self.instances[i].expected.phase = Event;
                }
            }
            (1..4, Event) | (1, _) => {
                let status = fmu.fmi2EnterContinuousTimeMode(c);
                if self.check(i, "enter continuous-time mode", &when(phase == Event), before, status) {
                    self.instances[i].expected.phase = Continuous;
                }
            }
            (4..6, Event) | (2, _) => {
                let mut info = EventInfo::default();
                let status = fmu.fmi2NewDiscreteStates(c, &raw mut info);
                let legal = exchange && phase == Event;
                let allowed = if legal { Allowed::Perhaps } else { Allowed::No };
                let before = before.filter(|_| !legal);
                if !self.check(i, "new discrete states", &allowed, before, status) && legal {
                    self.instances[i].expected.phase = Failed;
                }
            }
            (3, _) => {
                let status = fmu.fmi2CompletedIntegratorStep(c, 1, &mut 0, &mut 0);
                let legal = exchange && phase == Continuous;
                let allowed = if legal { Allowed::Perhaps } else { Allowed::No };
                let before = before.filter(|_| !legal);
                if !self.check(i, "completed step", &allowed, before, status) && legal {
                    self.instances[i].expected.phase = Failed;
                }
            }
            (4 | 5, _) => {
                let time = self.random.number();
                let status = fmu.fmi2SetTime(c, time);
                if self.check(i, &format!("time {time:?}"), &when(running && time.is_finite()), before, status) {
                    self.instances[i].expected.time = time;
                }
            }
            (6..9, _) => {
                numbers.fill_with(|| self.random.number());
                let x = &numbers[..n(states)];
                let status = fmu.fmi2SetContinuousStates(c, x.as_ptr(), x.len());
                let allowed = perhaps(phase == Continuous);
                self.check(i, &format!("states {x:?}"), &allowed, before.filter(|_| status != OK), status);
            }
            (kind, _) => {
                let x = numbers.as_mut_ptr();
                let (what, status, legal) = match kind {
                    9 | 10 => ("derivatives", fmu.fmi2GetDerivatives(c, x, n(states)), running || for_debugging),
                    11 | 12 => (
                        "indicators",
                        fmu.fmi2GetEventIndicators(c, x, n(indicators)),
                        running || for_debugging || initialization,
                    ),
                    13 => (
                        "continuous states",
                        fmu.fmi2GetContinuousStates(c, x, n(states)),
                        running || for_debugging || initialization,
                    ),
                    _ => ("nominals", fmu.fmi2GetNominalsOfContinuousStates(c, x, n(states)), true),
                };
                let allowed = perhaps(legal);
                if !self.check(i, what, &allowed, before, status) {
                    assert!(numbers.iter().all(|v| *v == 7.0), "written though refused");
                }
            }
        }
    }

    fn change_phase(&mut self, i: usize) {
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let Expected { phase, experiment, .. } = self.instances[i].expected;
        // Mostly forward.
        let forward = match phase {
            Instantiated if experiment => 1,
            Instantiated => 0,
            Initialization => 2,
            Stepping | Event | Continuous => 5,
            Discarded | Terminated | Failed => 4,
        };
        let choice = if self.random.rarely(3) { self.random.below(5) } else { forward };
        let before = self.before(i);
        let before = before.as_deref();
        let when = |legal| if legal { Allowed::Yes } else { Allowed::No };
        let perhaps = |legal| if legal { Allowed::Perhaps } else { Allowed::No };
        match choice {
            0 => {
                let start = self.random.pick(&[0.0, 0.0, 0.0, 1.5, -3.0, 1e9, f64::NAN, f64::INFINITY]);
                let stop = self.random.pick(&[f64::INFINITY, start + 1.0, start + 10.0, start - 1.0, f64::NAN]);
                let has_stop = !self.random.rarely(3);
                let valid = start.is_finite() && (!has_stop || stop >= start);
                let status = fmu.fmi2SetupExperiment(c, 0, f64::NAN, start, c_int::from(has_stop), stop);
                let what = format!("setup {start:?} {stop:?} {has_stop}");
                if self.check(i, &what, &when(phase == Instantiated && valid), before, status) {
                    let expected = &mut self.instances[i].expected;
                    (expected.experiment, expected.time) = (true, start);
                    expected.stop = if has_stop { stop } else { f64::INFINITY };
                }
            }
            1 => {
                let status = fmu.fmi2EnterInitializationMode(c);
                if self.check(i, "enter", &perhaps(phase == Instantiated && experiment), before, status) {
                    self.instances[i].expected.phase = Initialization;
                }
            }
            2 => {
                let status = fmu.fmi2ExitInitializationMode(c);
                if self.check(i, "exit", &perhaps(phase == Initialization), before, status) {
                    let expected = &mut self.instances[i].expected;
                    expected.phase = if expected.exchange { Event } else { Stepping };
                }
            }
            3 if self.random.rarely(4) => {
                let status = fmu.fmi2Terminate(c);
                if self.check(
                    i,
                    "terminate",
                    &when(matches!(phase, Stepping | Discarded | Event | Continuous)),
                    before,
                    status,
                ) {
                    self.instances[i].expected.phase = Terminated;
                }
            }
            4 if forward == 4 || self.random.rarely(8) => {
                let status = fmu.fmi2Reset(c);
                if self.check(i, "reset", &Allowed::Yes, before, status) {
                    let Instance { model, expected, .. } = &self.instances[i];
                    let fresh = Expected::fresh(&self.profiles[*model], expected.exchange);
                    self.instances[i].expected = fresh;
                }
            }
            _ => {
                let status = fmu.fmi2CancelStep(c);
                self.check(i, "cancel", &Allowed::No, before, status);
            }
        }
    }

    fn states(&mut self, i: usize) {
        let (fmu, c, model) = (self.fmu, self.instances[i].slave.component, self.instances[i].model);
        let steady = self.can_be_saved(i);
        let choice = self.random.below(12);
        let before = if choice > 2 { self.before(i) } else { None };
        let before = before.as_deref();
        match choice {
            // Save, in a new or a used place.
            0..3 => {
                let old = (!self.saved.is_empty() && self.saved.len() > self.random.below(10))
                    .then(|| self.random.below(self.saved.len()));
                let mut handle = old.map_or(null_mut(), |k| self.saved[k].0);
                let status = fmu.fmi2GetFMUstate(c, &raw mut handle);
                let allowed = if steady { Allowed::Yes } else { Allowed::Perhaps };
                if self.check(i, "save", &allowed, None, status) {
                    let entry = (handle, model, self.instances[i].expected.clone(), c);
                    match old {
                        Some(k) => self.saved[k] = entry,
                        None => self.saved.push(entry),
                    }
                } else if let Some(k) = old {
                    // If it was the destructor of the old state that panicked, the new one is in its place.
                    self.saved.swap_remove(k);
                }
            }
            // Restore, mostly the instance's own.
            3..7 if !self.saved.is_empty() => {
                let own = self.saved.iter().position(|entry| entry.1 == model).filter(|_| !self.random.rarely(4));
                let k = own.unwrap_or_else(|| self.random.below(self.saved.len()));
                let (handle, of, expected, _) = self.saved[k].clone();
                let status = fmu.fmi2SetFMUstate(c, handle);
                let is_own = of == model && expected.exchange == self.instances[i].expected.exchange;
                let allowed = if is_own { Allowed::Yes } else { Allowed::No };
                if self.check(i, &format!("restore {handle:?}"), &allowed, before, status) {
                    self.instances[i].expected = expected;
                }
            }
            7 if !self.saved.is_empty() => {
                let k = self.random.below(self.saved.len());
                let (mut handle, ..) = self.saved.swap_remove(k);
                let status = fmu.fmi2FreeFMUstate(c, &raw mut handle);
                self.check(i, "free state", &Allowed::Yes, None, status);
            }
            // No such state.
            8 => {
                let mut handle = without_provenance_mut(self.random.pick(&[usize::MAX, 0x7fff_ffff, 1 << 40]));
                let status = match self.random.below(4) {
                    0 => fmu.fmi2SetFMUstate(c, handle),
                    1 => fmu.fmi2FreeFMUstate(c, &raw mut handle),
                    2 => fmu.fmi2GetFMUstate(c, &raw mut handle),
                    _ => fmu.fmi2SerializedFMUstateSize(c, handle, &mut 0),
                };
                self.check(i, "no such state", &Allowed::No, before, status);
            }
            9 if steady => {
                let blob = self.instances[i].slave.blob();
                let entry = (blob, model, self.instances[i].expected.clone(), self.is_sound(i));
                if self.blobs.len() < 10 {
                    self.blobs.push(entry);
                } else {
                    let k = self.random.below(10);
                    self.blobs[k] = entry;
                }
            }
            _ if !self.blobs.is_empty() => {
                let k = self.random.below(self.blobs.len());
                let (mut blob, of, expected, sound) = self.blobs[k].clone();
                let damaged = self.random.rarely(3);
                if damaged && self.random.rarely(2) {
                    blob.truncate(self.random.below(blob.len()));
                } else if damaged {
                    let at = self.random.below(8 * blob.len());
                    blob[at / 8] ^= 1 << (at % 8);
                }
                let mut handle = null_mut();
                let status = fmu.fmi2DeSerializeFMUstate(c, blob.as_ptr(), blob.len(), &raw mut handle);
                let is_own = of == model && expected.exchange == self.instances[i].expected.exchange;
                let allowed = match (is_own && !damaged, sound) {
                    (false, _) => Allowed::No,
                    (true, false) => Allowed::Perhaps,
                    (true, true) => Allowed::Yes,
                };
                if self.check(i, &format!("deserialise, damaged: {damaged}"), &allowed, before, status) {
                    self.saved.push((handle, model, expected, c));
                }
            }
            _ => self.status(i),
        }
    }

    fn status(&mut self, i: usize) {
        let phase = self.instances[i].expected.phase;
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let kind = self.random.pick(&[0, 1, 2, 2, 3, 3, 4, -1]);
        let before = self.before(i);
        let legal = !self.instances[i].expected.exchange && matches!(phase, Stepping | Discarded | Terminated);
        let (mut time, mut flag) = (f64::NAN, 7);
        let which = self.random.below(5);
        let status = match which {
            0 => fmu.fmi2GetRealStatus(c, kind, &raw mut time),
            1 => fmu.fmi2GetBooleanStatus(c, kind, &raw mut flag),
            2 => fmu.fmi2GetIntegerStatus(c, kind, &raw mut flag),
            3 => fmu.fmi2GetStatus(c, kind, &raw mut flag),
            _ => fmu.fmi2GetStringStatus(c, kind, &mut null()),
        };
        let allowed = match (legal, which, kind) {
            (false, ..) => Allowed::No,
            (true, 0, 2) | (true, 1, 3) => Allowed::Yes,
            _ => {
                assert_eq!(status, DISCARD);
                Allowed::Perhaps
            }
        };
        if self.check(i, &format!("status {which} {kind}"), &allowed, before.as_deref(), status) && which == 0 {
            assert_eq!(time.to_bits(), self.instances[i].expected.time.to_bits(), "call {}", self.calls);
        }
    }

    fn debug_logging(&mut self, i: usize) {
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let name = self.random.pick(&[c"logAll", c"logStatusError", c"logEvents", c"nothing"]);
        let before = self.before(i);
        let status = fmu.fmi2SetDebugLogging(c, 1, 1, &name.as_ptr());
        let allowed = if name == c"nothing" { Allowed::No } else { Allowed::Yes };
        self.check(i, "debug logging", &allowed, before.as_deref(), status);
    }

    fn free(&mut self, i: usize) {
        let instance = self.instances.swap_remove(i);
        let owner = instance.slave.component;
        self.saved.retain(|entry| entry.3 != owner);
        self.calls += 1;
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

/// Cargo, for test programs of this crate with other tools.
fn cargo(arguments: &[&str], variables: &[(&str, &str)]) -> Command {
    let mut command = Command::new("cargo");
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).envs(variables.iter().copied());
    // Without what the toolchain that runs this test says to its children.
    let own = ["RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN", "CARGO"];
    for name in own {
        command.env_remove(name);
    }
    command
}

/// Runs commands as many at a time as there are processors, the first ones first; what each says is printed when it ends.
fn run(commands: Vec<Command>) {
    let waiting = Mutex::new(VecDeque::from(commands));
    let next = || waiting.lock().unwrap().pop_front();
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(mut command) = next() {
                    let output = command.output().unwrap();
                    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
                    println!("{command:?}\n{}{}", text(&output.stdout), text(&output.stderr));
                    assert!(output.status.success(), "{command:?}");
                }
            });
        }
    });
}

fn works(program: &str, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
}

#[test]
#[ignore = "needs valgrind and some minutes: see the top of this file"]
fn all_calls_under_valgrind() {
    if !works("valgrind", &["--version"]) {
        println!("NOT CHECKED: uses of freed, foreign or uninitialised memory, and leaks; valgrind is not installed");
        return;
    }
    let runner = "target.'cfg(all())'.runner = ['valgrind', '--quiet', '--error-exitcode=9', '--leak-check=full', \
                  '--show-leak-kinds=definite', '--errors-for-leak-kinds=definite']";
    // Of the whole workspace, where this crate is part of one: then nothing is compiled anew.
    let all = ["--release", "--workspace", "--all-features"];
    let examples = EXAMPLES.iter().flat_map(|name| ["--example", name]);
    run(vec![cargo(&["build"].into_iter().chain(all).chain(examples).collect::<Vec<_>>(), &[])]);
    let test = |name: &str, variables: &[(&str, &str)]| {
        cargo(&[&["test"], &all[..], &["--config", runner, "--test", name]].concat(), variables)
    };
    // The random calls take longest: in two parts, which begin at different places.
    let calls = (variable("FMI2_CALLS", CALLS) / 2).to_string();
    let seed = variable("FMI2_SEED", SEED);
    let parts = [seed, seed + 1000].map(|seed| seed.to_string());
    let random = parts.iter().map(|seed| test("random_calls", &[("FMI2_CALLS", &calls), ("FMI2_SEED", seed)]));
    let others = TESTS.iter().filter(|name| **name != "random_calls").map(|name| test(name, &[("FMI2_BLOBS", "300")]));
    run(random.chain(others).collect());
}

#[test]
#[ignore = "needs a nightly toolchain, and compiles everything: see the top of this file"]
fn all_calls_under_address_sanitizer() {
    if !works("cargo", &["+nightly", "--version"]) {
        println!("NOT CHECKED: memory errors on the stack; there is no nightly toolchain");
        return;
    }
    let host = Command::new("rustc").args(["+nightly", "--print", "host-tuple"]).output().unwrap();
    let host = String::from_utf8(host.stdout).unwrap();
    let target = ["--target", host.trim(), "--target-dir", concat!(env!("CARGO_TARGET_TMPDIR"), "/sanitizer")];
    let tests = TESTS.iter().flat_map(|test| ["--test", test]);
    // The real FMUs are not compiled with it: of what they do, it sees the heap.
    let real = std::env::join_paths(libraries()).unwrap().into_string().unwrap();
    let variables =
        [("RUSTFLAGS", "-Zsanitizer=address -Clink-arg=-Wl,--export-dynamic"), ("FMU_LIBRARIES", real.as_str())];
    for command in [
        vec!["+nightly", "build", "--release", "--examples"],
        ["+nightly", "test", "--release"].into_iter().chain(tests).collect(),
    ] {
        let arguments: Vec<&str> = command.into_iter().chain(target).collect();
        run(vec![cargo(&arguments, &variables)]);
    }
}

/// What is run under these tools.
const TESTS: [&str; 5] = ["state_table", "misuse", "failures", "blobs", "random_calls"];
