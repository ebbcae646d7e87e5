//! Developer commands of this workspace, started with `cargo xtask`.
//!
//! ```text
//! cargo xtask test     every test there is: Rust, the packaged FMUs, Python, the code checks
//! cargo xtask check    formatting, lints and documentation only
//! cargo xtask describe renews modelDescription/
//! cargo xtask new-fmu  a new model crate from the template of fmi2-export
//! cargo xtask counts   instructions per communication step, against their history
//! ```
//!
//! Needs a stable Rust toolchain, a C toolchain (linker) and Python 3.9 or newer with `venv`; everything else is fetched
//! by cargo and pip. It depends on the standard library only.

mod cli;
mod counts;
mod helpers;
mod python;
mod steps;
mod template;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use cli::{Request, Selection};
use steps::{Outcome, Runner, run};

fn main() -> ExitCode {
    match cli::parse(std::env::args().skip(1)) {
        Ok(Request::Help) => {
            print!("{}", cli::HELP);
            ExitCode::SUCCESS
        }
        Ok(Request::Test { selection, pytest_args }) => test(selection, &pytest_args),
        Ok(Request::Check) => check(),
        Ok(Request::Describe) => describe(),
        Ok(Request::NewFmu { path }) => new_fmu(&path),
        Ok(Request::Counts { record }) => counts(record.as_deref()),
        Err(message) => {
            eprintln!("error: {message}\n\nTry `cargo xtask --help`.");
            ExitCode::from(2)
        }
    }
}

/// `cargo xtask test`: everything, or the Rust or the Python half of it.
fn test(selection: Selection, pytest_args: &[String]) -> ExitCode {
    let tree = Tree::find();
    let mut steps = Runner::new(match selection {
        Selection::All => 11,
        Selection::Rust => 2,
        Selection::Python => 4,
    });
    // First, because the Rust tests attack the FMUs' libraries too; stale ones would be attacked for what is no longer there.
    steps.step("Build and package the FMUs", || run(tree.cargo(&["run", "--release", "--", "package", "--release"])));
    if selection != Selection::Python {
        steps.step("Rust tests", || run(tree.cargo(&["test", "--release", "--workspace", "--all-features"])));
    }
    if selection != Selection::Rust {
        steps.step("Python environment", || python::prepare(&tree));
        steps.step("Helper programs", || helpers::build(&tree));
        steps.step("Python tests", || run(python::pytest(&tree, pytest_args)));
    }
    if selection == Selection::All {
        steps.step("Long checks", || long_checks(&tree));
        steps.step("Instruction counts", || counts::check(&tree));
    }
    // The code checks come last: a lint that a newer clippy brings must not hide what the tests say.
    if selection == Selection::All {
        add_checks(&mut steps, &tree);
    }
    steps.finish()
}

/// Tests that take minutes and are therefore left out of `cargo test`: a million random calls and the hostile ones under
/// valgrind (which say so if it is not there), thousands of load cycles of the real FMUs, ten million steps.
fn long_checks(tree: &Tree) -> Outcome {
    for (package, test, name) in [
        ("fmi2-export", "random_calls", "all_calls_under_valgrind"),
        ("fmi2-export", "loading", ""),
        ("grasp-plant", "conservation", ""),
    ] {
        let outcome = run(tree.cargo(&[
            "test",
            "--release",
            "-p",
            package,
            "--test",
            test,
            "--",
            "--ignored",
            "--nocapture",
            name,
        ]));
        if outcome != Outcome::Passed {
            return outcome;
        }
    }
    Outcome::Passed
}

/// `cargo xtask check`: what can be said of the code without running it.
fn check() -> ExitCode {
    let mut steps = Runner::new(3);
    add_checks(&mut steps, &Tree::find());
    steps.finish()
}

/// `cargo xtask describe`: each model crate's program writes its descriptions, and the tool those of the systems.
fn describe() -> ExitCode {
    let tree = Tree::find();
    let mut steps = Runner::new(3);
    for (name, package) in [("Plant", "plant-fmu"), ("Controllers", "controller-fmu")] {
        steps.step(name, || {
            run(tree.cargo(&[
                "run",
                "--release",
                "--quiet",
                "--package",
                package,
                "--features",
                "package",
                "--",
                "--describe",
                "modelDescription",
            ]))
        });
    }
    steps.step("Systems", || run(tree.cargo(&["run", "--release", "--", "package", "--describe", "modelDescription"])));
    steps.finish()
}

/// `cargo xtask new-fmu`: for those who come with a model of their own.
fn new_fmu(path: &Path) -> ExitCode {
    match template::create(&Tree::find().root, path) {
        Ok(next) => {
            print!("{next}");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// `cargo xtask counts`: what a step costs, compared with the history or added to it.
fn counts(record: Option<&str>) -> ExitCode {
    let tree = Tree::find();
    let mut steps = Runner::new(2);
    steps.step("Build and package the FMUs", || run(tree.cargo(&["run", "--release", "--", "package"])));
    steps.step("Instruction counts", || match record {
        Some(note) => counts::record(&tree, note),
        None => counts::check(&tree),
    });
    steps.finish()
}

fn add_checks(steps: &mut Runner, tree: &Tree) {
    steps.step("Formatting", || tree.cargo_component("fmt", "rustfmt", &["--all", "--check"]));
    steps.step("Lints", || {
        tree.cargo_component(
            "clippy",
            "clippy",
            &["--release", "--workspace", "--all-targets", "--all-features", "--", "-D", "warnings"],
        )
    });
    steps.step("Documentation", || {
        let mut doc = tree.cargo(&["doc", "--release", "--workspace", "--no-deps"]);
        doc.env("RUSTDOCFLAGS", "-D warnings");
        run(doc)
    });
}

/// Where the workspace and its build directory are.
struct Tree {
    root: PathBuf,
    target: PathBuf,
}

impl Tree {
    fn find() -> Self {
        // cargo sets CARGO_MANIFEST_DIR when it runs us; the compile-time value serves a directly started binary.
        let manifest = std::env::var_os("CARGO_MANIFEST_DIR")
            .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
        let root = manifest.parent().unwrap_or(Path::new(".")).to_path_buf();
        let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |dir| root.join(dir));
        Self { root, target }
    }

    /// `cargo <args>` in the workspace root, with the cargo that runs us.
    fn cargo(&self, args: &[&str]) -> Command {
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.args(args).current_dir(&self.root);
        command
    }

    /// Runs the cargo subcommand of an optional toolchain component, or says that it is absent.
    fn cargo_component(&self, subcommand: &str, component: &str, args: &[&str]) -> Outcome {
        let present = self.cargo(&[subcommand, "--version"]).output().is_ok_and(|output| output.status.success());
        if !present {
            return Outcome::Skipped(format!("{component} is not installed (`rustup component add {component}`)"));
        }
        let mut command = self.cargo(&[subcommand]);
        command.args(args);
        run(command)
    }
}
