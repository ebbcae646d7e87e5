//! An `.fmu` file: a zip archive with a description and, per platform, a library.

use std::fs::{self, File};
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tempfile::TempDir;
use zip::ZipArchive;
use zip::result::ZipError;

use super::description::ModelDescription;
use super::error::{CallError, FmuError};
use super::instance::Instance;
use super::library::Functions;

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

/// Platform folders this process can load from, the usual one first.
const PLATFORMS: &[&str] = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    &["linux64", "x86_64-linux"]
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    &["linux64", "aarch64-linux"]
} else if cfg!(target_os = "linux") {
    &["linux32"]
} else if cfg!(target_os = "macos") {
    &["darwin64", "aarch64-darwin", "x86_64-darwin"]
} else if cfg!(all(windows, target_pointer_width = "64")) {
    &["win64", "x86_64-windows"]
} else {
    &["win32"]
};

/// The folder below `binaries/` that FMI 2.0 has for this platform.
#[must_use]
pub fn platform() -> &'static str {
    PLATFORMS[0]
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
        let mut files: Vec<_> =
            archive.file_names().flatten().filter(|name| !name.ends_with('/')).map(Into::into).collect();
        files.sort_unstable();
        Ok(Contents { description, files })
    }

    /// Unpacks an FMU to a temporary folder and loads its library.
    ///
    /// # Errors
    /// When the file is unreadable, not an FMI 2.0 co-simulation FMU, has no library for this platform, or the library
    /// cannot be used.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FmuError> {
        let path = path.as_ref();
        let mut archive = archive(path)?;
        let description = description(path, &mut archive)?;
        let Some(interface) = &description.co_simulation else {
            return Err(FmuError::NotCoSimulation { path: path.to_owned() });
        };
        let (platform, library) = find_library(path, &archive, &interface.model_identifier)?;

        let unpack = |source| FmuError::Unpack { path: path.to_owned(), source };
        let folder = tempfile::Builder::new().prefix("fmi2-import-").tempdir().map_err(unpack)?;
        extract(path, &mut archive, folder.path(), &[&format!("binaries/{platform}/"), "resources/"])?;
        let resources = folder.path().join("resources");
        fs::create_dir_all(&resources).map_err(unpack)?;

        let functions = Functions::load(&folder.path().join(&library)).map_err(|source| FmuError::Library {
            path: path.to_owned(),
            library,
            source,
        })?;
        Ok(Self {
            loaded: Arc::new(Loaded {
                functions,
                description,
                resources: file_uri(&resources),
                path: path.to_owned(),
                _folder: folder,
            }),
        })
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

type Archive = ZipArchive<BufReader<File>>;

fn archive(path: &Path) -> Result<Archive, FmuError> {
    let read = |source| FmuError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(read)?;
    if file.metadata().map_err(read)?.is_dir() {
        return Err(read(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder")));
    }
    ZipArchive::new(BufReader::new(file)).map_err(|error| match error {
        ZipError::Io(source) if source.kind() != io::ErrorKind::UnexpectedEof => read(source),
        other => FmuError::NotAZip { path: path.to_owned(), reason: other.to_string() },
    })
}

fn description(path: &Path, archive: &mut Archive) -> Result<ModelDescription, FmuError> {
    let mut bytes = Vec::new();
    match archive.by_name("modelDescription.xml") {
        Ok(mut entry) => entry
            .read_to_end(&mut bytes)
            .map_err(|error| FmuError::NotAZip { path: path.to_owned(), reason: error.to_string() })?,
        Err(ZipError::FileNotFound) => return Err(FmuError::NoDescription { path: path.to_owned() }),
        Err(error) => return Err(FmuError::NotAZip { path: path.to_owned(), reason: error.to_string() }),
    };
    ModelDescription::from_bytes(&bytes).map_err(|source| FmuError::Description { path: path.to_owned(), source })
}

/// The library's platform folder and its name in the archive.
fn find_library(path: &Path, archive: &Archive, identifier: &str) -> Result<(&'static str, String), FmuError> {
    let file = format!("{identifier}{}", std::env::consts::DLL_SUFFIX);
    let entry = |platform: &str| format!("binaries/{platform}/{file}");
    if let Some(&platform) = PLATFORMS.iter().find(|platform| archive.index_for_name(&entry(platform)).is_some()) {
        return Ok((platform, entry(platform)));
    }
    let mut available: Vec<_> =
        archive.file_names().flatten().filter(|name| name.starts_with("binaries/") && !name.ends_with('/')).collect();
    available.sort_unstable();
    Err(FmuError::NoBinary {
        path: path.to_owned(),
        wanted: entry(PLATFORMS[0]),
        available: if available.is_empty() { "none".into() } else { available.join(", ") },
    })
}

/// Unpacks the entries below `parts`. Symbolic links become plain files, so nothing can point outside.
fn extract(path: &Path, archive: &mut Archive, folder: &Path, parts: &[&str]) -> Result<(), FmuError> {
    let unpack = |source| FmuError::Unpack { path: path.to_owned(), source };
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(|error| unpack(io::Error::other(error)))?;
        let name = entry.name().map_err(|error| unpack(io::Error::other(error)))?.into_owned();
        let Some(inside) = entry.enclosed_name() else {
            return Err(FmuError::UnsafeEntry { path: path.to_owned(), entry: name });
        };
        if entry.is_dir() || !parts.iter().any(|part| name.starts_with(part)) {
            continue;
        }
        let target = folder.join(inside);
        if let Some(parent) = target.parent() {
            fs::create_dir_all(parent).map_err(unpack)?;
        }
        let mut file = File::create(&target).map_err(unpack)?;
        io::copy(&mut entry, &mut file).map_err(unpack)?;
    }
    Ok(())
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
