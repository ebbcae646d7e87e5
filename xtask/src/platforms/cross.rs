//! A compiler for another platform: rustup's if its target is installed, otherwise Debian's (`rustc-web`), which includes
//! the source of the standard library and compiles it.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{first, on_path};
use crate::python;
use crate::tree::Tree;

/// The GUID that the library of the tests is built with: it has no packaging program.
pub const MISBEHAVING: &str = "{00000000-0000-0000-0000-000000000001}";

/// How libraries are compiled for a platform.
pub struct Compiler {
    /// The platform's folder below `binaries/`.
    pub platform: &'static str,
    target: &'static str,
    /// The target as zig has it, with the version of glibc, where zig links.
    linked_for: Option<String>,
    root: PathBuf,
    /// Where it builds.
    folder: PathBuf,
    /// `cargo`, or `cargo-zigbuild`.
    cargo: PathBuf,
    /// Before the arguments of each build.
    options: Vec<&'static str>,
    environment: Vec<(String, String)>,
}

/// Arguments with which cargo compiles the standard library too, without the code that prints backtraces, which nobody sees
/// in a host, and for size. Its parts that a step needs are compiled in the crates that use them.
const WITH_STANDARD_LIBRARY: [&str; 2] =
    ["-Zbuild-std=std,panic_unwind", "-Zbuild-std-features=panic-unwind,optimize_for_size"];

/// Settings of the profile `fmu` for the parts of the standard library. They are not in `Cargo.toml`, where a build that takes the
/// standard library as it comes would warn of packages that it does not know.
const OF_STANDARD_LIBRARY: [&str; 6] = [
    "profile.fmu.package.alloc.opt-level='s'",
    "profile.fmu.package.core.opt-level='s'",
    "profile.fmu.package.panic_unwind.opt-level='s'",
    "profile.fmu.package.std.opt-level='s'",
    "profile.fmu.package.unwind.opt-level='s'",
    // Every function in an object of its own: of one object, Windows' libraries would contain all functions.
    "profile.fmu.package.compiler_builtins.codegen-units=10000",
];

/// Arguments with which LLVM unrolls only short loops, for Windows' controllers, the last library above 0.6 MB: 25 kB less. Counted on
/// Linux, a step of NABFC has 1 % fewer instructions, of the other laws at most 0.5 % more. The plant's would have 10 % more.
const LOOPS_STAY: [&str; 3] = ["--", "-C", "llvm-args=-unroll-threshold=50 -unroll-runtime=false"];

impl Compiler {
    /// The available compiler for this platform.
    ///
    /// # Errors
    /// The missing parts.
    pub fn find(tree: &Tree, platform: &'static str) -> Result<Self, String> {
        let mut compiler = Self {
            platform,
            target: "",
            linked_for: None,
            root: tree.root.clone(),
            folder: tree.target.join("cross"),
            cargo: crate::tree::cargo().into(),
            options: Vec::new(),
            environment: Vec::new(),
        };
        match platform {
            "win64" => {
                if on_path("x86_64-w64-mingw32-gcc").is_none() {
                    return Err("no linker (Debian: gcc-mingw-w64-x86-64)".into());
                }
                // wine 8 emulates Windows 7; targets for later versions need a DLL that it lacks.
                compiler.target = "x86_64-win7-windows-gnu";
                compiler.use_debian()?;
                let gcc = "x86_64-w64-mingw32-gcc";
                compiler.set("CARGO_TARGET_X86_64_WIN7_WINDOWS_GNU_LINKER", gcc);
                compiler.set("CC_x86_64_win7_windows_gnu", gcc);
                compiler.set("AR_x86_64_win7_windows_gnu", "x86_64-w64-mingw32-ar");
            }
            "aarch64-linux" => {
                compiler.target = "aarch64-unknown-linux-gnu";
                compiler.use_debian()?;
                compiler.by_zig(tree)?;
            }
            _ => {
                compiler.target = "x86_64-unknown-linux-gnu";
                // Built by the compiler of this machine, in addition to the library that `dualarm package` builds with zig.
                compiler.folder.clone_from(&tree.target);
                compiler.by_zig(tree)?;
            }
        }
        Ok(compiler)
    }

    fn set(&mut self, name: &str, value: &str) {
        self.environment.push((name.to_owned(), value.to_owned()));
    }

    /// Debian's compiler, which may compile the standard library: `RUSTC_BOOTSTRAP` is for that.
    fn use_debian(&mut self) -> Result<(), String> {
        let packages =
            "no compiler with the source of its standard library (Debian: rustc-web, cargo-web, rust-web-src)";
        let source = first(&["/usr/lib/rustlib/src/rust/library/std/Cargo.toml"]);
        let (Some(cargo), Some(_), Some(_)) = (first(&["/usr/bin/cargo"]), first(&["/usr/bin/rustc"]), source) else {
            return Err(packages.into());
        };
        self.cargo = cargo;
        self.options.extend(WITH_STANDARD_LIBRARY);
        self.options.extend(OF_STANDARD_LIBRARY.iter().flat_map(|setting| ["--config", setting]));
        self.set("RUSTC", "/usr/bin/rustc");
        self.set("CARGO", "/usr/bin/cargo");
        self.set("RUSTC_BOOTSTRAP", "1");
        Ok(())
    }

