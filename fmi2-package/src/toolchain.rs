//! The requirements for building for a [`Platform`] on this machine, and the cargo command that builds.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::platform::{PLATFORMS, Platform};

/// Platforms that are built wherever their toolchains are installed, besides the machine's own. For other platforms an
/// installed target does not mean that linker and libraries are installed too.
const USUAL: [&str; 5] = ["linux64", "win64", "aarch64-linux", "darwin64", "aarch64-darwin"];
/// Platforms that users expect: the program reports it if they are omitted.
const EXPECTED: [&str; 2] = ["linux64", "win64"];
/// The oldest glibc for which libraries are linked if zig is installed: that of 2012 and of `manylinux2014`, and the oldest
/// that Rust's standard library supports.
const OLDEST_GLIBC: &str = "2.17";
/// Cargo with zig as the linker.
const ZIGBUILD: &str = "cargo-zigbuild";

impl Platform {
    /// The missing parts for a build on this machine, as instructions to the user. `None` if nothing is missing.
    #[must_use]
    pub fn missing(&self) -> Option<String> {
        if Self::here() == Some(self) {
            return None;
        }
        let mut todo = Vec::new();
        if !has_standard_library(self.target) {
            todo.push(format!("rustup target add {}", self.target));
        }
        match self.linker {
            // Apple's tools exist only on Apple's machines.
            None if self.os == "macos" && !cfg!(target_os = "macos") => todo.push("a Mac".to_owned()),
            Some((linker, package))
                if !(self.is_linked_by_zig()
                    || std::env::var_os(self.linker_variable()).is_some()
                    || on_path(linker)) =>
            {
                todo.push(format!("{linker} (package {package})"));
            }
            _ => {}
        }
        (!todo.is_empty()).then(|| todo.join(" and "))
    }

    /// The cargo command that builds a crate's library for it; the caller adds the crate and the profile.
    ///
    /// Only the shared library is built. If a library for Rust (`rlib`), which the crate's tests and its packaging program
    /// link, were built beside it, cargo would omit the link-time optimisation of the profile, and on systems where the
    /// linker does not drop unused functions, such as Windows, the library would contain the code of all crates.
    #[must_use]
    pub fn build_library(&self, cargo: &OsStr) -> Command {
        let mut command = self.cargo(cargo, "rustc");
        command.args(["--lib", "--crate-type", "cdylib"]);
        command
    }

    /// This subcommand of cargo, for it. The caller adds the rest.
    #[must_use]
    pub fn cargo(&self, cargo: &OsStr, subcommand: &str) -> Command {
        let by_zig = self.is_linked_by_zig();
        let mut command = Command::new(if by_zig { OsStr::new(ZIGBUILD) } else { cargo });
        command.arg(subcommand);
        if by_zig {
            command.arg("--target").arg(format!("{}.{OLDEST_GLIBC}", self.target));
        } else if Self::here() != Some(self) {
            command.args(["--target", self.target]);
            if let Some((linker, _)) = self.linker.filter(|_| std::env::var_os(self.linker_variable()).is_none()) {
                command.env(self.linker_variable(), linker);
            }
        }
        command
    }

    /// Whether zig links it; zig contains the interfaces of all versions of glibc.
    fn is_linked_by_zig(&self) -> bool {
        static HAS_ZIG: OnceLock<bool> = OnceLock::new();
        self.os == "linux"
            && *HAS_ZIG.get_or_init(|| {
                let is_named = std::env::var_os("CARGO_ZIGBUILD_ZIG_PATH").is_some();
                // The package ziglang of PyPI installs `python-zig`.
                on_path(ZIGBUILD) && (is_named || on_path("zig") || on_path("python-zig"))
            })
    }

    fn linker_variable(&self) -> String {
        format!("CARGO_TARGET_{}_LINKER", self.target.to_uppercase().replace('-', "_"))
    }
}

/// Whether cargo's compiler has the standard library of a target.
fn has_standard_library(target: &str) -> bool {
    static SYSROOT: OnceLock<Option<PathBuf>> = OnceLock::new();
    let sysroot = SYSROOT.get_or_init(|| {
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let output = Command::new(rustc).args(["--print", "sysroot"]).output().ok()?;
        output.status.success().then(|| PathBuf::from(String::from_utf8_lossy(&output.stdout).trim()))
    });
    let folder = |sysroot: &PathBuf| sysroot.join("lib").join("rustlib").join(target).join("lib");
    sysroot.as_ref().is_some_and(|sysroot| has_files(&folder(sysroot)))
}

