//! `cargo xtask release`: a folder with what a release page offers. What the files are and how they are put together is in
//! `python/downloads.py`; here they are built.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::platforms::{self, Compiler};
use crate::python;
use crate::steps::{Outcome, Runner, run};
use crate::tree::Tree;

/// Platforms besides this machine's that FMUs get libraries for where their compilers are there.
const OTHERS: [&str; 2] = ["win64", "aarch64-linux"];

/// Builds all of it in `out`, with the libraries of FMUs in `merged`, which were built on other machines.
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
    steps.step("Notes and checksums", || {
        let changelog = fs::read_to_string(tree.root.join("CHANGELOG.md")).map_err(|error| error.to_string());
        let notes = changelog.and_then(|text| notes(&text).ok_or_else(|| "CHANGELOG.md has no section".into()));
        match notes.and_then(|text| fs::write(out.join("NOTES.md"), text).map_err(|error| error.to_string())) {
            Ok(()) => {
                let mut command = python::command(tree, &["python/downloads.py", "checksums"]);
                command.arg(&out);
                run(command)
            }
            Err(problem) => Outcome::Failed(problem),
        }
    });
}

/// How many steps [`add`] adds.
pub const COUNT: usize = 6 + OTHERS.len();

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

/// What the changelog says of the newest version, and of what nobody has run.
fn notes(changelog: &str) -> Option<String> {
    let (_, rest) = changelog.split_once("\n## ")?;
    let section = rest.split("\n## ").next()?;
    let (_, text) = section.split_once('\n')?;
    Some(format!(
        "{}\n\n### Platforms\nThe libraries for linux64 and win64 are tested; those for aarch64-linux run under emulation. \
         darwin64 and aarch64-darwin, where they are in the FMUs, were built and not run: **unverified**. What each needs is in \
         `documentation/externalDependencies.txt` of the FMU.\n",
        text.trim()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_those_of_the_newest_version() {
        let text = notes("# Changelog\n\n## [Unreleased]\n\n### Added\n- new\n\n## [1.0.0]\n\n- old\n").unwrap();
        assert!(text.starts_with("### Added\n- new\n\n### Platforms\n") && !text.contains("old"), "{text}");
        assert_eq!(notes("# Changelog\n"), None);
    }
}
