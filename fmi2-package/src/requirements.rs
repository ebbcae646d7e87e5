//! The requirements of a library on the system that loads it: `documentation/externalDependencies.txt` (FMI 2.0.4, section
//! 2.3).

use std::collections::BTreeSet;
use std::fmt::Write as _;

use object::read::elf::{Dyn, ElfFile64};
use object::{Endianness, File, Object, elf};

use crate::platform::Platform;

/// The path of this file in an archive.
pub const PATH: &str = "documentation/externalDependencies.txt";

/// The requirements of a library on the system that loads it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Requirements {
    /// The oldest glibc that has all functions it needs.
    pub glibc: Option<(u32, u32)>,
    /// Shared libraries by their file names, sorted.
    pub libraries: Vec<String>,
}

impl Requirements {
    /// The requirements of a library; empty for formats other than ELF and PE.
    #[must_use]
    pub fn of(library: &[u8]) -> Self {
        match File::parse(library) {
            Ok(File::Elf64(file)) => of_elf(&file, library).unwrap_or_default(),
            Ok(file) => {
                let imports = file.imports().unwrap_or_default();
                let names = imports.iter().map(|import| String::from_utf8_lossy(import.library()).into_owned());
                let libraries: BTreeSet<String> = names.filter(|name| !name.is_empty()).collect();
                Self { glibc: None, libraries: libraries.into_iter().collect() }
            }
            Err(_) => Self::default(),
        }
    }
}

/// The entries that the loader reads: `DT_NEEDED`, and the versions required of each library.
fn of_elf(file: &ElfFile64<'_, Endianness>, data: &[u8]) -> object::Result<Requirements> {
    let (endian, sections) = (file.endian(), file.elf_section_table());
    let mut found = Requirements::default();
    if let Some((entries, strings)) = sections.dynamic(endian, data)? {
        let strings = sections.strings(endian, data, strings)?;
        for entry in entries.iter().filter(|entry| entry.tag32(endian) == Some(elf::DT_NEEDED)) {
            found.libraries.push(String::from_utf8_lossy(entry.string(endian, strings)?).into_owned());
        }
        found.libraries.sort();
    }
    if let Some((mut files, strings)) = sections.gnu_verneed(endian, data)? {
        let strings = sections.strings(endian, data, strings)?;
        while let Some((_, mut versions)) = files.next()? {
            while let Some(version) = versions.next()? {
                found.glibc = found.glibc.max(glibc(version.name(endian, strings)?));
            }
        }
    }
    Ok(found)
}

/// `GLIBC_2.17` is version 2.17; other names belong to other libraries.
fn glibc(name: &[u8]) -> Option<(u32, u32)> {
    let version = std::str::from_utf8(name).ok()?.strip_prefix("GLIBC_")?;
    let mut parts = version.split('.').map(|part| part.parse().ok());
    Some((parts.next()??, parts.next().unwrap_or(Some(0))?))
}

/// The file for these libraries.
#[must_use]
pub fn text(libraries: &[(&'static Platform, &[u8])]) -> String {
    let mut text = String::from(
        "What this FMU needs of the computer that loads it. All else is inside: no other tool, no licence, no network.\n",
    );
    for (platform, library) in libraries {
        let needed = Requirements::of(library);
        let _ = write!(text, "\n{}\n  processor: {}\n  system: ", platform.folder, processor(platform));
        let _ = match (platform.os, needed.glibc) {
            ("linux", Some((major, minor))) => writeln!(text, "Linux with glibc {major}.{minor} or newer"),
            ("linux", None) => writeln!(text, "Linux"),
            ("windows", _) => writeln!(text, "Windows 10 or newer"),
            // The oldest that Rust's standard library is made for.
            ("macos", _) if platform.arch == "x86_64" => writeln!(text, "macOS 10.12 or newer"),
            _ => writeln!(text, "macOS 11.0 or newer"),
        };
        if !needed.libraries.is_empty() {
            let _ = writeln!(text, "  libraries of the system: {}", needed.libraries.join(", "));
        }
    }
    text
}

fn processor(platform: &Platform) -> &'static str {
    match platform.arch {
        "x86_64" => "64-bit x86 (any; wider vector units are used where there are some)",
        "x86" => "32-bit x86 with SSE2",
        _ => "64-bit ARM",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_of_glibc_are_numbers() {
        assert_eq!(glibc(b"GLIBC_2.17"), Some((2, 17)));
        assert_eq!(glibc(b"GLIBC_2.2.5"), Some((2, 2)));
        assert!(glibc(b"GLIBC_2.34") > glibc(b"GLIBC_2.4"));
        for other in [&b"GCC_3.0"[..], b"GLIBC_PRIVATE", b"GLIBC_"] {
            assert_eq!(glibc(other), None);
        }
    }

    #[test]
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    fn what_a_program_of_this_system_needs_is_seen() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        let needed = Requirements::of(&program);
        assert!(needed.glibc >= Some((2, 2)) && needed.libraries.iter().any(|name| name == "libc.so.6"), "{needed:?}");
        let platform = Platform::here().unwrap();
        let text = text(&[(platform, &program)]);
        assert!(text.contains("libc.so.6") && text.contains("or newer"), "{text}");
        assert_eq!(Requirements::of(b"no library"), Requirements::default());
    }
}
