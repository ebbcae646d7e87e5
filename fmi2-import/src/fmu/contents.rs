//! The parts of its archive that an FMU needs: a description, and a library for this platform.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

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

/// The folder of libraries that are alone, if they share one.
static SHARED: OnceLock<PathBuf> = OnceLock::new();

/// How many libraries have been put there.
static GUESTS: AtomicU64 = AtomicU64::new(0);

/// From now on, libraries that are alone are unpacked to this folder. The first call counts.
pub(super) fn share(folder: PathBuf) {
    // An FMU may change the current folder. Whoever comes second has lost nothing.
    let _ = SHARED.set(std::path::absolute(&folder).unwrap_or(folder));
}

/// Where the files of an FMU are unpacked. They are removed with it.
#[derive(Debug)]
pub(super) enum Unpacked {
    /// In the folders of the archive, below this one.
    Folders(TempDir),
    /// There is no other file than the library: it is in this folder itself.
    Alone(TempDir),
    /// The same in a folder that is somebody else's, which has other files, too.
    Guest(Guest),
}

/// A file that is removed at the end.
#[derive(Debug)]
pub(super) struct Guest(PathBuf);

impl Drop for Guest {
    fn drop(&mut self) {
        // If that fails, it is removed with its folder.
        let _ = fs::remove_file(&self.0);
    }
}

impl Unpacked {
    /// Where a file of the archive is.
    pub fn place(&self, entry: &str) -> PathBuf {
        match self {
            Self::Folders(folder) => folder.path().join(entry),
            Self::Alone(folder) => folder.path().join(name(entry)),
            Self::Guest(Guest(library)) => library.clone(),
        }
    }

    /// The folder of the resources. An FMU that brings no resources gets a folder nevertheless.
    pub fn resources(&self) -> PathBuf {
        match self {
            Self::Folders(folder) => folder.path().join(RESOURCES),
            Self::Alone(folder) => folder.path().to_owned(),
            Self::Guest(Guest(library)) => library.with_file_name(RESOURCES),
        }
    }
}

/// The name of an entry without its folders.
fn name(entry: &str) -> &str {
    entry.rsplit('/').next().unwrap_or(entry)
}

const RESOURCES: &str = "resources";

/// Whether there is an empty folder for guests to take for their resources: libraries and other files are not within their reach.
fn no_resources(shared: &Path) -> bool {
    match fs::create_dir(shared.join(RESOURCES)) {
        Ok(()) => true,
        Err(error) => error.kind() == io::ErrorKind::AlreadyExists,
    }
}

/// Unpacks all files for this platform, and the resources, to a temporary folder. A library that is alone is put into this
/// folder itself, or into that which libraries share: to remove a folder takes some systems longer than to remove a library.
pub(super) fn unpacked(path: &Path, archive: &mut Archive) -> Result<Unpacked, FmuError> {
    let unpack = |source| FmuError::Unpack { path: path.to_owned(), source };
    let refused = |error| match error {
        ArchiveError::Read(source) => unpack(source),
        other => of_archive(path, other),
    };
    let libraries: Vec<String> = FOLDERS.iter().map(|platform| format!("binaries/{platform}/")).collect();
    let parts: Vec<&str> = libraries.iter().map(String::as_str).chain(["resources/"]).collect();
    let files = archive.files_in(&parts);
    let alone = match &files[..] {
        [only] if !archive.has("resources/") => Some(only),
        _ => None,
    };
    if let (Some(only), Some(shared)) = (alone, SHARED.get()) {
        // The loader takes a library for one of the same path that it has not quite let go.
        let number = GUESTS.fetch_add(1, Ordering::Relaxed);
        let library = shared.join(format!("{number}-{}", name(only)));
        // If that cannot be, it gets a folder of its own, or that says why not.
        if let (true, Ok(mut file)) = (no_resources(shared), File::create_new(&library)) {
            let guest = Guest(library);
            archive.unpack_into(only, &mut file).map_err(refused)?;
            return Ok(Unpacked::Guest(guest));
        }
    }
    let folder = tempfile::Builder::new().prefix("fmu-").tempdir().map_err(unpack)?;
    if let Some(only) = alone {
        archive.unpack_file(only, &folder.path().join(name(only))).map_err(refused)?;
        return Ok(Unpacked::Alone(folder));
    }
    archive.unpack(folder.path(), &files).map_err(refused)?;
    fs::create_dir_all(folder.path().join(RESOURCES)).map_err(unpack)?;
    Ok(Unpacked::Folders(folder))
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
