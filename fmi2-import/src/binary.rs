//! Checks of a shared library as a file, without loading it and so without running its code.

use object::read::elf::{FileHeader, ProgramHeader};
use object::read::macho::{FatArch, MachOFatFile32, MachOFatFile64};
use object::{Architecture, BinaryFormat, Endianness, File, FileKind, Object, ReadRef, elf};

use super::library::{LibraryError, REQUIRED};

/// Checks that the system's loader can load these bytes: they are for this system and this processor, and
/// complete according to their headers. (The loader would map a truncated file, and the process would die at the
/// first access beyond its end.) The loader itself refuses a file that is not a library. Only headers and tables of symbols
/// are read.
pub(crate) fn check_loadable<'data>(data: impl ReadRef<'data>) -> Result<(), LibraryError> {
    if data.len() == Ok(0) {
        return Err(LibraryError::Empty);
    }
    let Ok(kind) = FileKind::parse(data) else { return Ok(()) };
    check_complete(kind, data)?;
    let Some((format, architecture)) = machine(kind, data) else {
        // It supports several processors, but not this one; or it is damaged, which the loader reports.
        let is_for_several = matches!(kind, FileKind::MachOFat32 | FileKind::MachOFat64);
        let foreign = || LibraryError::Foreign { found: "macOS (Mach-O) on others".into(), wanted: native_name() };
        return if is_for_several { Err(foreign()) } else { Ok(()) };
    };
    let processor = native_architecture();
    let fits = format == native_format() && (processor == Architecture::Unknown || architecture == processor);
    if fits { Ok(()) } else { Err(LibraryError::Foreign { found: name(format, architecture), wanted: native_name() }) }
}

/// The same, and checks that the library has the functions that every co-simulation FMU must have. `is_alone`: no
/// other libraries beside it can provide them.
pub(crate) fn check_usable(data: &[u8], is_alone: bool) -> Result<(), LibraryError> {
    check_loadable(data)?;
    let Ok(kind) = FileKind::parse(data) else { return Err(LibraryError::NoLibrary) };
    let Some(file) = native_part(kind, data) else { return Err(LibraryError::NoLibrary) };
    let Ok(exports) = file.exports() else { return Err(LibraryError::NoLibrary) };
    // An ELF file without sections does not show its symbols; only the loader finds them.
    if !is_alone || (exports.is_empty() && file.sections().next().is_none()) {
        return Ok(());
    }
    let has = |name: &str| {
        exports.iter().any(|export| {
            let found = export.name();
            found == name.as_bytes() || found.strip_prefix(b"_") == Some(name.as_bytes())
        })
    };
    match REQUIRED.iter().find(|name| !has(name)) {
        Some(name) => Err(LibraryError::MissingSymbol(name)),
        None => Ok(()),
    }
}

/// What the library is for; of a library for several processors, the part for this one.
fn machine<'data, R: ReadRef<'data>>(kind: FileKind, data: R) -> Option<(BinaryFormat, Architecture)> {
    match kind {
        FileKind::MachOFat32 | FileKind::MachOFat64 => {
            of_several(kind, data).map(|part| (part.format(), part.architecture()))
        }
        _ => File::parse(data).ok().map(|file| (file.format(), file.architecture())),
    }
}

/// The library, or the part for this processor of a library for several processors.
fn native_part(kind: FileKind, data: &[u8]) -> Option<File<'_>> {
    match kind {
        FileKind::MachOFat32 | FileKind::MachOFat64 => of_several(kind, data),
        _ => File::parse(data).ok(),
    }
}

/// The part for this processor.
fn of_several<'data, R: ReadRef<'data>>(kind: FileKind, data: R) -> Option<File<'data>> {
    match kind {
        FileKind::MachOFat32 => part(MachOFatFile32::parse(data).ok()?.arches(), data),
        _ => part(MachOFatFile64::parse(data).ok()?.arches(), data),
    }
}

fn part<'data, R: ReadRef<'data>>(parts: &[impl FatArch], data: R) -> Option<File<'data>> {
    let own = parts.iter().find(|part| part.architecture() == native_architecture())?;
    File::parse(own.data(data).ok()?).ok()
}

fn check_complete<'data>(kind: FileKind, data: impl ReadRef<'data>) -> Result<(), LibraryError> {
    let Ok(length) = data.len() else { return Ok(()) };
    let promised = match kind {
        FileKind::Elf64 => end_of::<elf::FileHeader64<Endianness>, _>(data),
        FileKind::Elf32 => end_of::<elf::FileHeader32<Endianness>, _>(data),
        _ => None,
    };
    match promised {
        Some(promised) if promised > length => Err(LibraryError::CutOff { length, promised }),
        _ => Ok(()),
    }
}

/// Where the last segment of an ELF file ends.
fn end_of<'data, H: FileHeader, R: ReadRef<'data>>(data: R) -> Option<u64> {
    let header = H::parse(data).ok()?;
    let endian = header.endian().ok()?;
    let segments = header.program_headers(endian, data).ok()?;
    segments.iter().map(|segment| segment.p_offset(endian).into().saturating_add(segment.p_filesz(endian).into())).max()
}

fn name(format: BinaryFormat, architecture: Architecture) -> String {
    let system = match format {
        BinaryFormat::Elf => "Linux (ELF)",
        BinaryFormat::MachO => "macOS (Mach-O)",
        BinaryFormat::Pe | BinaryFormat::Coff => "Windows (PE)",
        _ => "another system",
    };
    let processor = match architecture {
        Architecture::X86_64 => "x86_64".to_owned(),
        Architecture::I386 => "x86".to_owned(),
        Architecture::Aarch64 => "aarch64".to_owned(),
        other => format!("{other:?}"),
    };
    format!("{system} on {processor}")
}

fn native_name() -> String {
    name(native_format(), native_architecture())
}

fn native_format() -> BinaryFormat {
    if cfg!(windows) {
        BinaryFormat::Pe
    } else if cfg!(target_os = "macos") {
        BinaryFormat::MachO
    } else {
        BinaryFormat::Elf
    }
}

fn native_architecture() -> Architecture {
    match std::env::consts::ARCH {
        "x86_64" => Architecture::X86_64,
        "x86" => Architecture::I386,
        "aarch64" => Architecture::Aarch64,
        "arm" => Architecture::Arm,
        "riscv64" => Architecture::Riscv64,
        _ => Architecture::Unknown,
    }
}
