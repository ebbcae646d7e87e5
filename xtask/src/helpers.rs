//! What the Python tests need and cargo builds: made before they run, so that no test waits for a compiler.

use std::fs;
use std::path::{Path, PathBuf};

use crate::steps::{Outcome, run};
use crate::tree::Tree;
use crate::{python, template};

/// The crate that the tests make from the template; its name gives the model's, `WaterHeater`.
const FROM_TEMPLATE: &str = "water-heater";

/// Builds all of it; the results are in `<build directory>/helpers`, the judge in `<build directory>/judges`.
pub fn build(tree: &Tree) -> Outcome {
    let folder = tree.target.join("helpers");
    if let Err(error) = fs::create_dir_all(&folder) {
        return Outcome::Failed(format!("cannot create {}: {error}", folder.display()));
    }
    for make in [example, from_template, judge] {
        let outcome = make(tree, &folder);
        if outcome != Outcome::Passed {
            return outcome;
        }
    }
    Outcome::Passed
}

/// The FMU of the Rust example.
fn example(tree: &Tree, folder: &Path) -> Outcome {
    let arguments = ["run", "--release", "--package", "hub-friction", "--features", "package", "--", "--out"];
    let mut command = tree.cargo(&arguments);
    command.arg(folder);
    run(command)
}

/// A stranger's crate: made from the template, its FMU packaged, its tests compiled.
fn from_template(tree: &Tree, folder: &Path) -> Outcome {
    let path = folder.join(FROM_TEMPLATE);
    if let Err(reason) = fresh_crate(tree, &path) {
        return Outcome::Failed(reason);
    }
    let package: &[&str] = &["run", "--offline", "--release", "--features", "package"];
    for arguments in [package, &["test", "--offline", "--release", "--no-run"]] {
        let mut command = tree.cargo(arguments);
        command.current_dir(&path).env("CARGO_TARGET_DIR", tree.target.join("template"));
        // How well the compiler optimises is not what is tested: compile fast.
        command.envs([("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1"), ("CARGO_PROFILE_RELEASE_LTO", "off")]);
        let outcome = run(command);
        if outcome != Outcome::Passed {
            return outcome;
        }
    }
    Outcome::Passed
}

fn fresh_crate(tree: &Tree, path: &PathBuf) -> Result<(), String> {
    if path.exists() {
        fs::remove_dir_all(path).map_err(|error| format!("cannot remove {}: {error}", path.display()))?;
    }
    template::create(&tree.root, path)?;
    // The versions that the workspace has: they have been fetched, so that nothing is asked of the network.
    fs::copy(tree.root.join("Cargo.lock"), path.join("Cargo.lock"))
        .map(|_| ())
        .map_err(|error| format!("cannot copy Cargo.lock: {error}"))
}

/// The importer of rust-fmi; says so if it cannot be built here, and the tests that need it are skipped.
fn judge(tree: &Tree, _: &Path) -> Outcome {
    run(python::command(tree, &["-m", "tests.judges.rust_fmi"]))
}
