//! Every target processes the seeds, intact and damaged, on stable Rust, so that the targets work when they are needed and
//! find simple damage. The damage is the same in every run.

use std::fs;
use std::path::{Path, PathBuf};

/// Files of `modelDescription/` with one of these endings.
fn seeds(endings: &[&str]) -> Vec<Vec<u8>> {
    fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { collect(&path, found) } else { found.push(path) }
        }
    }
    let mut found = Vec::new();
    collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../modelDescription"), &mut found);
    found.retain(|path| path.extension().is_some_and(|e| endings.iter().any(|ending| e == *ending)));
    found.sort();
    assert!(!found.is_empty(), "no file ends with {endings:?}");
    found.iter().map(|path| fs::read(path).unwrap()).collect()
}

/// Feeds the seed, and `count` copies of it with one to three bytes changed, a piece removed or a piece doubled.
fn feed(target: fn(&[u8]), seed: &[u8], count: u64) {
    target(seed);
    let mut random = 1u64;
    let mut below = |n: usize| {
        // A linear congruential generator (Knuth's MMIX); its high bits are good enough for damage.
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(random >> 33).unwrap() % n
    };
    for _ in 0..count {
        let mut bytes = seed.to_vec();
        for _ in 0..=below(3) {
            if bytes.is_empty() {
                break;
            }
            let at = below(bytes.len());
            let end = (at + 1 + below(40)).min(bytes.len());
            match below(4) {
                0 => bytes[at] = b"<>\"&/=0 -9\0\xff"[below(12)],
                1 => bytes[at] ^= 1 << below(8),
                2 => drop(bytes.drain(at..end)),
                _ => {
                    let piece = bytes[at..end].to_vec();
                    bytes.splice(at..at, piece);
                }
            }
        }
        target(&bytes);
    }
}

#[test]
fn descriptions() {
    for seed in seeds(&["xml"]) {
        feed(fuzz_targets::description, &seed, 200);
    }
}

#[test]
fn systems_and_parameters() {
    for seed in seeds(&["ssd", "ssv"]) {
        feed(fuzz_targets::ssp, &seed, 100);
    }
}

#[test]
fn states() {
    let blob = fuzz_targets::blob();
    feed(fuzz_targets::state, fuzz_targets::payload(&blob), 5_000);
    feed(fuzz_targets::state, &blob, 5_000);
    feed(fuzz_targets::state, &[], 0);
}
