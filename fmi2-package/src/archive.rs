//! The zip archive that an `.fmu` file is (FMI 2.0.4, section 2.3).

use std::io::{Cursor, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::PackageError;

/// An archive in the making. The same content always gives the same bytes: entries carry no time of day.
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
        let bytes = self.bytes().map_err(PackageError::file("write", path))?;
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let write = || {
            let mut builder = tempfile::Builder::new();
            #[cfg(unix)]
            {
                use std::os::unix::fs::PermissionsExt;
                builder.permissions(std::fs::Permissions::from_mode(0o666));
            }
            let mut file = builder.tempfile_in(folder)?;
            file.write_all(&bytes)?;
            file.as_file().sync_all()?;
            file.persist(path)?;
            Ok(())
        };
        write().map_err(PackageError::file("write", path))
    }

    fn bytes(&self) -> std::io::Result<Vec<u8>> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644);
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (path, content) in &self.entries {
            zip.start_file(path.as_str(), options)?;
            zip.write_all(content)?;
        }
        Ok(zip.finish()?.into_inner())
    }
}

/// Folder below `binaries/` for libraries of the platform this program was compiled for.
///
/// # Errors
/// If FMI 2.0 names none.
pub fn platform_folder() -> Result<&'static str, PackageError> {
    use std::env::consts::{ARCH, OS};
    Ok(match (OS, ARCH) {
        ("linux", "x86_64") => "linux64",
        ("linux", "x86") => "linux32",
        ("windows", "x86_64") => "win64",
        ("windows", "x86") => "win32",
        ("macos", _) => "darwin64",
        (os, arch) => return Err(PackageError::Platform { os, arch }),
    })
}
