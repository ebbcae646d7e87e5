//! Asks cargo about the crate whose packaging program runs, and builds its library.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::platform::Platform;

/// The profile for libraries, if the workspace has it.
const PROFILE: &str = "fmu";

/// Why the library could not be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The program was not started by `cargo run`.
    #[error("run this with `cargo fmi2 package` or `cargo run`, or say --library FILE: {0} is not set")]
    NoCargo(&'static str),
    /// Cargo could not be started.
    #[error("cannot run {program}: {source}")]
    Start {
        /// The program that was started.
        program: String,
        /// Why it could not be started.
        source: std::io::Error,
    },
    /// Cargo failed and printed the reason to standard error.
    #[error("cargo could not build the library for {0}")]
    Failed(&'static str),
    /// Cargo does not know the crate.
    #[error("cargo metadata: {0}")]
    Metadata(String),
    /// The crate has no such library.
    #[error("the crate's library is not a cdylib: say crate-type = [\"cdylib\", \"rlib\"] under [lib] in Cargo.toml")]
    NoLibrary,
}

/// The crate whose packaging program runs.
pub struct Crate {
    cargo: String,
    manifest: PathBuf,
}

impl Crate {
    /// The crate that `cargo run` names.
    pub fn find() -> Result<Self, BuildError> {
        let variable = |name| std::env::var(name).map_err(|_| BuildError::NoCargo(name));
        let manifest = PathBuf::from(variable("CARGO_MANIFEST_DIR")?).join("Cargo.toml");
        Ok(Self { cargo: variable("CARGO")?, manifest })
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.cargo);
        command.args(arguments).arg("--manifest-path").arg(&self.manifest);
        command
    }

    fn start(&self, source: std::io::Error) -> BuildError {
        BuildError::Start { program: self.cargo.clone(), source }
    }

    /// The licences of the crates that are linked into the library.
    pub fn licenses(&self) -> Result<String, BuildError> {
        let platform = Platform::here().map_or_else(Vec::new, |platform| vec!["--filter-platform", platform.target]);
        let metadata = self.metadata(&platform)?;
        let packages = metadata["packages"].as_array().into_iter().flatten();
        let own = packages
            .filter(|package| package["manifest_path"].as_str().is_some_and(|path| Path::new(path) == self.manifest))
            .find_map(|package| package["id"].as_str());
        let own = own.ok_or_else(|| BuildError::Metadata(format!("no crate {}", self.manifest.display())))?;
        Ok(crate::licenses::text(&metadata, own))
    }

    fn metadata(&self, arguments: &[&str]) -> Result<Value, BuildError> {
        let mut command = self.command(&["metadata", "--format-version", "1"]);
        let output = command.args(arguments).output().map_err(|source| self.start(source))?;
        if !output.status.success() {
            return Err(BuildError::Metadata(String::from_utf8_lossy(&output.stderr).trim().to_owned()));
        }
        serde_json::from_slice(&output.stdout).map_err(|error| BuildError::Metadata(error.to_string()))
    }

    /// The profile for the library: `fmu` if the workspace has one, otherwise `release`.
    fn profile(&self) -> Result<&'static str, BuildError> {
        let metadata = self.metadata(&["--no-deps"])?;
        let root = Path::new(metadata["workspace_root"].as_str().unwrap_or_default()).join("Cargo.toml");
        let text = std::fs::read_to_string(root).unwrap_or_default();
        Ok(if has_table(&text, &format!("profile.{PROFILE}")) { PROFILE } else { "release" })
    }

    /// Builds the library with these GUIDs compiled in and returns its path, which cargo reports.
    pub fn library(&self, platform: &'static Platform, guids: &str) -> Result<PathBuf, BuildError> {
        let mut command = platform.build_library(self.cargo.as_ref());
        command.args(["--profile", self.profile()?, "--message-format=json-render-diagnostics", "--manifest-path"]);
        command.arg(&self.manifest).env(fmi2_export::packaging::VARIABLE, guids);
        let output = command.stderr(Stdio::inherit()).output().map_err(|source| self.start(source))?;
        if !output.status.success() {
            return Err(BuildError::Failed(platform.folder));
        }
        let ours =
            |message: &Value| message["manifest_path"].as_str().is_some_and(|path| Path::new(path) == self.manifest);
        String::from_utf8_lossy(&output.stdout)
            .lines()
            .filter_map(|line| serde_json::from_str::<Value>(line).ok())
            .filter(|message| message["reason"] == "compiler-artifact" && ours(message))
            .flat_map(|message| message["filenames"].as_array().cloned().unwrap_or_default())
            .filter_map(|file| file.as_str().map(PathBuf::from))
            .find(|file| file.extension().is_some_and(|extension| extension == platform.extension()))
            .ok_or(BuildError::NoLibrary)
    }
}

/// Whether a TOML file has a table of this name.
fn has_table(toml: &str, name: &str) -> bool {
    toml.lines().any(|line| line.split('#').next().is_some_and(|line| line.trim() == format!("[{name}]")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_found_whatever_stands_beside_them() {
        let toml = "[profile.release]\n  [profile.fmu]  # fast\nlto = \"fat\"\n";
        assert!(has_table(toml, "profile.fmu"));
        assert!(!has_table("# [profile.fmu]\n[profile.fmus]", "profile.fmu"));
    }
}
