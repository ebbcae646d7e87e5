//! Builds the library of the crate whose packaging program runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

/// The profile that libraries are built with, where the workspace has it.
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
        /// What was run.
        program: String,
        /// Why not.
        source: std::io::Error,
    },
    /// Cargo failed; it has said why on standard error.
    #[error("cargo could not build the library")]
    Failed,
    /// The crate has no such library.
    #[error("the crate's library is no cdylib: say crate-type = [\"cdylib\", \"rlib\"] under [lib] in Cargo.toml")]
    NoLibrary,
}

/// Builds the library and tells where it is: with the profile `fmu` if the workspace has one, otherwise with `release`.
/// Cargo reports the path itself.
pub fn library() -> Result<PathBuf, BuildError> {
    let variable = |name| std::env::var(name).map_err(|_| BuildError::NoCargo(name));
    let cargo = variable("CARGO")?;
    let manifest = PathBuf::from(variable("CARGO_MANIFEST_DIR")?).join("Cargo.toml");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(&cargo);
        command.args(arguments).arg("--manifest-path").arg(&manifest).stderr(Stdio::inherit());
        let output = command.output().map_err(|source| BuildError::Start { program: cargo.clone(), source })?;
        if output.status.success() { Ok(output.stdout) } else { Err(BuildError::Failed) }
    };
    let metadata = run(&["metadata", "--no-deps", "--format-version", "1"])?;
    let metadata: Value = serde_json::from_slice(&metadata).unwrap_or_default();
    let root = Path::new(metadata["workspace_root"].as_str().unwrap_or_default()).join("Cargo.toml");
    let has_profile = std::fs::read_to_string(root).is_ok_and(|text| has_table(&text, &format!("profile.{PROFILE}")));
    let profile = if has_profile { PROFILE } else { "release" };
    let messages = run(&["build", "--lib", "--profile", profile, "--message-format=json-render-diagnostics"])?;
    let same_manifest =
        |message: &Value| message["manifest_path"].as_str().is_some_and(|path| Path::new(path) == manifest);
    String::from_utf8_lossy(&messages)
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .filter(|message| message["reason"] == "compiler-artifact" && same_manifest(message))
        .flat_map(|message| message["filenames"].as_array().cloned().unwrap_or_default())
        .filter_map(|file| file.as_str().map(PathBuf::from))
        .find(|file| file.extension().is_some_and(|e| e == std::env::consts::DLL_EXTENSION))
        .ok_or(BuildError::NoLibrary)
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
