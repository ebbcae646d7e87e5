//! FMUs for other platforms, built and run here by emulation: Windows by wine, 64-bit ARM by qemu, an old Linux by its own
//! C library. The tests are in `tests/test_platforms.py`.
//!
//! None of this installs a compiler: if something is missing, a message says so and the step is skipped. The plain test
//! command does not include it, because the standard library is compiled for each platform, which takes minutes.

mod cross;
mod emulator;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::python;
use crate::steps::{Outcome, Runner, run};
use crate::tree::Tree;

pub use cross::{Compiler, zigbuild};
use emulator::Emulator;

/// The part that the plain test command omits.
pub const NOT_CHECKED: &str =
    "win64, aarch64-linux and old Linux were not checked here: `cargo xtask test --all-platforms` does it";

/// How many steps [`add`] adds.
pub const COUNT: usize = 3;

/// The crates of the FMUs, whose packaging programs have the same names.
const MODELS: [&str; 3] = ["plant-fmu", "controller-fmu", "instruments-fmu"];

/// The contents of a folder of built and packaged libraries.
struct Built {
    /// FMUs with the libraries of this machine and of the other platform.
    fmus: PathBuf,
    /// A library that panics on request.
    misbehaving: PathBuf,
    /// The command line tool, if it was built for the platform.
    tool: Option<PathBuf>,
}

/// A step for each platform.
pub fn add(steps: &mut Runner, tree: &Tree) {
    steps.step("Windows (win64)", || check(tree, "win64", &emulator::wine(tree)));
    steps.step("ARM (aarch64-linux)", || check(tree, "aarch64-linux", &emulator::qemu(tree)));
    steps.step("Old Linux (linux64)", || check(tree, "linux64", &emulator::old_linux(tree)));
}

/// Builds for a platform and runs its tests; skipped where a program for it is absent.
fn check(tree: &Tree, platform: &'static str, emulator: &Result<Emulator, String>) -> Outcome {
    let emulator = match emulator {
        Ok(emulator) => emulator,
        Err(missing) => return Outcome::Skipped(format!("{platform}: {missing}")),
    };
    let compiler = match Compiler::find(tree, platform) {
        Ok(compiler) => compiler,
        Err(missing) => return Outcome::Skipped(format!("{platform}: {missing}")),
    };
    // Earlier results are not valid for the libraries that are built now.
    let _ = fs::remove_file(record(tree, platform));
    match build(tree, &compiler) {
        Ok(built) => match run(pytest(tree, platform, emulator, &built)) {
            Outcome::Passed => run(note(tree, platform, &built)),
            other => other,
        },
        Err(outcome) => outcome,
    }
}

/// The record of the libraries and programs of a platform that have passed their tests.
fn record(tree: &Tree, platform: &str) -> PathBuf {
    tree.target.join("platforms").join(format!("{platform}.sha256"))
}

/// The records that [`check`] has written for all platforms.
pub fn records(tree: &Tree) -> Vec<PathBuf> {
    ["win64", "aarch64-linux", "linux64"].iter().map(|platform| record(tree, platform)).collect()
}

/// Records the files that have passed.
fn note(tree: &Tree, platform: &str, built: &Built) -> Command {
    let mut command = python::command(tree, &["python/downloads.py", "tested"]);
    command.arg(record(tree, platform)).args(&built.tool);
    let fmus = fs::read_dir(&built.fmus).into_iter().flatten().flatten().map(|entry| entry.path());
    command.args(fmus.filter(|path| path.extension().is_some_and(|extension| extension == "fmu")));
    command
}

/// The platform of this machine, as the tool names it.
pub fn here() -> &'static str {
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "aarch64") => "aarch64-linux",
        ("windows", _) => "win64",
        ("macos", "aarch64") => "aarch64-darwin",
        ("macos", _) => "darwin64",
        _ => "linux64",
    }
}

