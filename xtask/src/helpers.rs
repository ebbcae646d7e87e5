//! Builds everything that the Python tests need from cargo before they run, so that no test waits for a compiler.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::python;
use crate::steps::{Outcome, run};
use crate::tree::Tree;

/// The crate that the tests make from the template; its name gives the model's, `WaterHeater`.
const FROM_TEMPLATE: &str = "water-heater";

/// Builds what comes from our own crates, into `<build directory>/helpers`. The FMUs must have been packaged.
pub fn build(tree: &Tree) -> Outcome {
    let folder = tree.target.join("helpers");
    if let Err(error) = fs::create_dir_all(&folder) {
        return Outcome::Failed(format!("cannot create {}: {error}", folder.display()));
    }
    for make in [example, from_template] {
        let outcome = make(tree, &folder);
        if outcome != Outcome::Passed {
            return outcome;
        }
    }
    Outcome::Passed
}

/// The FMU of the Rust example.
fn example(tree: &Tree, folder: &Path) -> Outcome {
    tree.run_packager("examples/hub-friction", &[OsStr::new("--out"), folder.as_os_str()])
}

/// The crate of a new user: made from the template, its FMU packaged, its tests compiled.
fn from_template(tree: &Tree, folder: &Path) -> Outcome {
    let path = folder.join(FROM_TEMPLATE);
    if path.exists()
        && let Err(error) = fs::remove_dir_all(&path)
    {
        return Outcome::Failed(format!("cannot remove {}: {error}", path.display()));
    }
    if let Err(reason) = cargo_fmi2::new::create(&path, None) {
        return Outcome::Failed(reason);
    }
    // The versions of the workspace: they are downloaded already, so no network is needed.
    if let Err(error) = fs::copy(tree.root.join("Cargo.lock"), path.join("Cargo.lock")) {
        return Outcome::Failed(format!("cannot copy Cargo.lock: {error}"));
    }
    let built = run(tree.cargo_all("build", &["--bin", "cargo-fmi2"]));
    if built != Outcome::Passed {
        return built;
    }
    let mut package = Command::new(tree.program("cargo-fmi2"));
    package.args(["fmi2", "package"]);
    for mut command in [package, tree.cargo(&["test", "--release", "--no-run"])] {
        command
            .current_dir(&path)
            .env("CARGO_TARGET_DIR", tree.target.join("template"))
            .env("CARGO_NET_OFFLINE", "true");
        // The tests do not look at how well the compiler optimises, so it may compile fast.
        for profile in ["RELEASE", "FMU"] {
            command.env(format!("CARGO_PROFILE_{profile}_OPT_LEVEL"), "0");
            command.env(format!("CARGO_PROFILE_{profile}_LTO"), "off");
        }
        let outcome = run(command);
        if outcome != Outcome::Passed {
            return outcome;
        }
    }
    Outcome::Passed
}

/// The importer of rust-fmi, into `<build directory>/judges`; it needs the Python environment. If it cannot be built here, a
/// message says so, and the tests that need it are skipped.
pub fn judge(tree: &Tree) -> Outcome {
    run(python::command(tree, &["-m", "tests.judges.rust_fmi"]))
}
