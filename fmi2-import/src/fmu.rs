//! An `.fmu` file: a zip archive with a description and, per platform, a library.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tempfile::TempDir;

use super::archive::{Archive, ArchiveError};
use super::binary;
use super::description::ModelDescription;
use super::error::{CallError, FmuError};
use super::instance::Instance;
use super::library::{Functions, LibraryError};
use super::platform::FOLDERS;

/// An FMU that is unpacked and loaded. Cheap to clone; the unpacked files vanish with the last user.
#[derive(Clone)]
pub struct Fmu {
    loaded: Arc<Loaded>,
}

/// Fields drop in this order: the library leaves before its file does.
pub(super) struct Loaded {
    pub functions: Functions,
    pub description: ModelDescription,
    pub resources: String,
    path: PathBuf,
    _folder: TempDir,
}

/// An FMU that is unpacked, but not loaded yet: none of its code has run. Whoever runs several FMUs unpacks all before
/// loading one, since loaded code may change what paths mean.
#[derive(Debug)]
pub struct Unpacked {
    description: ModelDescription,
    path: PathBuf,
    /// Its name in the archive, which is also its path below the folder.
    library: String,
    folder: TempDir,
}

/// What is in an FMU's archive.
#[derive(Debug, Clone)]
pub struct Contents {
    /// What it says about itself.
    pub description: ModelDescription,
    /// The paths of all files in it.
    pub files: Vec<String>,
}

impl Contents {
    /// The folders below `binaries`: one per platform there is a library for.
    #[must_use]
    pub fn platforms(&self) -> Vec<&str> {
        let mut platforms: Vec<&str> = self
            .files
            .iter()
            .filter_map(|file| file.strip_prefix("binaries/")?.split_once('/').map(|(folder, _)| folder))
            .collect();
        platforms.dedup(); // the files are sorted
        platforms
    }

    /// Whether there is a file below this folder.
    #[must_use]
    pub fn has(&self, folder: &str) -> bool {
        self.files.iter().any(|file| file.starts_with(folder))
    }
}

impl Fmu {
    /// Reads only the description of an FMU: works for any platform and for model exchange.
    ///
    /// # Errors
    /// When the file is unreadable, not an FMU, or not FMI 2.0.
    pub fn read_description(path: impl AsRef<Path>) -> Result<ModelDescription, FmuError> {
        let path = path.as_ref();
        description(path, &mut archive(path)?)
    }

    /// Reads the description and the names of all files of an FMU: works for any platform and for model exchange.
    ///
    /// # Errors
    /// When the file is unreadable, not an FMU, or not FMI 2.0.
    pub fn inspect(path: impl AsRef<Path>) -> Result<Contents, FmuError> {
        let path = path.as_ref();
        let mut archive = archive(path)?;
        let description = description(path, &mut archive)?;
        let files = archive.files().into_iter().map(str::to_owned).collect();
        Ok(Contents { description, files })
    }

    /// Unpacks an FMU to a temporary folder and loads its library.
    ///
    /// # Errors
    /// When the file is unreadable, not an FMI 2.0 co-simulation FMU, has no library for this platform, or the library
    /// cannot be used.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FmuError> {
        Unpacked::of(path)?.load()
    }

    /// Unpacks several FMUs, and then loads them: what the code of one does to the process cannot change which files the
    /// others are.
    ///
    /// # Errors
    /// As [`Fmu::open`].
    pub fn open_all<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Result<Vec<Self>, FmuError> {
        let unpacked: Vec<_> = paths.into_iter().map(Unpacked::of).collect::<Result<_, _>>()?;
        unpacked.into_iter().map(Unpacked::load).collect()
    }

    /// What the FMU says about itself.
    #[must_use]
    pub fn description(&self) -> &ModelDescription {
        &self.loaded.description
    }

    /// The file it was opened from.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.loaded.path
    }

    /// Creates an instance.
    ///
    /// # Errors
    /// When the FMU refuses, with what it logged.
    pub fn instantiate(&self, name: &str) -> Result<Instance, CallError> {
        Instance::new(Arc::clone(&self.loaded), name)
    }
}

