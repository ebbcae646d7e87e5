//! `cargo fmi2 package`: runs the packaging program of a crate. That program does the work, because it contains the crate's
//! models.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use serde_json::Value;

/// The feature that packaging programs are behind.
const FEATURE: &str = "package";

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo fmi2 package                           dist/NAME.fmu for each model of the crate in this folder\n  \
    cargo fmi2 package -p plant -o out           of the workspace's crate plant, into out/\n  \
    cargo fmi2 package --require linux64,win64   only if it runs on both\n  \
    cargo fmi2 package --describe descriptions   only the XML, to look at or to check in")]
/// Arguments of `cargo fmi2 package`.
pub struct Arguments {
    /// The crate [default: the one in this folder]
    #[arg(short, long, value_name = "NAME")]
    package: Option<String>,
    /// The crate's or its workspace's Cargo.toml [default: the nearest one from this folder upwards]
    #[arg(long, value_name = "FILE")]
    manifest_path: Option<PathBuf>,
    /// Folder for the .fmu files [default: dist]
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Build for these platforms, e.g. linux64,win64 [default: this machine's, and linux64 and win64 where their toolchains are
    /// installed]
    #[arg(long, value_name = "NAMES")]
    platform: Option<String>,
    /// Fail if one of these platforms is missing in the end
    #[arg(long, value_name = "NAMES")]
    require: Option<String>,
    /// Take the libraries for further platforms from this .fmu, which was built elsewhere from the same description
    #[arg(long, value_name = "FILE")]
    merge: Vec<PathBuf>,
    /// Package this built library (.so, .dll, .dylib) instead of building it; once for each platform
    #[arg(long, value_name = "FILE", conflicts_with = "platform")]
    library: Vec<PathBuf>,
    /// Only write each model's description as FOLDER/NAME.xml
    #[arg(long, value_name = "FOLDER")]
    describe: Option<PathBuf>,
}

impl Arguments {
    /// Those for the packaging program.
    fn forwarded(&self) -> Vec<OsString> {
        let names = [("--platform", &self.platform), ("--require", &self.require)];
        let names = names.into_iter().filter_map(|(option, names)| Some((option, names.as_ref()?.into())));
        let paths = [("--out", self.out.as_slice()), ("--describe", self.describe.as_slice())];
        let paths = paths.into_iter().chain([("--merge", &*self.merge), ("--library", &*self.library)]);
        let paths = paths.flat_map(|(option, paths)| paths.iter().map(move |path| (option, path.into())));
        names.chain(paths).flat_map(|(option, value): (&str, OsString)| [option.into(), value]).collect()
    }
}

/// Builds and runs the packaging program, which reports its own errors.
///
/// # Errors
/// If there is no such program.
pub fn run(arguments: &Arguments) -> Result<ExitCode, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let start = |error| format!("cannot run {}: {error}", cargo.display());
    let mut metadata = Command::new(&cargo);
    metadata.args(["metadata", "--no-deps", "--format-version", "1"]);
    if let Some(path) = &arguments.manifest_path {
        metadata.arg("--manifest-path").arg(path);
    }
    let output = metadata.stderr(Stdio::inherit()).output().map_err(start)?;
    if !output.status.success() {
        return Err("cargo has said why there is no crate to package; `cargo fmi2 new` makes one".into());
    }
    let metadata: Value =
        serde_json::from_slice(&output.stdout).map_err(|error| format!("cargo's answer is not understood: {error}"))?;
    let from = match &arguments.manifest_path {
        Some(path) => path.parent().unwrap_or(Path::new(".")).to_owned(),
        None => PathBuf::from("."),
    };
    let from = from.canonicalize().map_err(|error| format!("cannot find {}: {error}", from.display()))?;
    let program = find(&metadata, &from, arguments.package.as_deref())?;
    let status = Command::new(&cargo)
        // By its manifest: a name may be that of a dependency, too.
        .args(["run", "--release", "--bin", &program.name, "--manifest-path"])
        .arg(&program.manifest)
        .args(["--features", &program.features.join(",")])
        .arg("--")
        .args(arguments.forwarded())
        .status()
        .map_err(start)?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

/// A packaging program.
#[derive(Debug, PartialEq, Eq)]
struct Program {
    manifest: PathBuf,
    name: String,
    features: Vec<String>,
}

/// Finds the packaging program of a crate in the output of `cargo metadata`: that of the wanted crate, or of the one in
/// `folder`.
fn find(metadata: &Value, folder: &Path, wanted: Option<&str>) -> Result<Program, String> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let packages = list(&metadata["packages"]);
    let name = |value: &Value| value["name"].as_str().unwrap_or_default().to_owned();
    let home = |package: &Value| {
        package["manifest_path"].as_str().and_then(|path| Path::new(path).parent()?.canonicalize().ok())
    };
    let chosen = match wanted {
        Some(wanted) => packages.iter().find(|package| name(package) == wanted).ok_or_else(|| {
            let known: Vec<String> = packages.iter().map(name).collect();
            format!("there is no crate {wanted}, but {}", known.join(", "))
        })?,
        None => packages
            .iter()
            .filter(|package| home(package).is_some_and(|home| folder.starts_with(home)))
            .max_by_key(|package| home(package).map(|home| home.components().count()))
            .ok_or("the workspace has several crates: say which one by -p NAME, or go to its folder")?,
    };
    let features = |target: &Value| -> Vec<String> {
        list(&target["required-features"]).iter().filter_map(|feature| feature.as_str().map(str::to_owned)).collect()
    };
    let package = name(chosen);
    let manifest = PathBuf::from(chosen["manifest_path"].as_str().unwrap_or_default());
    list(&chosen["targets"])
        .iter()
        .map(|target| Program { manifest: manifest.clone(), name: name(target), features: features(target) })
        .find(|program| program.features.iter().any(|feature| feature == FEATURE))
        .ok_or_else(|| {
            format!(
                "{package} has no packaging program: a [[bin]] with required-features = [{FEATURE:?}] that calls \
                 fmi2_package::main, as `cargo fmi2 new` makes it"
            )
        })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn workspace(root: &Path) -> Value {
        let package = |name: &str, targets: Value| {
            std::fs::create_dir_all(root.join(name)).unwrap();
            json!({ "name": name, "manifest_path": root.join(name).join("Cargo.toml"), "targets": targets })
        };
        let plant = json!([{ "name": "plant" }, { "name": "pack", "required-features": ["package", "extra"] }]);
        json!({ "packages": [package("plant", plant), package("tool", json!([{ "name": "tool" }]))] })
    }

    #[test]
    fn the_program_is_found_by_name_and_by_folder() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path().canonicalize().unwrap();
        let metadata = workspace(&root);
        let program = Program {
            manifest: root.join("plant/Cargo.toml"),
            name: "pack".into(),
            features: vec!["package".into(), "extra".into()],
        };
        assert_eq!(find(&metadata, &root, Some("plant")), Ok(program));
        assert_eq!(find(&metadata, &root.join("plant/src"), None).unwrap().name, "pack");
        let problem = |folder: &Path, wanted| find(&metadata, folder, wanted).unwrap_err();
        assert!(problem(&root, None).contains("-p NAME"));
        assert!(problem(&root, Some("plan")).contains("but plant, tool"));
        assert!(problem(&root.join("tool"), None).contains("no packaging program"));
    }
}
