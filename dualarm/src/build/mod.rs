//! Builds the model crates and turns them into `.fmu` files.
//!
//! Each model crate has a program of its own name that knows how to package its library
//! (`plant-fmu --library <library> --out <folder>`). Cargo's build messages say where both were built. [`crosscheck`] lays the
//! FMUs out with reference solutions.

pub mod crosscheck;

use std::ffi::{OsStr, OsString};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use serde_json::Value;

use fmi2_import::{Fmu, FmuError};

/// The crates that become FMUs.
pub const MODELS: &[&str] = &["plant-fmu", "controller-fmu", "instruments-fmu"];

/// Why packaging failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PackageError {
    /// The sources are not where they were at build time.
    #[error(
        "the sources of the FMUs are not at {} any more; run `cargo run --release -- package` in their repository, or \
         name existing .fmu files (`dualarm simulate --help`)",
        root.display()
    )]
    NoSources {
        /// Where they should be.
        root: PathBuf,
    },
    /// A program cannot be started.
    #[error("cannot run {program}: {source}")]
    Start {
        /// The program.
        program: String,
        /// Why.
        source: io::Error,
    },
    /// The build failed; cargo has said why.
    #[error("building the FMUs failed ({0}); see cargo's messages above")]
    Build(ExitStatus),
    /// Cargo did not mention a file.
    #[error("cargo built no {what} for {model}")]
    NotBuilt {
        /// The crate.
        model: String,
        /// What is missing.
        what: &'static str,
    },
    /// A model's packaging program failed.
    #[error("packaging {model} failed: {message}")]
    Packager {
        /// The crate.
        model: String,
        /// What the program says.
        message: String,
    },
    /// The result is no FMU.
    #[error("packaging went wrong: {0}")]
    Unusable(#[from] FmuError),
    /// The folder cannot be written to.
    #[error("cannot write to {}: {source}", folder.display())]
    Write {
        /// The folder.
        folder: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// Files that cargo built for one crate.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Built {
    model: String,
    library: PathBuf,
    program: PathBuf,
}

/// The repository this tool was built from.
#[must_use]
pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// Builds the models in the repository at `root` and writes their `.fmu` files to `out`, one after the other: whoever has
/// others there wants a new folder. `quiet` keeps cargo silent unless something fails; `progress` hears what is being done.
///
/// # Errors
/// When a build or packaging step fails.
pub fn package(
    root: &Path,
    out: &Path,
    quiet: bool,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<PathBuf>, PackageError> {
    if !MODELS.iter().all(|model| root.join(model).join("Cargo.toml").is_file()) {
        return Err(PackageError::NoSources { root: root.to_owned() });
    }
    progress("building the FMU libraries");
    let built = build(root, quiet)?;

    let write = |source| PackageError::Write { folder: out.to_owned(), source };
    fs::create_dir_all(out).map_err(write)?;
    for Built { model, library, program } in &built {
        progress(&format!("packaging {model}"));
        let arguments = [OsStr::new("--library"), library.as_os_str(), OsStr::new("--out"), out.as_os_str()];
        run(&root.join(model), program, &arguments)?;
    }

    let mut fmus = Vec::new();
    for entry in fs::read_dir(out).map_err(write)? {
        let path = entry.map_err(write)?.path();
        if path.extension().is_some_and(|extension| extension == "fmu") {
            Fmu::read_description(&path)?;
            fmus.push(path);
        }
    }
    fmus.sort();
    Ok(fmus)
}

/// The programs with the profile of this tool, which has compiled most of what they need (selecting the whole workspace gives
/// dependencies the features they have there); then, with the GUIDs that these say, the libraries with the profile `fmu` and
/// without what packaging needs.
fn build(root: &Path, quiet: bool) -> Result<Vec<Built>, PackageError> {
    let mut libraries = vec!["--profile", "fmu", "--lib"];
    let mut programs = vec!["--release", "--workspace"];
    let features: Vec<String> = MODELS.iter().map(|model| format!("{model}/package")).collect();
    for (model, feature) in MODELS.iter().zip(&features) {
        libraries.extend(["--package", *model]);
        programs.extend(["--bin", *model, "--features", feature.as_str()]);
    }
    let messages = cargo_build(root, quiet, &programs, "")?;
    let programs: Vec<PathBuf> =
        MODELS.iter().map(|model| find_program(&messages, model)).collect::<Result<_, PackageError>>()?;
    let mut guids = Vec::new();
    for (model, program) in MODELS.iter().zip(&programs) {
        guids.push(run(&root.join(model), program, &[OsStr::new("--guids")])?);
    }
    let messages = cargo_build(root, quiet, &libraries, &guids.join(";"))?;
    let built = MODELS.iter().zip(programs).map(|(model, program)| {
        Ok(Built { model: (*model).to_owned(), library: find_library(&messages, model)?, program })
    });
    built.collect()
}

/// Runs a model's packaging program, with what `cargo run` would tell it of its crate; what it prints.
fn run(home: &Path, program: &Path, arguments: &[&OsStr]) -> Result<String, PackageError> {
    let output = Command::new(program)
        .args(arguments)
        .env("CARGO", cargo())
        .env("CARGO_MANIFEST_DIR", home)
        .stdin(Stdio::null())
        .output()
        .map_err(|source| PackageError::Start { program: program.display().to_string(), source })?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        let message = if message.is_empty() { output.status.to_string() } else { message };
        let model = home.file_name().unwrap_or_default().to_string_lossy().into_owned();
        return Err(PackageError::Packager { model, message });
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn cargo() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"))
}

/// Runs `cargo build`; its messages, one JSON object per line.
fn cargo_build(root: &Path, quiet: bool, arguments: &[&str], guids: &str) -> Result<String, PackageError> {
    let cargo = cargo();
    let mut command = Command::new(&cargo);
    command.current_dir(root).args(["build", "--message-format=json-render-diagnostics"]).args(arguments);
    if !guids.is_empty() {
        // Compiled into the libraries: which descriptions they belong to.
        command.env("FMI2_EXPORT_GUIDS", guids);
    }
    if quiet {
        command.arg("--quiet");
    }
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|source| PackageError::Start { program: cargo.to_string_lossy().into_owned(), source })?;
    if !output.status.success() {
        return Err(PackageError::Build(output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// What cargo says it has built for a crate, in its messages, one JSON object per line.
fn artifacts(messages: &str, model: &str, kind: &str) -> Vec<Value> {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .filter(|message: &Value| {
            let target = &message["target"];
            message["reason"] == "compiler-artifact"
                && target["name"].as_str().is_some_and(|name| name.replace('_', "-") == model)
                && target["kind"].as_array().is_some_and(|kinds| kinds.iter().any(|found| found == kind))
        })
        .collect()
}

fn find_library(messages: &str, model: &str) -> Result<PathBuf, PackageError> {
    artifacts(messages, model, "cdylib")
        .iter()
        .flat_map(|artifact| artifact["filenames"].as_array().into_iter().flatten())
        .filter_map(Value::as_str)
        .find(|name| name.ends_with(std::env::consts::DLL_SUFFIX))
        .map(PathBuf::from)
        .ok_or_else(|| PackageError::NotBuilt { model: model.to_owned(), what: "shared library" })
}

fn find_program(messages: &str, model: &str) -> Result<PathBuf, PackageError> {
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
        let suffix = std::env::consts::DLL_SUFFIX;
        let messages = format!(
            r#"{{"reason":"compiler-artifact","target":{{"kind":["lib"],"name":"serde"}},"filenames":["libserde.rlib"],"executable":null}}
not json
{{"reason":"compiler-artifact","target":{{"kind":["cdylib","rlib"],"name":"plant_fmu"}},"filenames":["t/libplant_fmu.rlib","t/libplant_fmu{suffix}"],"executable":null}}
{{"reason":"compiler-artifact","target":{{"kind":["bin"],"name":"plant-fmu"}},"filenames":["t/plant-fmu"],"executable":"t/plant-fmu"}}
{{"reason":"build-finished","success":true}}"#
        );
        let library = PathBuf::from(format!("t/libplant_fmu{suffix}"));
        assert_eq!(find_library(&messages, "plant-fmu").unwrap(), library);
        assert_eq!(find_program(&messages, "plant-fmu").unwrap(), Path::new("t/plant-fmu"));
        let message = find_library(&messages, "controller-fmu").unwrap_err().to_string();
        assert_eq!(message, "cargo built no shared library for controller-fmu");
    }

    #[test]
    fn missing_sources_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = package(folder.path(), &folder.path().join("dist"), true, &mut |_| ()).unwrap_err().to_string();
        assert!(error.contains("are not at") && !folder.path().join("dist").exists(), "{error}");
    }
}
