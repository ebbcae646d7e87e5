//! The parts of its archive that an FMU needs: a description, and a library for this platform.

use std::fs;
use std::path::{Path, PathBuf};

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
    let document = archive.read("modelDescription.xml").map_err(|error| match error {
        ArchiveError::NotFound => FmuError::NoDescription { path: path.to_owned() },
        other => of_archive(path, other),
    })?;
    ModelDescription::from_bytes(&document).map_err(|source| FmuError::Description { path: path.to_owned(), source })
}

/// Where the files of an FMU are unpacked.
#[derive(Debug)]
pub(super) struct Unpacked {
    pub folder: TempDir,
    /// There is no other file than the library: it is in the folder itself. Any other FMU has the folders of its archive.
    is_alone: bool,
}

impl Unpacked {
    /// Where a file of the archive is.
    pub fn place(&self, entry: &str) -> PathBuf {
        self.folder.path().join(if self.is_alone { entry.rsplit('/').next().unwrap_or(entry) } else { entry })
    }

    /// The folder of the resources.
    pub fn resources(&self) -> PathBuf {
        // An FMU that brings no resources gets a folder nevertheless.
        if self.is_alone { self.folder.path().to_owned() } else { self.folder.path().join(RESOURCES) }
    }
}

const RESOURCES: &str = "resources";

/// Unpacks all files for this platform, and the resources, to a temporary folder. A library that is alone is put into this
/// folder itself: to remove a folder takes some systems longer than to remove a library.
pub(super) fn unpacked(path: &Path, archive: &mut Archive) -> Result<Unpacked, FmuError> {
    let unpack = |source| FmuError::Unpack { path: path.to_owned(), source };
    let refused = |error| match error {
        ArchiveError::Read(source) => unpack(source),
        other => of_archive(path, other),
    };
    let folder = tempfile::Builder::new().prefix("fmu-").tempdir().map_err(unpack)?;
    let libraries: Vec<String> = FOLDERS.iter().map(|platform| format!("binaries/{platform}/")).collect();
    let parts: Vec<&str> = libraries.iter().map(String::as_str).chain(["resources/"]).collect();
    let files = archive.files_in(&parts);
    if let [only] = &files[..]
        && !archive.has("resources/")
    {
        let unpacked = Unpacked { folder, is_alone: true };
        archive.unpack_file(only, &unpacked.place(only)).map_err(refused)?;
        return Ok(unpacked);
    }
    archive.unpack(folder.path(), &files).map_err(refused)?;
    fs::create_dir_all(folder.path().join(RESOURCES)).map_err(unpack)?;
    Ok(Unpacked { folder, is_alone: false })
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
