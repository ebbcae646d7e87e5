//! Developer commands of this workspace, started with `cargo xtask`.
//!
//! ```text
//! cargo xtask test     every test there is: Rust, the packaged FMUs, Python, the code checks
//! cargo xtask check    formatting, lints, documentation and workflow files only
//! cargo xtask describe renews modelDescription/
//! cargo xtask new-fmu  a new model crate, by cargo-fmi2
//! cargo xtask published  the crates for crates.io, tested as they are packaged
//! cargo xtask platforms  the FMUs on Windows, ARM and an old Linux, by emulation
//! cargo xtask release  a folder with what a release page offers
//! cargo xtask counts   instructions per communication step, against their history
//! ```
//!
//! Needs a stable Rust toolchain, a C toolchain (linker) and Python 3.9 or newer with `venv`; cargo and pip download
//! everything else.

mod beside;
mod checks;
mod cli;
mod compiler;
mod counts;
mod fuzz;
mod helpers;
mod long;
mod output;
mod packaging;
mod platforms;
mod publish;
mod python;
mod release;
mod steps;
mod test;
mod tree;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;

use cli::{Arguments, Command};
use steps::{Runner, run};
use tree::Tree;

fn main() -> ExitCode {
    if let Some(code) = compiler::called() {
        return code;
    }
    let tree = Tree::find();
    match Arguments::parse().command {
        Command::Test(what) => test::all(&tree, &what),
        Command::Check => check(&tree),
        Command::Describe => describe(&tree),
        Command::NewFmu { path } => new_fmu(&path),
        Command::Published => published(&tree),
        Command::Platforms => other_platforms(&tree),
        Command::Release { out, merge } => make_release(&tree, &out, &merge),
        Command::Counts { record } => counts(&tree, record.as_deref()),
    }
}

/// `cargo xtask check`: the checks that do not run the code.
fn check(tree: &Tree) -> ExitCode {
    let mut steps = Runner::new(1 + checks::COUNT);
    steps.step("Python environment", || python::prepare(tree));
    checks::add(&mut steps, tree, checks::Fetched::start(tree));
    steps.finish()
}

/// `cargo xtask describe`: each model crate's program writes its descriptions, and the tool those of the systems.
fn describe(tree: &Tree) -> ExitCode {
    let mut steps = Runner::new(4);
    for (name, package) in
        [("Plant", "plant-fmu"), ("Controllers", "controller-fmu"), ("Instruments", "instruments-fmu")]
    {
        steps.step(name, || tree.run_packager(package, &[OsStr::new("--describe"), OsStr::new("modelDescription")]));
    }
    steps.step("Systems", || run(tree.cargo(&["run", "--release", "--", "package", "--describe", "modelDescription"])));
    steps.finish()
}

/// `cargo xtask new-fmu`: for authors of other models.
fn new_fmu(path: &Path) -> ExitCode {
    match cargo_fmi2::new::create(path, None) {
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

/// `cargo xtask published`: tests the packages for crates.io.
fn published(tree: &Tree) -> ExitCode {
    let mut steps = Runner::new(1);
    steps.step(publish::STEP, || publish::check(tree));
    steps.finish()
}

/// `cargo xtask platforms`: the additional part of `cargo xtask test --all-platforms`.
fn other_platforms(tree: &Tree) -> ExitCode {
    let mut steps = Runner::new(2 + platforms::COUNT);
    steps.step("Build and package the FMUs", || run(tree.cargo(&["run", "--release", "--", "package"])));
    steps.step("Python environment", || python::prepare(tree));
    platforms::add(&mut steps, tree);
    steps.finish()
}

/// `cargo xtask release`.
fn make_release(tree: &Tree, out: &Path, merged: &[PathBuf]) -> ExitCode {
    let mut steps = Runner::new(release::COUNT);
    release::add(&mut steps, tree, out, merged);
    steps.finish()
}

/// `cargo xtask counts`: the cost of a step, compared with the history or added to it.
fn counts(tree: &Tree, record: Option<&str>) -> ExitCode {
    let mut steps = Runner::new(2);
    steps.step("Build and package the FMUs", || run(tree.cargo(&["run", "--release", "--", "package"])));
    steps.step("Instruction counts", || match record {
        Some(note) => counts::record(tree, note),
        None => counts::check(tree),
    });
    steps.finish()
}
