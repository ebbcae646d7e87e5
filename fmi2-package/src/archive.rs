//! The zip archive of an `.fmu` file (FMI 2.0.4, section 2.3).

use std::collections::HashMap;
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use crate::{PackageError, document};

/// An archive to be written. The same content always gives the same bytes: entries have no time stamps.
#[derive(Clone, Debug, Default)]
pub struct Archive {
    entries: Vec<(String, Vec<u8>)>,
}

impl Archive {
    /// An empty archive.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file. Paths use `/` and do not start with one, nor with `./`.
    pub fn add(&mut self, path: impl Into<String>, content: &[u8]) {
        self.entries.push((path.into(), content.to_vec()));
    }

    /// Writes the archive. It appears under its name only when it is complete; until then it is a temporary file in the
    /// same folder, which is removed on failure.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), PackageError> {
        self.beside(path.to_owned())?.appear().map(drop)
    }

    /// Writes the archive to a temporary file beside its destination.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn beside(&self, path: PathBuf) -> Result<Finished, PackageError> {
        let bytes = self.bytes().map_err(PackageError::file("write", &path))?;
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let write = || {
            let builder = tempfile::Builder::new();
            #[cfg(unix)]
            let builder = readable_by_others(builder);
            let mut file = builder.tempfile_in(folder)?;
            file.write_all(&bytes)?;
            file.as_file().sync_all()?;
            Ok(file)
        };
        let file = write().map_err(PackageError::file("write", &path))?;
        Ok(Finished { file, path })
    }

    fn bytes(&self) -> std::io::Result<Vec<u8>> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644);
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let mut taken: HashMap<String, &str> = HashMap::new();
        for (path, content) in &self.entries {
            if let Some(other) = taken.insert(path.to_lowercase(), path) {
                let message = format!("{other} and {path} are the same file on some systems; give one another name");
                return Err(std::io::Error::other(message));
            }
            zip.start_file(path.as_str(), options)?;
            zip.write_all(content)?;
        }
        Ok(zip.finish()?.into_inner())
    }
}

/// Gives the file the permissions of any other new file; a temporary file is private to the user.
#[cfg(unix)]
fn readable_by_others(mut builder: tempfile::Builder<'static, 'static>) -> tempfile::Builder<'static, 'static> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(std::fs::Permissions::from_mode(0o666));
    builder
}

/// A complete archive that is not yet at its place. If it is dropped, nothing remains.
#[derive(Debug)]
pub struct Finished {
    file: NamedTempFile,
    path: PathBuf,
}

impl Finished {
    /// Moves it to its place and returns the path.
    ///
    /// # Errors
    /// If it cannot be moved.
    pub fn appear(self) -> Result<PathBuf, PackageError> {
        let Self { file, path } = self;
        match file.persist(&path) {
            Ok(_) => Ok(path),
            Err(error) => Err(PackageError::file("write", &path)(error.error)),
        }
    }
}

/// The content of a regular file. Opening a pipe would block.
pub(crate) fn plain_file(path: &Path) -> std::io::Result<Vec<u8>> {
    let kind = std::fs::metadata(path)?;
    if !kind.is_file() && !kind.is_dir() {
        return Err(std::io::Error::other("it is a pipe or a device, not a file"));
    }
    std::fs::read(path)
}

/// The files of an archive.
///
/// # Errors
/// If it cannot be read.
pub fn read(path: &Path) -> Result<Vec<(String, Vec<u8>)>, PackageError> {
    let failed = |source: std::io::Error| PackageError::file("read", path)(source);
    let content = plain_file(path).map_err(failed)?;
    let mut zip = ZipArchive::new(Cursor::new(content)).map_err(|error| failed(error.into()))?;
    let mut files = Vec::new();
    for i in 0..zip.len() {
        let mut entry = zip.by_index(i).map_err(|error| failed(error.into()))?;
        let name = entry.name().map_err(|error| failed(error.into()))?.into_owned();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).map_err(failed)?;
        files.push((name, content));
    }
    Ok(files)
}

/// Refuses to replace the archive of a model of another crate, and an archive whose name differs only in upper and lower
/// case.
///
/// # Errors
/// If there is such an archive in the folder.
pub fn check_target(folder: &Path, model: &str, package: &str) -> Result<(), PackageError> {
    let wanted = format!("{model}.fmu");
    let entries = std::fs::read_dir(folder).map_err(PackageError::file("read", folder))?;
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if !name.eq_ignore_ascii_case(&wanted) {
            continue;
        }
        // A file that is not an archive, or does not name its crate, may be replaced.
        let files = read(&path).unwrap_or_default();
        let page =
            files.iter().find(|(name, _)| name == document::INDEX).map(|(_, page)| String::from_utf8_lossy(page));
        match page.as_deref().and_then(document::crate_of) {
            Some(other) if other != package => {
                return Err(PackageError::Taken { whose: format!("of the crate {other}"), path });
            }
            _ if name != wanted => {
                let whose = format!("not {wanted}, but some systems take both names for the same");
                return Err(PackageError::Taken { whose, path });
            }
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_that_some_systems_take_for_one_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut archive = Archive::new();
        archive.add("resources/table.txt", b"1");
        archive.write(&folder.path().join("a.fmu")).unwrap();
        archive.add("resources/Table.txt", b"2");
        let message = archive.write(&folder.path().join("b.fmu")).unwrap_err().to_string();
        assert!(
            message.contains("resources/table.txt and resources/Table.txt are the same file on some systems"),
            "{message}"
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
