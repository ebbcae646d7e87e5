//! Tests that take minutes and are therefore left out of `cargo test`: a million random calls and the hostile ones under
//! valgrind (which say so if it is not there), thousands of load cycles of the real FMUs, ten million steps.

use crate::steps::{Outcome, run, run_together};
use crate::tree::Tree;

/// Package, test file, and a part of the name of the tests that are meant (all that are ignored otherwise).
const TESTS: [(&str, &str, &str); 3] = [
    ("fmi2-export", "random_calls", "all_calls_under_valgrind"),
    ("fmi2-export", "loading", ""),
    ("grasp-plant", "conservation", ""),
];

/// Runs all of them, side by side: each is a process of its own that uses one processor.
pub fn checks(tree: &Tree) -> Outcome {
    // Compiled first, so that none of them waits for another one's compiler.
    let build = run(tree.cargo(&["test", "--release", "--no-run", "-p", "fmi2-export", "-p", "grasp-plant"]));
    if build != Outcome::Passed {
        return build;
    }
    run_together(TESTS.map(|(package, test, name)| {
        tree.cargo(&["test", "--release", "-p", package, "--test", test, "--", "--ignored", "--nocapture", name])
    }))
}
