//! Result files that appear complete or not at all.
//!
//! A [`NewFile`] is written beside its destination and moved there at the end; a [`FileSet`] does the same for files that
//! belong together. Links are followed: the target of a link is replaced and the link stays. A replaced file
//! keeps its permissions and owner. Pipes and devices are written to, never replaced. When the process is about to end
//! early, [`abandon`] removes unfinished files; if it has ended without that, another process removes them with
//! [`clean_up_after`].

mod place;
mod set;
mod under_construction;

use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use fmi2_import::archive::plain_file;

pub use place::{absolute, are_same, is_standard_output, remember_surroundings};
pub use set::FileSet;
pub use under_construction::{abandon, clean_up_after, keep_journal};

use place::Place;
use under_construction::Part;

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

/// An unfinished file. It is written beside its destination and moved there by [`NewFile::finish`]. If it is dropped
/// before that, nothing remains.
#[derive(Debug)]
pub struct NewFile {
    path: PathBuf,
    writer: BufWriter<Destination>,
}

#[derive(Debug)]
enum Destination {
    Beside(Part),
    /// Pipes and devices cannot be replaced, only written to.
    Direct(std::fs::File),
}

impl Write for Destination {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Beside(part) => part.write(bytes),
            Self::Direct(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Beside(part) => part.flush(),
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
        const BUFFER: usize = 1 << 16;
        let path = path.into();
        let destination = match Place::of(&path) {
            Ok(Place::Stream(file)) => Ok(Destination::Direct(file)),
            Ok(Place::File(target)) => Part::new(target).map(Destination::Beside),
            Err(error) => Err(error),
        };
        match destination {
            Ok(destination) => Ok(Self { path, writer: BufWriter::with_capacity(BUFFER, destination) }),
            Err(source) => Err(WriteError { path, source }),
        }
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// When not everything could be written.
    pub fn finish(self) -> Result<(), WriteError> {
        let path = self.path.clone();
        let finish = || match self.into_destination()? {
            Destination::Beside(part) => part.checked()?.appear(),
            Destination::Direct(mut file) => file.flush(),
        };
        finish().map_err(|source| WriteError { path, source })
    }

    fn into_destination(self) -> io::Result<Destination> {
        self.writer.into_inner().map_err(io::IntoInnerError::into_error)
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

/// Whether a file's name ends in `.extension`, in small or capital letters.
#[must_use]
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// The text of a regular file of reasonable size. (A pipe would never end.)
///
/// # Errors
/// When it is not such a file, or cannot be read.
pub fn read_text(path: &Path) -> io::Result<String> {
    const MAX_BYTES: u64 = 64 << 20;
    let mut text = String::new();
    plain_file(path)?.take(MAX_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("it has more than {} MiB", MAX_BYTES >> 20)));
    }
    Ok(text)
}

#[cfg(test)]
mod tests;
