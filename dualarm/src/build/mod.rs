//! Builds the model crates and turns them into `.fmu` files.
//!
//! Each model crate has a program with the name of the crate that packages its library
//! (`plant-fmu --library <library> --out <folder>`). Cargo's build messages contain the paths of both. [`crosscheck`]
//! writes the release layout of the FMUs with reference solutions. `fmi2_package` defines the platforms and the
//! requirements of their builds, as for any other model.

mod cargo;
pub mod crosscheck;
mod merge;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use fmi2_import::{Fmu, FmuError};
use fmi2_package::platform::Platform;
use fmi2_package::toolchain;

use merge::Merged;

/// The crates of the FMUs.
pub const MODELS: &[&str] = &["plant-fmu", "controller-fmu", "instruments-fmu"];

/// The package whose examples are their shared libraries.
pub const LIBRARIES: &str = "fmu-libraries";

/// Why packaging failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PackageError {
    /// There are no sources to build.
    #[error(
        "the FMUs are built from the folders {} of their repository, which is not around this folder; go there, or take FMUs \
         that exist: --no-package uses those in the folder of --fmus, and `dualarm simulate` runs any",
        MODELS.join(", ")
    )]
    NoSources,
    /// A program cannot be started.
    #[error("cannot run {program}: {source}")]
    Start {
        /// The program.
        program: String,
        /// Why.
        source: io::Error,
    },
    /// The build failed; cargo has printed the reason.
    #[error("building the FMUs failed ({0}); see cargo's messages above")]
    Build(ExitStatus),
    /// Cargo did not mention a file.
    #[error("cargo built no {what} for {model}")]
    NotBuilt {
        /// The crate.
        model: String,
        /// The missing file.
        what: &'static str,
    },
    /// A model's packaging program failed.
    #[error("packaging {model} failed: {message}")]
    Packager {
        /// The crate.
        model: String,
        /// The message of the program.
        message: String,
    },
    /// A platform cannot be built for here.
    #[error("{0}")]
    Platform(String),
    /// An archive cannot be merged.
    #[error("cannot merge {}: {problem}", path.display())]
    Merge {
        /// Which one.
        path: PathBuf,
        /// Why not.
        problem: String,
    },
    /// The result is no FMU.
    #[error("packaging failed: {0}")]
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

/// Which platforms the FMUs shall have libraries for.
#[derive(Clone, Debug, Default)]
pub struct Platforms {
    /// Build exactly for these platforms; if empty, for all whose toolchains are installed.
    pub wanted: Vec<&'static Platform>,
    /// To have in the end.
    pub required: Vec<&'static Platform>,
    /// FMUs that were built elsewhere, or folders of them, whose libraries are added.
    pub merged: Vec<PathBuf>,
}

/// The results of packaging.
#[derive(Clone, Debug)]
pub struct Packaged {
    /// The FMUs, sorted.
    pub fmus: Vec<PathBuf>,
    /// One line on expected platforms that could not be built here, with what to do; `None` if there are none.
    pub left_out: Option<String>,
}

/// The repository around the current folder, or around the manifest that `cargo run` was given. The place where the tool
/// was compiled is never used: it may be deleted, or another version.
#[must_use]
pub fn repository() -> Option<PathBuf> {
    let here = std::env::current_dir().ok();
    let manifest = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let is_repository = |folder: &&Path| MODELS.iter().all(|model| folder.join(model).join("Cargo.toml").is_file());
    [here, manifest].into_iter().flatten().find_map(|start| start.ancestors().find(is_repository).map(Path::to_owned))
}