/// FMUs with the libraries of one platform only, for the descriptions of this machine's packaging programs.
pub fn alone(tree: &Tree, compiler: &Compiler) -> Result<PathBuf, Outcome> {
    let folder = folder(tree, compiler).join("alone");
    emptied(&folder)?;
    let guids = guids(tree)?;
    for model in MODELS {
        passed(run(compiler.model(model, &guids)))?;
        let mut packager = packager(tree, model);
        packager.arg("--library").arg(compiler.built(&model.replace('-', "_"))).arg("--out").arg(&folder);
        passed(run(packager))?;
    }
    Ok(folder)
}

/// The libraries, in FMUs of both platforms.
fn build(tree: &Tree, compiler: &Compiler) -> Result<Built, Outcome> {
    let alone = alone(tree, compiler)?;
    let fmus = folder(tree, compiler).join("fmus");
    emptied(&fmus)?;
    let mut merge = Command::new(tree.program("dualarm"));
    merge.current_dir(&tree.root).args(["--quiet", "package", "--merge"]).arg(&alone).arg("--out").arg(&fmus);
    if compiler.platform == here() {
        // Its own library would come before that of the archive.
        fs::remove_dir_all(&fmus).and_then(|()| fs::rename(&alone, &fmus)).map_err(failed)?;
    } else {
        passed(run(merge))?;
    }
    let guids = format!("{};Misbehaving={}", guids(tree)?, cross::MISBEHAVING);
    passed(run(compiler.library(&["--package", "fmi2-export", "--example", "misbehaving"], &guids)))?;
    let tool = match compiler.tool() {
        Some(command) => {
            passed(run(command))?;
            Some(compiler.built_tool())
        }
        None => None,
    };
    Ok(Built { fmus, misbehaving: compiler.built_example("misbehaving"), tool })
}

fn passed(outcome: Outcome) -> Result<(), Outcome> {
    if outcome == Outcome::Passed { Ok(()) } else { Err(outcome) }
}

#[allow(clippy::needless_pass_by_value)] // it is given to map_err
fn failed(problem: std::io::Error) -> Outcome {
    Outcome::Failed(problem.to_string())
}

fn folder(tree: &Tree, compiler: &Compiler) -> PathBuf {
    tree.target.join("platforms").join(compiler.platform)
}

fn emptied(folder: &Path) -> Result<(), Outcome> {
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(failed)?;
    }
    fs::create_dir_all(folder).map_err(failed)
}

/// A packaging program, with the environment variables that cargo would set.
fn packager(tree: &Tree, model: &str) -> Command {
    let mut command = Command::new(tree.program(model));
    command.env("CARGO", crate::tree::cargo()).env("CARGO_MANIFEST_DIR", tree.root.join(model)).current_dir(&tree.root);
    command
}

/// The GUIDs that packaging on this machine has computed: libraries of other platforms belong to the same descriptions.
fn guids(tree: &Tree) -> Result<String, Outcome> {
    let of = |model: &&str| {
        let output = packager(tree, model).arg("--guids").output().map_err(|error| {
            Outcome::Failed(format!("{model} does not start ({error}): `cargo run --release -- package` builds it"))
        })?;
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    Ok(MODELS.iter().map(of).collect::<Result<Vec<_>, Outcome>>()?.join(";"))
}

/// The tests of one platform; environment variables tell them which programs to run, and how.
fn pytest(tree: &Tree, platform: &str, emulator: &Emulator, built: &Built) -> Command {
    let mut command = python::command(tree, &["-m", "pytest", "tests/test_platforms.py"]);
    let words = |words: &[String]| words.join("\n");
    command
        .env("PLATFORM", platform)
        .env("PLATFORM_FMUS", &built.fmus)
        .env("PLATFORM_MISBEHAVING", &built.misbehaving)
        .env("PLATFORM_CC", words(&emulator.c_compiler))
        .env("PLATFORM_RUN", words(&emulator.run))
        .envs(emulator.environment.iter().map(|(name, value)| (name, value)));
    if let Some(tool) = &built.tool {
        command.env("PLATFORM_TOOL", tool);
    }
    command
}

/// A program on the search path.
fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// The first of these files that is there.
fn first(files: &[&str]) -> Option<PathBuf> {
    files.iter().map(Path::new).find(|file| file.is_file()).map(Path::to_owned)
}
