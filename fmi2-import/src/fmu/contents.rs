//! The parts of its archive that an FMU needs: a description, and a library for this platform.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::archive::{Archive, ArchiveError};
use crate::description::ModelDescription;
use crate::error::FmuError;
use crate::platform::FOLDERS;

/// The archive of a file.
pub(super) fn archive(path: &Path) -> Result<Archive, FmuError> {
    Archive::open(path).map_err(|error| match error {
        ArchiveError::Read(source) => FmuError::Read { path: path.to_owned(), source },
        other => of_archive(path, other),
    })
}

/// Converts an error of an archive to one of the FMU.
pub(super) fn of_archive(path: &Path, error: ArchiveError) -> FmuError {
    let path = path.to_owned();
    match error {
        ArchiveError::UnsafeEntry(entry) => FmuError::UnsafeEntry { path, entry },
        ArchiveError::Limit { .. } => FmuError::Limit { path, source: error },
        other => FmuError::NotAZip { path, reason: other.to_string() },
    }
}

/// The description in it.
pub(super) fn description(path: &Path, archive: &mut Archive) -> Result<ModelDescription, FmuError> {
    parsed(path, &document(path, archive)?)
}

/// The description in it as a document.
pub(super) fn document(path: &Path, archive: &mut Archive) -> Result<Vec<u8>, FmuError> {
    archive.read("modelDescription.xml").map_err(|error| match error {
        ArchiveError::NotFound => FmuError::NoDescription { path: path.to_owned() },
        other => of_archive(path, other),
    })
}

/// The description that a document is.
pub(super) fn parsed(path: &Path, document: &[u8]) -> Result<ModelDescription, FmuError> {
    ModelDescription::from_bytes(document).map_err(|source| FmuError::Description { path: path.to_owned(), source })
}

/// Unpacks all files for this platform, and the resources, to a temporary folder.
pub(super) fn unpacked(path: &Path, archive: &mut Archive) -> Result<TempDir, FmuError> {
    let unpack = |source| FmuError::Unpack { path: path.to_owned(), source };
    let folder = tempfile::Builder::new().prefix("fmu-").tempdir().map_err(unpack)?;
    let mut parts: Vec<String> = FOLDERS.iter().map(|platform| format!("binaries/{platform}/")).collect();
    parts.retain(|part| archive.files().iter().any(|file| file.starts_with(part)));
    if parts.is_empty() {
        // The FMU will be refused.
        return Ok(folder);
    }
    let parts: Vec<&str> = parts.iter().map(String::as_str).chain(["resources/"]).collect();
    archive.unpack(folder.path(), &parts).map_err(|error| match error {
        ArchiveError::Read(source) => unpack(source),
        other => of_archive(path, other),
    })?;
    fs::create_dir_all(folder.path().join("resources")).map_err(unpack)?;
    Ok(folder)
}

/// The folders of this platform that have the library, the preferred one first, and its name in the archive.
pub(super) fn candidates(
    path: &Path,
    archive: &Archive,
    description: &ModelDescription,
) -> Result<Vec<(&'static str, String)>, FmuError> {
    const SHOWN: usize = 10;
    let Some(interface) = &description.co_simulation else {
        return Err(FmuError::NotCoSimulation { path: path.to_owned() });
    };
    let identifier = &interface.model_identifier;
    let file = format!("{identifier}{}", std::env::consts::DLL_SUFFIX);
    let entry = |platform: &str| format!("binaries/{platform}/{file}");
    let found: Vec<_> =
        FOLDERS.iter().map(|platform| (*platform, entry(platform))).filter(|(_, entry)| archive.has(entry)).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let mut available: Vec<_> = archive.files().into_iter().filter(|name| name.starts_with("binaries/")).collect();
    if available.len() > SHOWN {
        available.truncate(SHOWN);
        available.push("…");
    }
    Err(FmuError::NoBinary {
        path: path.to_owned(),
        wanted: entry(FOLDERS[0]),
        available: if available.is_empty() { "none".into() } else { available.join(", ") },
    })
}
