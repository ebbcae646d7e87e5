//! Tests that take minutes and are therefore not part of `cargo test`: a million random calls and the hostile ones under
//! valgrind (skipped with a message if it is missing), thousands of load cycles of the real FMUs, ten million steps.

use crate::steps::{Outcome, run_together};
use crate::tree::Tree;

/// Test file, and a part of the name of the tests that are meant (all that are ignored otherwise).
const TESTS: [(&str, &str); 3] = [("random_calls", "all_calls_under_valgrind"), ("loading", ""), ("conservation", "")];

/// Runs all of them, side by side: each is a process of its own that uses one processor.
pub fn checks(tree: &Tree) -> Outcome {
    run_together(
        TESTS.map(|(test, name)| tree.cargo_all("test", &["--test", test, "--", "--ignored", "--nocapture", name])),
    )
}
