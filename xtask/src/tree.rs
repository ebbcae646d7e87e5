//! Where the workspace and its build directory are, and the cargo that runs us.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::steps::{Outcome, run};

/// Where things are.
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
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.args(args).current_dir(&self.root);
        command
    }

    /// Runs the cargo subcommand of an optional toolchain component, or says that it is absent.
    pub fn cargo_component(&self, subcommand: &str, component: &str, args: &[&str]) -> Outcome {
        if !works(self.cargo(&[subcommand, "--version"])) {
            return Outcome::Skipped(format!("{component} is not installed (`rustup component add {component}`)"));
        }
        let mut command = self.cargo(&[subcommand]);
        command.args(args);
        run(command)
    }
}

/// Whether a command starts and succeeds.
pub fn works(mut command: Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}
