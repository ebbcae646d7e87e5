//! Result files that appear whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

/// A file under construction. It is written beside its destination and moved there by [`NewFile::finish`]; dropped
/// before that, it leaves no trace.
#[derive(Debug)]
pub struct NewFile {
    path: PathBuf,
    writer: BufWriter<Destination>,
}

#[derive(Debug)]
enum Destination {
    Beside(NamedTempFile),
    /// Pipes and devices cannot be replaced, only written to.
    Direct(File),
}

impl Write for Destination {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Beside(file) => file.write(bytes),
            Self::Direct(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Beside(file) => file.flush(),
            Self::Direct(file) => file.flush(),
        }
    }
}

impl NewFile {
    /// Begins a file; missing folders are created.
    ///
    /// # Errors
    /// When the place cannot be written to.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, WriteError> {
        let path = path.into();
        match Self::destination(&path) {
            Ok(destination) => Ok(Self { path, writer: BufWriter::with_capacity(1 << 16, destination) }),
            Err(source) => Err(WriteError { path, source }),
        }
    }

    fn destination(path: &Path) -> io::Result<Destination> {
        match fs::metadata(path) {
            Ok(existing) if existing.is_dir() => {
                return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
            }
            Ok(existing) if !existing.is_file() => {
                return OpenOptions::new().write(true).open(path).map(Destination::Direct);
            }
            _ => {}
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        fs::create_dir_all(folder)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(".dualarm-").suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666)); // minus the user's umask, as for any other file
        }
        builder.tempfile_in(folder).map(Destination::Beside)
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// When not everything could be written.
    pub fn finish(self) -> Result<(), WriteError> {
        let Self { path, writer } = self;
        let finish = || match writer.into_inner().map_err(io::IntoInnerError::into_error)? {
            Destination::Beside(file) => file.persist(&path).map(drop).map_err(|error| error.error),
            Destination::Direct(mut file) => file.flush(),
        };
        finish().map_err(|source| WriteError { path: path.clone(), source })
    }

    /// Where the file will be.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes an error of this file's path.
    #[must_use]
    pub fn error(&self, source: io::Error) -> WriteError {
        WriteError { path: self.path.clone(), source }
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Writes a whole file at once, whole or not at all.
///
/// # Errors
/// When it cannot be written.
pub fn write(path: impl Into<PathBuf>, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let mut file = NewFile::create(path)?;
    if let Err(source) = file.write_all(content.as_ref()) {
        return Err(file.error(source));
    }
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_appear_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/a.txt");
        let mut file = NewFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        drop(file);
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 0);

        write(&path, "old").unwrap();
        write(&path, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn errors_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let error = write(folder.path(), "x").unwrap_err().to_string();
        assert!(error.contains("it is a folder") && error.contains(folder.path().to_str().unwrap()), "{error}");
        write(folder.path().join("file"), "x").unwrap();
        let error = write(folder.path().join("file/below"), "x").unwrap_err().to_string();
        assert!(error.starts_with("cannot write"), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_reported_and_devices_are_not_replaced() {
        let error = write("/dev/full", "x").unwrap_err().to_string();
        assert!(error.contains("/dev/full: No space left"), "{error}");
        assert!(!fs::metadata("/dev/full").unwrap().is_file());
    }
}
