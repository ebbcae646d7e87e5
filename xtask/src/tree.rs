//! Where the workspace and its build directory are, and the cargo that runs us.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::compiler;
use crate::steps::{Outcome, run};

/// Where things are.
#[derive(Clone)]
pub struct Tree {
    /// The workspace.
    pub root: PathBuf,
    /// The build directory.
    pub target: PathBuf,
}

impl Tree {
    /// The workspace that this program belongs to.
    pub fn find() -> Self {
        // cargo sets CARGO_MANIFEST_DIR when it runs us; the compile-time value serves a directly started binary.
        let manifest = std::env::var_os("CARGO_MANIFEST_DIR")
            .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
        let root = manifest.parent().unwrap_or(Path::new(".")).to_path_buf();
        let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |dir| root.join(dir));
        Self { root, target }
    }

    /// `cargo <args>` in the workspace root, with the cargo that runs us.
    pub fn cargo(&self, args: &[&str]) -> Command {
        let mut command = Command::new(cargo());
        command.args(args).current_dir(&self.root);
        command
    }

    /// `cargo <subcommand>` of the whole workspace, like every build of `cargo xtask test`. With other crates or features,
    /// cargo would give dependencies other features, and compile them and their dependents again.
    pub fn cargo_all(&self, subcommand: &str, args: &[&str]) -> Command {
        let mut command = self.cargo(&[subcommand, "--release", "--workspace", "--all-features"]);
        if subcommand == "test" {
            compiler::wrap(&mut command);
        }
        command.args(args);
        command
    }

    /// Builds the packaging program of the crate in `folder`, and runs it in the root of the workspace.
    pub fn run_packager(&self, folder: &str, arguments: &[&OsStr]) -> Outcome {
        let name = folder.rsplit('/').next().unwrap_or(folder);
        let built = run(self.cargo_all("build", &["--quiet", "--bin", name]));
        if built != Outcome::Passed {
            return built;
        }
        let mut command = Command::new(self.program(name));
        // The variable that `cargo run` would set.
        let manifest = self.root.join(folder);
        command.args(arguments).current_dir(&self.root).env("CARGO", cargo()).env("CARGO_MANIFEST_DIR", manifest);
        run(command)
    }

    /// The file of a program that cargo has built.
    pub fn program(&self, name: &str) -> PathBuf {
        self.target.join("release").join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
    }

    /// Runs the cargo subcommand of an optional toolchain component, or reports that it is missing.
    pub fn cargo_component(&self, subcommand: &str, component: &str, args: &[&str]) -> Outcome {
        if !works(self.cargo(&[subcommand, "--version"])) {
            return Outcome::Skipped(format!("{component} is not installed (`rustup component add {component}`)"));
        }
        let mut command = self.cargo(&[subcommand]);
        command.args(args);
        run(command)
    }
}

/// The cargo that runs us.
pub fn cargo() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Whether a command starts and succeeds.
pub fn works(mut command: Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}
