//! Builds the library of the crate whose packaging program runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

/// Why the library could not be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The program was not started by `cargo run`.
    #[error("run this with `cargo run`, or say --library FILE: {0} is not set")]
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

/// Builds the library with `cargo build --release` and tells where it is. Cargo reports the path itself.
pub fn library() -> Result<PathBuf, BuildError> {
    let variable = |name| std::env::var(name).map_err(|_| BuildError::NoCargo(name));
    let cargo = variable("CARGO")?;
    let manifest = PathBuf::from(variable("CARGO_MANIFEST_DIR")?).join("Cargo.toml");
    let output = Command::new(&cargo)
        .args(["build", "--release", "--lib", "--message-format=json-render-diagnostics", "--manifest-path"])
        .arg(&manifest)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|source| BuildError::Start { program: cargo, source })?;
    if !output.status.success() {
        return Err(BuildError::Failed);
    }
    let same_manifest =
        |message: &Value| message["manifest_path"].as_str().is_some_and(|path| Path::new(path) == manifest);
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .filter(|message| message["reason"] == "compiler-artifact" && same_manifest(message))
        .flat_map(|message| message["filenames"].as_array().cloned().unwrap_or_default())
        .filter_map(|file| file.as_str().map(PathBuf::from))
        .find(|file| file.extension().is_some_and(|e| e == std::env::consts::DLL_EXTENSION))
        .ok_or(BuildError::NoLibrary)
}
