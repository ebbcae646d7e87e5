//! Runs cargo builds, and finds the built files in cargo's messages.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use super::PackageError;

/// The cargo that runs us, or the usual one.
pub fn program() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"))
}

/// Runs `cargo build`, or the equivalent command for another platform, in the folder `root`. Returns its messages, one JSON
/// object per line.
pub fn build(mut command: Command, root: &Path, quiet: bool) -> Result<String, PackageError> {
    command.current_dir(root).arg("--message-format=json-render-diagnostics");
    if quiet {
        command.arg("--quiet");
    }
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|source| PackageError::Start { program, source })?;
    if !output.status.success() {
        return Err(PackageError::Build(output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The files of a type that cargo has built for a crate, from its messages, one JSON object per line.
fn artifacts(messages: &str, model: &str, crate_type: &str) -> Vec<Value> {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .filter(|message: &Value| {
            let target = &message["target"];
            message["reason"] == "compiler-artifact"
                && target["name"].as_str().is_some_and(|name| name.replace('_', "-") == model)
                && target["crate_types"].as_array().is_some_and(|types| types.iter().any(|found| found == crate_type))
        })
        .collect()
}

/// The shared library of a crate, with this extension.
pub fn find_library(messages: &str, model: &str, extension: &str) -> Result<PathBuf, PackageError> {
    artifacts(messages, model, "cdylib")
        .iter()
        .flat_map(|artifact| artifact["filenames"].as_array().into_iter().flatten())
        .filter_map(Value::as_str)
        .map(PathBuf::from)
        .find(|path| path.extension().is_some_and(|found| found == extension))
        .ok_or_else(|| PackageError::NotBuilt { model: model.to_owned(), what: "shared library" })
}

/// The packaging program of a crate.
pub fn find_program(messages: &str, model: &str) -> Result<PathBuf, PackageError> {
    artifacts(messages, model, "bin")
        .iter()
        .find_map(|artifact| artifact["executable"].as_str())
        .map(PathBuf::from)
        .ok_or_else(|| PackageError::NotBuilt { model: model.to_owned(), what: "packaging program" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_files_are_found_in_cargos_messages() {
        let messages = r#"{"reason":"compiler-artifact","target":{"crate_types":["lib"],"name":"serde"},"filenames":["libserde.rlib"],"executable":null}
not json
{"reason":"compiler-artifact","target":{"kind":["example"],"crate_types":["cdylib"],"name":"plant_fmu"},"filenames":["t/plant_fmu.dll"],"executable":null}
{"reason":"compiler-artifact","target":{"kind":["bin"],"crate_types":["bin"],"name":"plant-fmu"},"filenames":["t/plant-fmu"],"executable":"t/plant-fmu"}
{"reason":"build-finished","success":true}"#;
        assert_eq!(find_library(messages, "plant-fmu", "dll").unwrap(), Path::new("t/plant_fmu.dll"));
        assert_eq!(find_program(messages, "plant-fmu").unwrap(), Path::new("t/plant-fmu"));
        for (model, extension) in [("controller-fmu", "dll"), ("plant-fmu", "so")] {
            let message = find_library(messages, model, extension).unwrap_err().to_string();
            assert_eq!(message, format!("cargo built no shared library for {model}"));
        }
    }
}