    /// zig links, for the oldest glibc that Rust's standard library supports.
    fn by_zig(&mut self, tree: &Tree) -> Result<(), String> {
        let (zig, zigbuild) = (zig(tree)?, zigbuild(tree)?);
        self.set("CARGO_ZIGBUILD_ZIG_PATH", &zig.display().to_string());
        self.linked_for = Some(format!("{}.2.17", self.target));
        self.cargo = zigbuild;
        Ok(())
    }

    /// Builds the library of a model's crate. A call for each, unlike on this machine (`fmu-libraries`): cargo takes options of the compiler
    /// for one target only, and Windows' controllers have [some of their own](LOOPS_STAY).
    pub fn model(&self, package: &str, guids: &str) -> Command {
        let mut command = self.library(&["--lib", "--crate-type", "cdylib", "--package", package], guids);
        if (self.platform, package) == ("win64", "controller-fmu") {
            command.args(LOOPS_STAY);
        }
        command
    }

    /// Builds a library; `what` selects it.
    pub fn library(&self, what: &[&str], guids: &str) -> Command {
        let mut command = self.command("rustc");
        command.args(["--profile", "fmu"]).args(what).env("FMI2_EXPORT_GUIDS", guids);
        command
    }

    /// Builds the tool, where it is a program of that platform that people start: on Windows.
    pub fn tool(&self) -> Option<Command> {
        (self.platform == "win64").then(|| self.program())
    }

    /// Builds the tool.
    pub fn program(&self) -> Command {
        let mut command = self.command("rustc");
        // Without names of functions, which are a third of it.
        command.args(["--release", "--package", "dualarm", "--bin", "dualarm", "--", "-C", "strip=symbols"]);
        command
    }

    fn command(&self, subcommand: &str) -> Command {
        let mut command = Command::new(&self.cargo);
        let target = self.linked_for.as_deref().unwrap_or(self.target);
        command.arg(subcommand).args(&self.options).args(["--target", target]).current_dir(&self.root);
        command.env("CARGO_TARGET_DIR", &self.folder).envs(self.environment.iter().map(|(name, value)| (name, value)));
        // Those of the toolchain that runs us are for it alone.
        for name in ["RUSTUP_TOOLCHAIN", "RUSTC_WRAPPER", "RUSTDOC", "RUSTFLAGS"] {
            command.env_remove(name);
        }
        command
    }

    fn profile(&self) -> PathBuf {
        self.folder.join(self.target).join("fmu")
    }

    /// The library of a crate.
    pub fn built(&self, name: &str) -> PathBuf {
        self.file(&self.profile(), name)
    }

    /// The library of an example.
    pub fn built_example(&self, name: &str) -> PathBuf {
        self.file(&self.profile().join("examples"), name)
    }

    fn file(&self, folder: &Path, name: &str) -> PathBuf {
        folder.join(if self.platform == "win64" { format!("{name}.dll") } else { format!("lib{name}.so") })
    }

    /// The tool.
    pub fn built_tool(&self) -> PathBuf {
        let name = if self.platform == "win64" { "dualarm.exe" } else { "dualarm" };
        self.folder.join(self.target).join("release").join(name)
    }
}

/// `cargo-zigbuild`, from `PyPI` as zig itself is.
pub fn zigbuild(tree: &Tree) -> Result<PathBuf, String> {
    zig(tree)?;
    let zigbuild = python::tool(tree, "cargo-zigbuild", "cargo-zigbuild", "--version")?;
    Ok(zigbuild.get_program().into())
}

/// zig, which is a C compiler too.
pub fn zig(tree: &Tree) -> Result<PathBuf, String> {
    Ok(python::tool(tree, "ziglang", "python-zig", "version")?.get_program().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_have_the_names_of_their_platform() {
        let compiler = |platform, target| Compiler {
            platform,
            target,
            linked_for: None,
            root: "/r".into(),
            folder: "/t/cross".into(),
            cargo: "cargo".into(),
            options: Vec::new(),
            environment: Vec::new(),
        };
        let windows = compiler("win64", "x86_64-win7-windows-gnu");
        assert_eq!(windows.built("plant_fmu"), Path::new("/t/cross/x86_64-win7-windows-gnu/fmu/plant_fmu.dll"));
        let arm = compiler("aarch64-linux", "aarch64-unknown-linux-gnu");
        assert!(arm.built_example("misbehaving").ends_with("fmu/examples/libmisbehaving.so"));
        assert!(windows.tool().is_some() && arm.tool().is_none());
    }
}
