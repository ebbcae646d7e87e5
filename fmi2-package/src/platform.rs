//! Platforms: the folders below `binaries/` in FMI 2.0.4 (section 2.3), and the format of the libraries in them. For all
//! but the first six the standard refers to the platform tuples of FMI 3.0. [`toolchain`](crate::toolchain) says what a
//! build for a platform needs.

use object::{Architecture, BinaryFormat, Object, ObjectKind};

/// A platform that an archive can have a library for.
#[derive(Debug, PartialEq, Eq)]
pub struct Platform {
    /// Its folder below `binaries/`.
    pub folder: &'static str,
    pub(crate) os: &'static str,
    pub(crate) arch: &'static str,
    /// Cargo's name for it.
    pub target: &'static str,
    /// The linker that cargo starts if it is not the machine's own, and the package that has it.
    pub(crate) linker: Option<(&'static str, &'static str)>,
}

const fn platform(folder: &'static str, os: &'static str, arch: &'static str, target: &'static str) -> Platform {
    Platform { folder, os, arch, target, linker: None }
}

/// All of them.
pub const PLATFORMS: [Platform; 8] = [
    platform("linux64", "linux", "x86_64", "x86_64-unknown-linux-gnu"),
    Platform {
        linker: Some(("x86_64-w64-mingw32-gcc", "mingw-w64")),
        ..platform("win64", "windows", "x86_64", "x86_64-pc-windows-gnu")
    },
    platform("darwin64", "macos", "x86_64", "x86_64-apple-darwin"),
    platform("linux32", "linux", "x86", "i686-unknown-linux-gnu"),
    Platform {
        linker: Some(("i686-w64-mingw32-gcc", "mingw-w64")),
        ..platform("win32", "windows", "x86", "i686-pc-windows-gnu")
    },
    Platform {
        linker: Some(("aarch64-linux-gnu-gcc", "gcc-aarch64-linux-gnu")),
        ..platform("aarch64-linux", "linux", "aarch64", "aarch64-unknown-linux-gnu")
    },
    platform("aarch64-darwin", "macos", "aarch64", "aarch64-apple-darwin"),
    platform("aarch64-windows", "windows", "aarch64", "aarch64-pc-windows-msvc"),
];

/// Every function that an FMU with both interfaces has to export; `export!` defines them all.
const FUNCTIONS: [&str; 41] = [
    "fmi2CancelStep",
    "fmi2CompletedIntegratorStep",
    "fmi2DeSerializeFMUstate",
    "fmi2DoStep",
    "fmi2EnterContinuousTimeMode",
    "fmi2EnterEventMode",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2FreeFMUstate",
    "fmi2FreeInstance",
    "fmi2GetBoolean",
    "fmi2GetBooleanStatus",
    "fmi2GetContinuousStates",
    "fmi2GetDerivatives",
    "fmi2GetDirectionalDerivative",
    "fmi2GetEventIndicators",
    "fmi2GetFMUstate",
    "fmi2GetInteger",
    "fmi2GetIntegerStatus",
    "fmi2GetNominalsOfContinuousStates",
    "fmi2GetReal",
    "fmi2GetRealOutputDerivatives",
    "fmi2GetRealStatus",
    "fmi2GetStatus",
    "fmi2GetString",
    "fmi2GetStringStatus",
    "fmi2GetTypesPlatform",
    "fmi2GetVersion",
    "fmi2Instantiate",
    "fmi2NewDiscreteStates",
    "fmi2Reset",
    "fmi2SerializeFMUstate",
    "fmi2SerializedFMUstateSize",
    "fmi2SetBoolean",
    "fmi2SetContinuousStates",
    "fmi2SetDebugLogging",
    "fmi2SetFMUstate",
    "fmi2SetInteger",
    "fmi2SetReal",
    "fmi2SetTime",
    "fmi2Terminate",
];

