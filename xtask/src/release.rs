//! `cargo xtask release`: a folder with the contents of a release page. `python/downloads.py` defines the files and
//! assembles them; this module builds their parts.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::platforms::{self, Compiler};
use crate::python;
use crate::steps::{Outcome, Runner, run};
use crate::tree::{Tree, works};

/// Platforms besides this machine's that FMUs get libraries for where their compilers are there.
const OTHERS: [&str; 2] = ["win64", "aarch64-linux"];

/// Builds all parts in `out`, with the libraries of FMUs in `merged`, which were built on other machines.
pub fn add(steps: &mut Runner, tree: &Tree, out: &Path, merged: &[PathBuf]) {
    let out = tree.root.join(out);
    let mut libraries: Vec<PathBuf> = merged.iter().map(|path| tree.root.join(path)).collect();
    let mut tools: Vec<(&str, PathBuf)> = Vec::new();
    steps.step("Python environment", || python::prepare(tree));
    steps.step("FMUs of this machine", || {
        if let Err(error) = emptied(&out) {
            return Outcome::Failed(format!("cannot make {}: {error}", out.display()));
        }
        run(with_zig(tree, tree.cargo(&["run", "--release", "--", "package"])))
    });
    for platform in OTHERS {
        steps.step(platform, || match other(tree, platform) {
            Ok((folder, tool)) => {
                libraries.push(folder);
                tools.extend(tool.map(|tool| (platform, tool)));
                Outcome::Passed
            }
            Err(outcome) => outcome,
        });
    }
    let fmus = out.join("fmus");
    steps.step("FMUs of all platforms", || {
        let mut command = with_zig(tree, tree.cargo(&["run", "--release", "--", "package", "--cross-check", "--out"]));
        command.arg(&fmus).args(libraries.iter().flat_map(|path| [OsStr::new("--merge"), path.as_os_str()]));
        run(command)
    });
    steps.step("Tool", || match tool(tree) {
        Ok(built) => {
            tools.push((platforms::here(), built));
            Outcome::Passed
        }
        Err(outcome) => outcome,
    });
    steps.step("Archives and wheels", || {
        for (platform, tool) in &tools {
            for kind in ["archive", "wheel"] {
                let mut command = python::command(tree, &["python/downloads.py", kind, "--platform", platform]);
                command.arg("--fmus").arg(&fmus).arg("--tool").arg(tool).arg("--out").arg(&out);
                let outcome = run(command);
                if outcome != Outcome::Passed {
                    return outcome;
                }
            }
        }
        Outcome::Passed
    });
    // The tool that has passed the tests of its wheel: that of this machine, which is the last.
    let of_wheel = tree.target.join("platforms").join("wheel").join(format!("{}.sha256", platforms::here()));
    steps.step("Oldest glibc", || check_glibc(tree, &out));
    steps.step("Wheel", || {
        let Some(wheel) = wheel(&out) else { return Outcome::Failed("there is none for this machine".into()) };
        let mut command = python::command(tree, &["-m", "pytest", "tests/test_wheel.py"]);
        command.env("DUALARM_WHEEL", wheel);
        let mut note = python::command(tree, &["python/downloads.py", "tested"]);
        note.arg(&of_wheel).args(tools.last().map(|(_, tool)| tool));
        let _ = fs::remove_file(&of_wheel);
        match run(command) {
            Outcome::Passed => run(note),
            other => other,
        }
    });
    steps.step("Notes and checksums", || {
        let mut notes = python::command(tree, &["python/downloads.py", "notes"]);
        notes.arg(&out).args(platforms::records(tree)).arg(&of_wheel);
        let mut checksums = python::command(tree, &["python/downloads.py", "checksums"]);
        checksums.arg(&out);
        match run(notes) {
            Outcome::Passed => run(checksums),
            other => other,
        }
    });
}

/// Checks that the Linux files need no newer glibc than documented.
fn check_glibc(tree: &Tree, out: &Path) -> Outcome {
    if platforms::here() != "linux64" {
        return Outcome::Skipped("nothing is built for Linux here".into());
    }
    if let Err(missing) = platforms::zigbuild(tree) {
        return Outcome::Skipped(format!("what is for linux64 needs the glibc of this machine, since {missing}"));
    }
    let mut objdump = Command::new("objdump");
    objdump.arg("--version");
    if !works(objdump) {
        return Outcome::Skipped("no objdump (Debian: binutils)".into());
    }
    let mut command = python::command(tree, &["python/downloads.py", "glibc"]);
    command.arg(out);
    run(command)
}

/// The wheel for this machine in a folder.
fn wheel(folder: &Path) -> Option<PathBuf> {
    let tag = match platforms::here() {
        "win64" => "win",
        "darwin64" | "aarch64-darwin" => "macosx",
        _ => "manylinux",
    };
    let mut files = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    files.find(|path| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        path.extension() == Some(OsStr::new("whl")) && name.contains(tag)
    })
}

/// How many steps [`add`] adds.
pub const COUNT: usize = 8 + OTHERS.len();

fn emptied(folder: &Path) -> std::io::Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::create_dir_all(folder)
}

/// FMUs of another platform, and the tool where it is built for it; skipped without a compiler.
fn other(tree: &Tree, platform: &'static str) -> Result<(PathBuf, Option<PathBuf>), Outcome> {
    let compiler =
        Compiler::find(tree, platform).map_err(|missing| Outcome::Skipped(format!("left out: {missing}")))?;
    let folder = platforms::alone(tree, &compiler)?;
    let Some(build) = compiler.tool() else { return Ok((folder, None)) };
    match run(build) {
        Outcome::Passed => Ok((folder, Some(compiler.built_tool()))),
        other => Err(other),
    }
}

/// The tool for this machine: by zig, where it is there, for an old glibc.
fn tool(tree: &Tree) -> Result<PathBuf, Outcome> {
    let passed = |outcome| if outcome == Outcome::Passed { Ok(()) } else { Err(outcome) };
    if platforms::here() == "linux64"
        && let Ok(compiler) = Compiler::find(tree, "linux64")
    {
        passed(run(compiler.program()))?;
        return Ok(compiler.built_tool());
    }
    passed(run(tree.cargo(&["build", "--release"])))?;
    Ok(tree.program("dualarm"))
}

/// With the programs of the Python environment on the search path: `dualarm package` then finds zig.
fn with_zig(tree: &Tree, mut command: Command) -> Command {
    if let Ok(zigbuild) = platforms::zigbuild(tree)
        && let Some(folder) = zigbuild.parent()
    {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folders = std::iter::once(folder.to_owned()).chain(std::env::split_paths(&path));
        command.env("PATH", std::env::join_paths(folders).unwrap_or(path.clone()));
    }
    command
}
