//! The fuzz targets in `fuzz/`, run for a minute in total by libFuzzer if it is installed. With their seeds, as plain Rust,
//! they are part of the Rust tests.

use std::process::Command;

use crate::steps::{Outcome, run};
use crate::tree::{Tree, works};

/// The targets, and how long each is run, in s.
const TARGETS: [&str; 3] = ["description", "ssp", "state"];
const SECONDS: u32 = 20;

/// Runs each target with libFuzzer.
pub fn run_targets(tree: &Tree) -> Outcome {
    for (what, arguments) in [("a nightly toolchain", ["+nightly", "--version"]), ("cargo-fuzz", ["fuzz", "--version"])]
    {
        if !works(rustup_cargo(tree, &arguments)) {
            return Outcome::Skipped(format!("{what} is not installed (see fuzz/README.md)"));
        }
    }
    for target in TARGETS {
        let time = format!("-max_total_time={SECONDS}");
        let arguments = ["+nightly", "fuzz", "run", "--fuzz-dir", "fuzz", target, "--", &time];
        let mut command = rustup_cargo(tree, &arguments);
        command.env("CARGO_TARGET_DIR", tree.target.join("fuzz"));
        let outcome = run(command);
        if outcome != Outcome::Passed {
            return outcome;
        }
    }
    Outcome::Passed
}

/// The cargo of the PATH, which supports `+nightly`, without the environment variables that our own cargo sets for its
/// children.
fn rustup_cargo(tree: &Tree, arguments: &[&str]) -> Command {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(&tree.root);
    for name in ["CARGO", "RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN"] {
        command.env_remove(name);
    }
    command
}
