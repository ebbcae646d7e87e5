//! Serialised states that somebody has tampered with *and* given a right checksum: refused, or an instance that works.
//!
//! Mutations are the same at every run; `FMI2_BLOBS` changes their number.

mod common;

use std::ffi::{c_char, c_int};
use std::path::Path;
use std::ptr::null;

use common::misbehaving::{FAULT, Fault, LIMITED, State, bring};
use common::real::{EXAMPLES, count, libraries, reals};
use common::{DISCARD, ERROR, Fmu, OK, Slave, example};

const HEADER: usize = 58;

/// `SplitMix64`.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        usize::try_from((z ^ (z >> 31)) % n as u64).unwrap()
    }
}

/// Puts the right length and checksum to a changed payload.
fn seal(blob: &mut Vec<u8>) {
    let length = (blob.len() - HEADER) as u64;
    blob[HEADER - 8..HEADER].copy_from_slice(&length.to_le_bytes());
    let checksum = crc32fast::hash(blob);
    blob.extend_from_slice(&checksum.to_le_bytes());
}

fn mutate(original: &[u8], random: &mut Random) -> Vec<u8> {
    let mut blob = original[..original.len() - 4].to_vec();
    for _ in 0..=random.below(3) {
        let n = blob.len() - HEADER;
        if n == 0 {
            break;
        }
        let at = HEADER + random.below(n);
        match random.below(9) {
            0 | 1 => blob[at] ^= 1 << random.below(8),
            2 => blob[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5)],
            3 => blob.truncate(at),
            4 => blob.insert(at, 0xff),
            5 => _ = blob.remove(at),
            // A length of nearly 2^64 in the encoding of integers.
            6 => blob.splice(at..at, [0xff; 9].into_iter().chain([1])).for_each(drop),
            // An unusual number, where there may be one.
            7 if n >= 8 => {
                let at = HEADER + random.below(n - 7);
                let value = [f64::NAN, f64::INFINITY, -f64::MAX, 1e300, 5e-324, -0.0, -1.0][random.below(7)];
                blob[at..at + 8].copy_from_slice(&value.to_le_bytes());
            }
            _ => {
                let from = HEADER + random.below(n);
                let length = random.below(16).min(HEADER + n - at).min(HEADER + n - from);
                blob.copy_within(from..from + length, at);
            }
        }
    }
    seal(&mut blob);
    blob
}

/// Makes an instance do everything there is; whatever it answers, it answers. If it could be stepped, whether all real
/// variables are finite then.
fn exercise(slave: &Slave, reals: u32) -> Option<bool> {
    let (fmu, c) = (slave.fmu, slave.component);
    let good = |status: c_int| {
        assert!((OK..=ERROR).contains(&status));
        status == OK
    };
    let (mut time, mut finite) = (0.0, true);
    good(fmu.fmi2GetRealStatus(c, 2, &mut time));
    let stepped = good(slave.step(time, 1e-3));
    for vr in 0..reals {
        let (mut real, mut integer, mut text) = (0.0, 0, null::<c_char>());
        good(fmu.fmi2GetReal(c, &vr, 1, &mut real));
        finite &= real.is_finite();
        good(fmu.fmi2GetInteger(c, &vr, 1, &mut integer));
        good(fmu.fmi2GetBoolean(c, &vr, 1, &mut integer));
        if good(fmu.fmi2GetString(c, &vr, 1, &mut text)) {
            // SAFETY: just returned.
            assert!(unsafe { std::ffi::CStr::from_ptr(text) }.to_str().is_ok());
        }
    }
    good(slave.step(time + 1e-3, 1e-3));
    good(fmu.fmi2EnterInitializationMode(c));
    good(fmu.fmi2ExitInitializationMode(c));
    good(fmu.fmi2Terminate(c));
    stepped.then_some(finite)
}

/// No further arenas for the threads of other tests: each reserves 64 MiB, which [`peak_memory`] would count as this test's.
fn keep_to_one_arena() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const M_ARENA_MAX: std::ffi::c_int = -8;
        unsafe extern "C" {
            fn mallopt(parameter: std::ffi::c_int, value: std::ffi::c_int) -> std::ffi::c_int;
        }
        // SAFETY: glibc's own function with one of its parameters; it takes its own lock.
        unsafe { mallopt(M_ARENA_MAX, 1) };
    }
}

/// Whether this process's memory is valgrind's, too: what it translates and what it keeps of freed blocks grows with every call.
/// The same states are counted without it.
fn runs_under_valgrind() -> bool {
    std::fs::read_to_string("/proc/self/maps").is_ok_and(|maps| maps.contains("vgpreload_"))
}

/// The most memory this process has ever had, in KiB.
fn peak_memory() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:"));
    line.map_or(0, |line| line.trim().trim_end_matches(" kB").parse().unwrap())
}

