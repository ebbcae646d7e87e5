//! The Python environment of the tests: `<build directory>/venv`, made from `tests/requirements.txt`.

use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::output;
use crate::steps::{Outcome, run};
use crate::tree::{Tree, works};

/// Oldest Python that the pinned packages and the tests support.
const OLDEST: (u32, u32) = (3, 9);

/// Makes the environment, or keeps the existing one if it was made from the same requirements by the same Python.
pub fn prepare(tree: &Tree) -> Outcome {
    match try_prepare(tree) {
        Ok(outcome) => outcome,
        Err(reason) => Outcome::Failed(reason),
    }
}

/// The command that runs the Python tests with `args` added.
pub fn pytest(tree: &Tree, args: &[String]) -> Command {
    // All processors are used. One process runs each file, so that fixtures shared by its tests are made once.
    let mut command = command(tree, &["-m", "pytest", "--numprocesses=auto", "--dist=loadfile"]);
    if !args.iter().any(|arg| arg.starts_with("tests/")) {
        command.arg("tests");
    }
    command.args(args);
    // Ourselves, for tests of our commands.
    if let Ok(program) = std::env::current_exe() {
        command.env("XTASK", program);
    }
    command
}

/// `python <args>` of the environment, in the workspace root.
pub fn command(tree: &Tree, args: &[&str]) -> Command {
    let mut command = Command::new(interpreter(tree));
    command.args(args).current_dir(&tree.root);
    command
}

/// A program from a `PyPI` package that is not among the tests' requirements because it may be unavailable; or the reason
/// why it is missing. `version` is the argument that prints its version.
pub fn tool(tree: &Tree, package: &str, program: &str, version: &str) -> Result<Command, String> {
    let installed = || {
        let folder = interpreter(tree).with_file_name(program);
        let mut command = Command::new(if cfg!(windows) { folder.with_extension("exe") } else { folder });
        command.current_dir(&tree.root);
        command
    };
    let version = || {
        let mut command = installed();
        command.arg(version);
        command
    };
    if !works(version()) {
        let arguments = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", package];
        let output = command(tree, &arguments).output().map_err(|error| error.to_string())?;
        if !output.status.success() {
            return Err(format!("`pip install {package}` failed"));
        }
        if !works(version()) {
            return Err(format!("{package} brought no program {program}"));
        }
    }
    Ok(installed())
}

fn try_prepare(tree: &Tree) -> Result<Outcome, String> {
    let file = tree.root.join("tests").join("requirements.txt");
    let requirements =
        fs::read_to_string(&file).map_err(|error| format!("cannot read tests/requirements.txt: {error}"))?;
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| default_python().into());
    let version = version(&python)?;
    let stamp = format!("Python {version}\n{requirements}");
    let stamp_file = tree.venv().join("made-from.txt");

    let up_to_date = fs::read_to_string(&stamp_file).is_ok_and(|old| old == stamp);
    if up_to_date && works(command(tree, &["-c", "import pytest, fmpy"])) {
        output::line(&format!("Python {version}: the environment is up to date"));
        return Ok(Outcome::Passed);
    }

    if tree.venv().exists() {
        fs::remove_dir_all(tree.venv()).map_err(|error| format!("cannot remove the old environment: {error}"))?;
    }
    create(&python, tree)?;
    let mut install = Command::new(interpreter(tree));
    // What is imported compiles itself; all else, compiled, would take half a minute.
    let options = ["--quiet", "--disable-pip-version-check", "--no-compile"];
    install.args(["-m", "pip", "install"]).args(options).args(["-r", "tests/requirements.txt"]);
    install.current_dir(&tree.root);
    let outcome = run(install);
    // The stamp is written last: an interrupted installation is repeated.
    if outcome == Outcome::Passed {
        fs::write(&stamp_file, stamp).map_err(|error| format!("cannot write to the environment: {error}"))?;
    }
    Ok(outcome)
}

/// `python -m venv`, with the usual cause named where it fails.
fn create(python: &OsString, tree: &Tree) -> Result<(), String> {
    let mut command = Command::new(python);
    command.args(["-m", "venv"]).arg(tree.venv());
    if run(command) == Outcome::Passed {
        return Ok(());
    }
    Err(format!(
        "{} could not make a virtual environment; it needs the modules venv and ensurepip \
         (Debian and Ubuntu: install the package python3-venv)",
        python.to_string_lossy()
    ))
}

/// The interpreter's version, or why it can't be used.
fn version(python: &OsString) -> Result<String, String> {
    let name = python.to_string_lossy();
    let script = "import sys; print('%d.%d.%d' % sys.version_info[:3])";
    let output = Command::new(python).args(["-c", script]).output().map_err(|error| {
        format!("cannot run `{name}` ({error}); install Python 3, or set PYTHON to its interpreter")
    })?;
    let version = String::from_utf8_lossy(&output.stdout).trim().to_string();
    let mut numbers = version.split('.').map_while(|part| part.parse::<u32>().ok());
    match (numbers.next(), numbers.next()) {
        (Some(major), Some(minor)) if (major, minor) >= OLDEST => Ok(version),
        (Some(_), Some(_)) => {
            Err(format!("`{name}` is Python {version}; {}.{} or newer is needed", OLDEST.0, OLDEST.1))
        }
        _ => Err(format!("`{name}` did not tell its version; set PYTHON to a Python 3 interpreter")),
    }
}

fn interpreter(tree: &Tree) -> PathBuf {
    if cfg!(windows) { tree.venv().join("Scripts").join("python.exe") } else { tree.venv().join("bin").join("python") }
}

fn default_python() -> &'static str {
    if cfg!(windows) { "python" } else { "python3" }
}

impl Tree {
    fn venv(&self) -> PathBuf {
        self.target.join("venv")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_python_is_explained() {
        let error = version(&"no-such-python".into()).unwrap_err();
        assert!(error.contains("no-such-python") && error.contains("PYTHON"), "{error}");
    }

    #[test]
    fn environment_is_inside_the_build_directory() {
        let tree = Tree { root: "/r".into(), target: "/t".into() };
        assert!(interpreter(&tree).starts_with("/t/venv"));
    }
}