impl Platform {
    /// The one this program runs on.
    #[must_use]
    pub fn here() -> Option<&'static Self> {
        use std::env::consts::{ARCH, OS};
        PLATFORMS.iter().find(|platform| (platform.os, platform.arch) == (OS, ARCH))
    }

    /// The platform of this folder.
    ///
    /// # Errors
    /// If there is none; the message lists all platforms.
    pub fn named(folder: &str) -> Result<&'static Self, String> {
        PLATFORMS.iter().find(|platform| platform.folder == folder).ok_or_else(|| {
            format!("unknown platform {folder:?}; known are {}", PLATFORMS.map(|platform| platform.folder).join(", "))
        })
    }

    /// The file extension of its libraries.
    #[must_use]
    pub fn extension(&self) -> &'static str {
        match self.os {
            "windows" => "dll",
            "macos" => "dylib",
            _ => "so",
        }
    }

    /// The platform of an FMU's library.
    ///
    /// # Errors
    /// If the file is not such a library; the message says what it is.
    pub fn of(library: &[u8]) -> Result<&'static Self, String> {
        let file = object::File::parse(library).map_err(|error| format!("it is not a shared library: {error}"))?;
        let os = match file.format() {
            BinaryFormat::Elf => "linux",
            BinaryFormat::Pe => "windows",
            BinaryFormat::MachO => "macos",
            other => return Err(format!("its format is {other:?}, not that of a shared library")),
        };
        let arch = match file.architecture() {
            Architecture::X86_64 => "x86_64",
            Architecture::I386 => "x86",
            Architecture::Aarch64 => "aarch64",
            other => return Err(format!("FMI 2.0 names no folder for binaries of {os} on {other:?}")),
        };
        if file.kind() != ObjectKind::Dynamic {
            return Err(format!("it is not a shared library, but {:?}", file.kind()));
        }
        let exports = file.exports().map_err(|error| format!("its exported symbols cannot be read: {error}"))?;
        // Mach-O puts an underscore before the names of C.
        let names = exports.iter().map(|export| export.name().strip_prefix(b"_").unwrap_or(export.name()));
        let names: std::collections::HashSet<&[u8]> = names.collect();
        if let Some(missing) = FUNCTIONS.iter().find(|function| !names.contains(function.as_bytes())) {
            return Err(format!(
                "it does not export {missing}, so it is not the shared library (cdylib) of a crate with fmi2_export::export!"
            ));
        }
        PLATFORMS
            .iter()
            .find(|platform| (platform.os, platform.arch) == (os, arch))
            .ok_or_else(|| format!("FMI 2.0 names no folder for binaries of {os} on {arch}"))
    }

    /// The platforms of these names, separated by commas.
    ///
    /// # Errors
    /// If a name is unknown; the message lists all platforms.
    pub fn list(names: &str) -> Result<Vec<&'static Self>, String> {
        let mut platforms: Vec<&'static Self> = Vec::new();
        for name in names.split(',').map(str::trim).filter(|name| !name.is_empty()) {
            let platform = Self::named(name)?;
            if !platforms.contains(&platform) {
                platforms.push(platform);
            }
        }
        Ok(platforms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_platforms_are_the_same() {
        for (i, platform) in PLATFORMS.iter().enumerate() {
            assert_eq!(Platform::named(platform.folder), Ok(platform));
            for other in &PLATFORMS[..i] {
                assert!(platform.target != other.target && (platform.os, platform.arch) != (other.os, other.arch));
            }
        }
        let message = Platform::named("linux").unwrap_err();
        assert!(message.contains("linux64") && message.contains("aarch64-darwin"), "{message}");
        let names = Platform::list("win64, linux64,,win64").unwrap();
        assert_eq!(names.iter().map(|platform| platform.folder).collect::<Vec<_>>(), ["win64", "linux64"]);
        assert!(Platform::list("win64,linux").is_err());
    }

    #[test]
    fn what_is_no_library_is_refused_with_what_it_is() {
        for junk in [&b""[..], b"no library", b"\x7fELF", b"MZ"] {
            assert!(Platform::of(junk).unwrap_err().contains("not a shared library"));
        }
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert!(Platform::of(&program).is_err(), "a program");
    }
}