/// Mutates the states that a model can be saved in.
fn attack(path: &Path, mutations: usize) {
    let number = std::env::var("FMI2_BLOBS").ok().and_then(|n| n.parse().ok()).unwrap_or(mutations);
    let fmu = Fmu::open(path);
    for (model, guid) in fmu.guids().iter().enumerate() {
        let slave = fmu.instantiate(guid);
        let counts = count(&fmu, guid);
        let mut originals = vec![slave.blob()];
        slave.initialize();
        assert_eq!(slave.step(0.0, 1e-3), OK);
        reals(&slave, counts);
        originals.push(slave.blob());
        let size = originals[1].len();
        let mut random = Random(model as u64);
        let (mut accepted, mut stepped, mut panicked, mut not_finite) = (0, 0, 0, 0);
        let peak = peak_memory();
        for _ in 0..number {
            let blob = mutate(&originals[random.below(2)], &mut random);
            slave.log.lock().unwrap().clear();
            if slave.load(&blob) != OK {
                continue;
            }
            accepted += 1;
            let good = exercise(&slave, counts.reals);
            stepped += usize::from(good.is_some());
            not_finite += usize::from(good == Some(false));
            panicked += usize::from(slave.messages().iter().any(|m| m.2.starts_with("internal error")));
        }
        println!(
            "{} {model}: of {number} states of {size} bytes, {accepted} accepted, {stepped} could be stepped, \
             {not_finite} to something infinite, {panicked} led to a panic",
            path.file_name().unwrap().display()
        );
        let grown = if runs_under_valgrind() { 0 } else { peak_memory() - peak };
        assert!(grown < 50_000, "a state of {size} bytes made it ask for {grown} KiB");
        slave.start_again();
    }
}

#[test]
fn states_with_a_forged_checksum_are_refused_or_work() {
    keep_to_one_arena();
    for name in EXAMPLES {
        attack(&example(name), 20_000);
    }
    for path in libraries() {
        attack(&path, 2_000);
    }
}

/// Serialised state of the example `misbehaving`, with something in it replaced.
fn forged(fmu: &Fmu, state: State, from: &[u8], to: &[u8]) -> Vec<u8> {
    let slave = bring(fmu, &fmu.guids()[0], state);
    assert_eq!(slave.set(LIMITED, 0.53125), OK);
    let slope = 0.28125;
    assert_eq!(fmu.fmi2SetRealInputDerivatives(slave.component, &LIMITED, 1, &1, &slope), OK);
    let blob = slave.blob();
    let at = blob.windows(from.len()).position(|window| window == from).expect("what to replace is in the blob");
    let mut forged = [&blob[..at], to, &blob[at + from.len()..blob.len() - 4]].concat();
    seal(&mut forged);
    forged
}

/// Was: accepted, and then in the model.
#[test]
fn forged_values_that_the_host_could_not_have_set_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = bring(&fmu, &fmu.guids()[0], State::StepComplete);
    let before = slave.blob();
    let value = |value: f64| value.to_le_bytes();
    for (from, to, says) in [
        (value(0.53125), value(f64::NAN), "real.limited cannot be NaN"),
        (value(0.53125), value(1.5), "real.limited cannot be 1.5: it must be between -1.0 and 1.0"),
        (value(0.28125), value(f64::INFINITY), "the slope of real.limited is inf"),
        (value(0.5), value(f64::NAN), "its time is not finite"),
    ] {
        assert_eq!(slave.load(&forged(&fmu, State::StepComplete, &from, &to)), ERROR, "{says}");
        assert!(slave.message().contains(says), "{}", slave.message());
        assert_eq!(slave.blob(), before);
    }
    // An initialized slave that was never set up: byte 0 is the phase, byte 1 says that there is an experiment.
    let blob = forged(&fmu, State::StepComplete, &[2, 1], &[2, 0]);
    assert_eq!(slave.load(&blob), ERROR);
    assert!(slave.message().starts_with("the state cannot be used"), "{}", slave.message());
}

/// Was: the slope stayed for ever, as the flag that there is one was not set.
#[test]
fn a_forged_slope_lasts_for_one_step_as_any_other() {
    let fmu = Fmu::load("misbehaving");
    let slave = bring(&fmu, &fmu.guids()[0], State::StepComplete);
    let blob = slave.blob();
    assert_eq!(fmu.fmi2SetRealInputDerivatives(slave.component, &LIMITED, 1, &1, &0.28125), OK);
    let with_slope = slave.blob();
    // They differ in the flag and in the slope; take the slope only.
    let flag = (0..blob.len() - 4).find(|i| blob[*i] != with_slope[*i]).unwrap();
    let mut forged = with_slope[..with_slope.len() - 4].to_vec();
    assert_eq!((blob[flag], forged[flag]), (0, 1));
    forged[flag] = 0;
    seal(&mut forged);
    assert_eq!(slave.load(&forged), OK, "{:?}", slave.log);
    assert_eq!(slave.step(0.5, 1.0), OK);
    assert_eq!(slave.get(LIMITED), 0.28125);
    assert_eq!(slave.step(1.5, 1.0), OK);
    assert_eq!(slave.get(LIMITED), 0.28125);
}

/// Was: the outputs read before saving made a difference to the bytes.
#[test]
fn a_restored_state_serialises_to_the_bytes_it_was_read_from() {
    let fmu = Fmu::load("misbehaving");
    let slave = bring(&fmu, &fmu.guids()[0], State::StepComplete);
    slave.get(common::misbehaving::OUTPUT);
    let blob = slave.blob();
    let other = fmu.instantiate(&fmu.guids()[0]);
    assert_eq!(other.load(&blob), OK);
    assert_eq!(other.blob(), blob);
}

#[test]
fn a_state_saved_amid_a_fault_keeps_it() {
    let fmu = Fmu::load("misbehaving");
    let slave = bring(&fmu, &fmu.guids()[0], State::StepComplete);
    assert_eq!(slave.set_integer(FAULT, Fault::StepDiscards as i32), OK);
    let blob = slave.blob();
    slave.start_again();
    assert_eq!(slave.load(&blob), OK);
    assert_eq!(slave.step(0.5, 0.5), DISCARD);
}