/// Builds the models in the repository at `root` and writes their `.fmu` files to `out`, one after the other. To replace
/// several files together, use a new folder. The plant has the continuous states of `plant_order`, or of the default order.
/// `quiet` suppresses cargo's output unless something fails; `progress` is called with the present activity.
///
/// # Errors
/// When a build or packaging step fails.
pub fn package(
    root: &Path,
    out: &Path,
    platforms: &Platforms,
    plant_order: Option<u8>,
    quiet: bool,
    progress: &mut dyn FnMut(&str),
) -> Result<Packaged, PackageError> {
    if !MODELS.iter().all(|model| root.join(model).join("Cargo.toml").is_file()) {
        return Err(PackageError::NoSources);
    }
    let merged = Merged::read(&platforms.merged)?;
    progress(&format!("building the FMU libraries of {}", root.display()));
    let crates = programs(root, plant_order, quiet)?;
    let guids: Vec<BTreeMap<String, String>> = crates.iter().map(|one| merge::read_guids(&one.guids)).collect();
    let archives = merge::assign(&merged, &guids)?;
    let is_merged = |platform: &Platform| merge::covers(&merged, &guids, platform);
    let required: Vec<_> = platforms.required.iter().copied().filter(|platform| !is_merged(platform)).collect();
    let (to_build, mut left_out) = toolchain::select(&platforms.wanted, &required).map_err(PackageError::Platform)?;
    left_out.retain(|(platform, _)| !is_merged(platform));
    let libraries = to_build.into_iter().map(|platform| libraries(root, plant_order, quiet, platform, &crates));
    let libraries: Vec<Vec<PathBuf>> = libraries.collect::<Result<_, _>>()?;

    let write = |source| PackageError::Write { folder: out.to_owned(), source };
    fs::create_dir_all(out).map_err(write)?;
    for (index, one) in crates.iter().enumerate() {
        progress(&format!("packaging {}", one.model));
        let mut arguments: Vec<OsString> = vec!["--out".into(), out.into()];
        arguments.extend(libraries.iter().flat_map(|built| ["--library".into(), built[index].clone().into()]));
        arguments.extend(archives[index].iter().flat_map(|path| ["--merge".into(), path.into()]));
        run(&root.join(&one.model), &one.program, &arguments)?;
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
    Ok(Packaged { fmus, left_out: toolchain::left_out(&left_out) })
}

/// The environment variable that passes an order to the build of the plant's crate.
fn as_variable(plant_order: u8) -> (&'static str, String) {
    ("DUALARM_PLANT_ORDER", plant_order.to_string())
}

/// A model crate.
struct Packager {
    model: String,
    program: PathBuf,
    /// Names and GUIDs of its models, as `FMI2_EXPORT_GUIDS` has them.
    guids: String,
}

/// The packaging programs and the descriptions that they print. They are built with the profile of this tool, which has
/// compiled most of their dependencies (selecting the whole workspace gives dependencies the same features as there).
fn programs(root: &Path, plant_order: Option<u8>, quiet: bool) -> Result<Vec<Packager>, PackageError> {
    let mut command = Command::new(cargo::program());
    command.args(["build", "--release", "--workspace"]);
    for model in MODELS {
        command.args(["--bin", model, "--features", &format!("{model}/package")]);
    }
    command.envs(plant_order.map(as_variable));
    let messages = cargo::build(command, root, quiet)?;
    let program = |model: &&str| {
        let program = cargo::find_program(&messages, model)?;
        let guids = run(&root.join(model), &program, &["--guids".into()])?;
        Ok(Packager { model: (*model).to_owned(), program, guids })
    };
    MODELS.iter().map(program).collect()
}

/// The libraries of all crates for a platform, with the profile `fmu`, without the dependencies of packaging, and with the
/// GUIDs compiled in. One call of cargo builds them, so that it optimises and links them side by side.
fn libraries(
    root: &Path,
    plant_order: Option<u8>,
    quiet: bool,
    platform: &'static Platform,
    crates: &[Packager],
) -> Result<Vec<PathBuf>, PackageError> {
    let guids: Vec<&str> = crates.iter().map(|one| one.guids.as_str()).collect();
    let mut command = platform.cargo(&cargo::program(), "build");
    command.args(["--profile", "fmu", "--package", LIBRARIES, "--examples"]);
    command.env("FMI2_EXPORT_GUIDS", guids.join(";")).envs(plant_order.map(as_variable));
    let messages = cargo::build(command, root, quiet)?;
    crates.iter().map(|one| cargo::find_library(&messages, &one.model, platform.extension())).collect()
}

/// Runs a model's packaging program, with the environment variables that `cargo run` would set. Returns its output.
fn run(home: &Path, program: &Path, arguments: &[OsString]) -> Result<String, PackageError> {
    let output = Command::new(program)
        .args(arguments)
        .env("CARGO", cargo::program())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_sources_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("dist");
        let error =
            package(folder.path(), &out, &Platforms::default(), None, true, &mut |_| ()).unwrap_err().to_string();
        assert!(error.contains("not around this folder") && !out.exists(), "{error}");
    }
}