fn has_files(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|mut files| files.next().is_some())
}

fn on_path(program: &str) -> bool {
    let name = format!("{program}{}", std::env::consts::EXE_SUFFIX);
    std::env::var_os("PATH").is_some_and(|path| std::env::split_paths(&path).any(|folder| folder.join(&name).is_file()))
}

/// Platforms to build for, and omitted ones with their missing parts.
pub type Selection = (Vec<&'static Platform>, Vec<(&'static Platform, String)>);

/// The platforms to build for, and the omitted ones with their missing parts. `wanted` are exactly the platforms to build;
/// if it is empty, these are the machine's own and the usual ones whose toolchains are installed.
///
/// # Errors
/// If a wanted or required platform cannot be built; the message says what to do.
pub fn select(wanted: &[&'static Platform], required: &[&'static Platform]) -> Result<Selection, String> {
    let lacking =
        |platform: &Platform, what: &str| format!("{} cannot be built here: it needs {what}", platform.folder);
    if !wanted.is_empty() {
        if let Some(absent) = required.iter().find(|platform| !wanted.contains(platform)) {
            return Err(format!("{} is required, but not among the platforms to build", absent.folder));
        }
        return match wanted.iter().find_map(|platform| Some((platform, platform.missing()?))) {
            Some((platform, what)) => Err(lacking(platform, &what)),
            None => Ok((wanted.to_vec(), Vec::new())),
        };
    }
    let (mut built, mut left_out) = (Vec::new(), Vec::new());
    for platform in &PLATFORMS {
        let is_required = required.contains(&platform);
        if !(is_required || USUAL.contains(&platform.folder) || Platform::here() == Some(platform)) {
            continue;
        }
        match platform.missing() {
            None => built.push(platform),
            Some(what) if is_required => return Err(lacking(platform, &what)),
            Some(what) if EXPECTED.contains(&platform.folder) => left_out.push((platform, what)),
            Some(_) => {}
        }
    }
    if built.is_empty() {
        use std::env::consts::{ARCH, OS};
        return Err(format!("FMI 2.0 names no folder for binaries of {OS} on {ARCH}"));
    }
    Ok((built, left_out))
}

/// One line about the omitted platforms; `None` if there are none.
#[must_use]
pub fn left_out(platforms: &[(&'static Platform, String)]) -> Option<String> {
    let list: Vec<_> = platforms.iter().map(|(platform, what)| format!("{} (needs {what})", platform.folder)).collect();
    (!list.is_empty()).then(|| format!("left out: {}", list.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machines_own_platform_needs_nothing() {
        let here = Platform::here().unwrap();
        assert_eq!(here.missing(), None);
        let (built, _) = select(&[], &[]).unwrap();
        assert!(built.contains(&here));
        assert_eq!(select(&[here], &[here]).unwrap().0, [here]);
        let elsewhere = PLATFORMS.iter().find(|platform| platform.missing().is_some()).unwrap();
        for refused in [select(&[elsewhere], &[]), select(&[], &[elsewhere]), select(&[here], &[elsewhere])] {
            assert!(refused.unwrap_err().starts_with(elsewhere.folder));
        }
    }

    #[test]
    fn what_is_left_out_is_said_with_what_to_do() {
        let win64 = Platform::named("win64").unwrap();
        let line = left_out(&[(win64, "a linker".into())]);
        assert_eq!(line.as_deref(), Some("left out: win64 (needs a linker)"));
        assert_eq!(left_out(&[]), None);
    }

    #[test]
    fn other_platforms_are_asked_for_by_their_targets() {
        for platform in PLATFORMS.iter().filter(|platform| Platform::here() != Some(*platform)) {
            let command = platform.build_library(OsStr::new("cargo"));
            let target = command.get_args().skip_while(|argument| *argument != "--target").nth(1).unwrap();
            assert!(target.to_str().unwrap().starts_with(platform.target), "{command:?}");
        }
    }
}
