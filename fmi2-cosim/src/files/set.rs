//! Files that belong together.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use super::under_construction::{Part, appear_together};
use super::{Destination, NewFile, WriteError};

/// Files that belong together: all of them appear at their places, or none. If the set is dropped, nothing remains.
#[derive(Debug, Default)]
pub struct FileSet {
    parts: Mutex<Vec<(PathBuf, Part)>>,
}

impl FileSet {
    /// An empty set.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file with this content.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, path: impl Into<PathBuf>, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
        let mut file = NewFile::create(path)?;
        if let Err(source) = file.write_all(content.as_ref()) {
            return Err(file.error(source));
        }
        self.add(file)
    }

    /// Adds a complete file. A pipe or a device has its content from now on.
    ///
    /// # Errors
    /// When not everything could be written.
    pub fn add(&self, file: NewFile) -> Result<(), WriteError> {
        let path = file.path.clone();
        let add = || -> io::Result<()> {
            match file.into_destination()? {
                Destination::Beside(part) => {
                    let mut parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner);
                    parts.push((path.clone(), part.checked()?));
                    Ok(())
                }
                Destination::Direct(mut file) => file.flush(),
            }
        };
        add().map_err(|source| WriteError { path: path.clone(), source })
    }

    /// Moves all files to their places.
    ///
    /// # Errors
    /// When one cannot be moved. Then all files are unchanged.
    pub fn appear(self) -> Result<(), WriteError> {
        let parts = self.parts.into_inner().unwrap_or_else(PoisonError::into_inner);
        let (paths, parts): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
        appear_together(parts).map_err(|(index, source)| WriteError { path: paths[index].clone(), source })
    }
}