impl Unpacked {
    /// Unpacks an FMU to a temporary folder.
    ///
    /// # Errors
    /// When the file is unreadable, not an FMI 2.0 co-simulation FMU, or has no library for this platform.
    pub fn of(path: impl AsRef<Path>) -> Result<Self, FmuError> {
        let path = path.as_ref();
        let mut archive = archive(path)?;
        let description = description(path, &mut archive)?;
        let Some(interface) = &description.co_simulation else {
            return Err(FmuError::NotCoSimulation { path: path.to_owned() });
        };
        let candidates = libraries(path, &archive, &interface.model_identifier)?;
        let unpack = |source| FmuError::Unpack { path: path.to_owned(), source };
        let folder = tempfile::Builder::new().prefix("fmu-").tempdir().map_err(unpack)?;
        let parts: Vec<String> = candidates.iter().map(|(platform, _)| format!("binaries/{platform}/")).collect();
        let parts: Vec<&str> = parts.iter().map(String::as_str).chain(["resources/"]).collect();
        archive.unpack(folder.path(), &parts).map_err(|error| match error {
            ArchiveError::Read(source) => unpack(source),
            other => of_archive(path, other),
        })?;
        fs::create_dir_all(folder.path().join("resources")).map_err(unpack)?;

        // Folders with older names may have libraries for other processors.
        let mut refused = None;
        for (_, library) in candidates {
            match binary::check_loadable(&fs::read(folder.path().join(&library)).map_err(unpack)?) {
                Ok(()) => return Ok(Self { description, path: path.to_owned(), library, folder }),
                Err(source) => _ = refused.get_or_insert(FmuError::Library { path: path.to_owned(), library, source }),
            }
        }
        Err(refused.unwrap_or_else(|| FmuError::NotCoSimulation { path: path.to_owned() }))
    }

    /// What the FMU says about itself.
    #[must_use]
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// Looks at the library without loading it.
    ///
    /// # Errors
    /// When it is no library, or lacks a function that every co-simulation FMU must have.
    pub fn check_library(&self) -> Result<(), FmuError> {
        let file = self.folder.path().join(&self.library);
        let data = fs::read(&file).map_err(|source| FmuError::Unpack { path: self.path.clone(), source })?;
        let beside = file.parent().and_then(|folder| fs::read_dir(folder).ok()).map_or(0, Iterator::count);
        binary::check_usable(&data, beside <= 1).map_err(|source| self.library_error(source))
    }

    /// Loads the library: the FMU's code runs from now on.
    ///
    /// # Errors
    /// When the library cannot be used.
    pub fn load(self) -> Result<Fmu, FmuError> {
        let functions = match Functions::load(&self.folder.path().join(&self.library)) {
            Ok(functions) => functions,
            Err(source) => return Err(self.library_error(source)),
        };
        Ok(Fmu {
            loaded: Arc::new(Loaded {
                functions,
                description: self.description,
                resources: file_uri(&self.folder.path().join("resources")),
                path: self.path,
                _folder: self.folder,
            }),
        })
    }

    fn library_error(&self, source: LibraryError) -> FmuError {
        FmuError::Library { path: self.path.clone(), library: self.library.clone(), source }
    }
}

fn archive(path: &Path) -> Result<Archive, FmuError> {
    Archive::open(path).map_err(|error| match error {
        ArchiveError::Read(source) => FmuError::Read { path: path.to_owned(), source },
        other => of_archive(path, other),
    })
}

fn of_archive(path: &Path, error: ArchiveError) -> FmuError {
    let path = path.to_owned();
    match error {
        ArchiveError::UnsafeEntry(entry) => FmuError::UnsafeEntry { path, entry },
        ArchiveError::Limit { .. } => FmuError::Limit { path, source: error },
        other => FmuError::NotAZip { path, reason: other.to_string() },
    }
}

fn description(path: &Path, archive: &mut Archive) -> Result<ModelDescription, FmuError> {
    let bytes = archive.read("modelDescription.xml").map_err(|error| match error {
        ArchiveError::NotFound => FmuError::NoDescription { path: path.to_owned() },
        other => of_archive(path, other),
    })?;
    ModelDescription::from_bytes(&bytes).map_err(|source| FmuError::Description { path: path.to_owned(), source })
}

/// The folders of this platform that have the library, the usual one first, and its name in the archive.
fn libraries(path: &Path, archive: &Archive, identifier: &str) -> Result<Vec<(&'static str, String)>, FmuError> {
    const SHOWN: usize = 10;
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

/// The folder as an RFC 3986 `file` URI.
fn file_uri(folder: &Path) -> String {
    use std::fmt::Write;
    let text = folder.to_string_lossy().replace('\\', "/");
    let mut uri = String::from(if text.starts_with('/') { "file://" } else { "file:///" });
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b':' | b'-' | b'_' | b'.' | b'~' => {
                uri.push(char::from(byte));
            }
            _ => write!(uri, "%{byte:02X}").expect("writing to a string cannot fail"),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resource_uris_are_percent_encoded() {
        assert_eq!(file_uri(Path::new("/tmp/a b/ü#")), "file:///tmp/a%20b/%C3%BC%23");
    }
}
