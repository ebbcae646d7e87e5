//! Tests that take minutes and are therefore not part of `cargo test`: two hundred thousand random calls and the hostile
//! ones under valgrind (skipped with a message if it is missing), thousands of load cycles of the real FMUs, ten million
//! steps.

use crate::packaging;
use crate::steps::{Outcome, run_together};
use crate::tree::Tree;

/// Test program, and a part of the name of the tests that are meant (all that are ignored otherwise).
const TESTS: [(&str, &str); 3] =
    [("random_calls", "all_calls_under_valgrind"), ("loading", ""), ("plant", "ten_million_steps")];

/// Random calls to each of six libraries under valgrind, where they take up to fifty times as long. Among the Rust tests are ten
/// times as many.
const CALLS: &str = "34000";

/// Runs all of them, side by side: each is a process of its own that uses one processor.
pub fn checks(tree: &Tree) -> Outcome {
    run_together(TESTS.map(|(test, name)| {
        let mut command = tree.cargo_all("test", &["--test", test, "--", "--ignored", "--nocapture", name]);
        command.env("FMI2_CALLS", CALLS);
        packaging::attack_libraries(tree, &mut command);
        command
    }))
}
