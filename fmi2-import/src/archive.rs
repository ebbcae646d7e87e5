//! Zip archives, with limits so that a small file cannot fill memory or disk. The readers of FMUs and of SSP files share
//! this module; it is not part of the stable interface.

mod directory;
mod whole;

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use zip::ZipArchive;
use zip::result::ZipError;

/// Entries of an archive.
pub const MAX_ENTRIES: usize = 100_000;
/// Bytes that an archive may unpack to.
pub const MAX_UNPACKED: u64 = 4 << 30;
/// Bytes that every archive may unpack to, however small it is.
pub const FREE_UNPACKED: u64 = 64 << 20;
/// Beyond [`FREE_UNPACKED`], an archive may unpack to this multiple of its own size. Deflate can reach 1000 times.
pub const MAX_RATIO: u64 = 200;
/// Bytes of an entry that is read into memory.
pub const MAX_DOCUMENT: u64 = 256 << 20;

/// Bytes that are read from an archive, or written to a file, at once.
const BUFFER: usize = 1 << 16;

/// Why an archive, or an entry of it, cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// No zip archive, or a damaged one.
    #[error("{0}")]
    NotAZip(String),
    /// The entry does not exist.
    #[error("there is no such file in the archive")]
    NotFound,
    /// An entry would land outside the folder it is unpacked to.
    #[error("it contains the entry \"{0}\", which points outside the archive; not unpacked")]
    UnsafeEntry(String),
    /// Two entries have one name.
    #[error("it contains the entry \"{0}\" twice, and only one of them could be used; not unpacked")]
    SameName(String),
    /// Two entries are the same file.
    #[error("its entries \"{first}\" and \"{second}\" are the same file here; one of them would be lost")]
    Twice {
        /// One entry.
        first: String,
        /// The other one.
        second: String,
    },
    /// It exceeds a limit that no model needs to exceed.
    #[error("{what}; this tool unpacks {limit}")]
    Limit {
        /// The limited quantity.
        what: String,
        /// The limit.
        limit: String,
    },
}

/// An open archive. Paths of entries have `/` between folders, whatever the archive uses.
pub struct Archive {
    zip: ZipArchive<BufReader<File>>,
    indices: HashMap<String, usize>,
    /// Bytes it may still unpack to.
    allowance: u64,
    /// Bytes it may unpack to in total.
    most: u64,
    /// Buffer for copying.
    buffer: Vec<u8>,
    /// Whether an entry was not what the archive says of it: then all others are streams.
    is_untrue: bool,
}

type Result<T> = std::result::Result<T, ArchiveError>;

impl Archive {
    /// Opens a file.
    ///
    /// # Errors
    /// When it cannot be read, is not a regular file or not a zip archive, has too many entries, has an entry outside of
    /// its folder, or several for one file.
    pub fn open(path: &Path) -> Result<Self> {
        let file = plain_file(path)?;
        let length = file.metadata()?.len();
        let mut zip = ZipArchive::new(BufReader::with_capacity(BUFFER, file)).map_err(|error| match error {
            ZipError::Io(source) if source.kind() != io::ErrorKind::UnexpectedEof => ArchiveError::Read(source),
            other => ArchiveError::NotAZip(other.to_string()),
        })?;
        if zip.len() > MAX_ENTRIES {
            let what = format!("it has {} entries", zip.len());
            return Err(ArchiveError::Limit { what, limit: format!("{MAX_ENTRIES} at most") });
        }
        if let Some(name) = directory::named_twice(path, zip.central_directory_start(), zip.len())? {
            return Err(ArchiveError::SameName(String::from_utf8_lossy(&name).into_owned()));
        }
        let mut indices = HashMap::with_capacity(zip.len());
        for index in 0..zip.len() {
            // From the directory of the archive: asking every entry itself takes a while if there are many.
            let name = match zip.name_for_index(index) {
                Some(Ok(name)) => name.into_owned(),
                _ => String::from_utf8_lossy(zip.by_index_raw(index).map_err(damaged)?.name_raw()).into_owned(),
            };
            let Some(path) = inside(&name) else { return Err(ArchiveError::UnsafeEntry(name)) };
            if path.is_empty() {
                continue;
            }
            if let Some(twice) = indices.insert(path, index).filter(|_| !name.ends_with(['/', '\\'])) {
                let first = zip.name_for_index(twice).and_then(|name| Some(name.ok()?.into_owned()));
                return Err(ArchiveError::Twice { first: first.unwrap_or_default(), second: name });
            }
        }
        let most = MAX_UNPACKED.min(FREE_UNPACKED.saturating_add(length.saturating_mul(MAX_RATIO)));
        Ok(Self { zip, indices, allowance: most, most, buffer: vec![0; BUFFER], is_untrue: false })
    }

    /// The paths of all files, sorted.
    #[must_use]
    pub fn files(&self) -> Vec<&str> {
        let mut files: Vec<_> = self.indices.keys().map(String::as_str).filter(|path| !path.ends_with('/')).collect();
        files.sort_unstable();
        files
    }

    /// Whether this file exists.
    #[must_use]
    pub fn has(&self, path: &str) -> bool {
        self.indices.contains_key(path)
    }

    /// Content of a file that fits into memory.
    ///
    /// # Errors
    /// When there is no such file, it is damaged, or too large.
    pub fn read(&mut self, path: &str) -> Result<Vec<u8>> {
        self.content(path, MAX_DOCUMENT)
    }

    /// Content of a library, which may be larger than a document.
    ///
    /// # Errors
    /// As [`Archive::read`].
    pub fn read_large(&mut self, path: &str) -> Result<Vec<u8>> {
        self.content(path, u64::MAX)
    }

    fn content(&mut self, path: &str, most: u64) -> Result<Vec<u8>> {
        let index = *self.indices.get(path).ok_or(ArchiveError::NotFound)?;
        if let Some(content) = self.whole(index, most) {
            return Ok(content);
        }
        // Room for what the archive promises, if that is plausible: content that grows little by little is copied again and again.
        let promised = self.zip.by_index_data(index).map_or(0, |entry| entry.size().min(FREE_UNPACKED));
        let mut content = Vec::with_capacity(usize::try_from(promised).unwrap_or(0));
        self.stream(index, most, path, &mut content)?;
        Ok(content)
    }

    /// Writes a file to `target`.
    ///
    /// # Errors
    /// When there is no such file, it is damaged or too large, or cannot be written.
    pub fn unpack_file(&mut self, path: &str, target: &Path) -> Result<()> {
        let index = *self.indices.get(path).ok_or(ArchiveError::NotFound)?;
        self.unpack_entry(index, path, target)
    }

    /// Writes a file to one that has just been made.
    ///
    /// # Errors
    /// When there is no such file in the archive, it is damaged or too large, or cannot be written.
    pub fn unpack_into(&mut self, path: &str, target: &mut File) -> Result<()> {
        let index = *self.indices.get(path).ok_or(ArchiveError::NotFound)?;
        self.copy(index, u64::MAX, path, target)
    }

    /// The files below `parts`, in the order of the archive.
    #[must_use]
    pub fn files_in(&self, parts: &[&str]) -> Vec<String> {
        let wanted = |path: &&String| !path.ends_with('/') && parts.iter().any(|part| path.starts_with(part));
        let mut files: Vec<_> = self.indices.iter().filter(|(path, _)| wanted(path)).collect();
        files.sort_unstable_by_key(|(_, index)| **index);
        files.into_iter().map(|(path, _)| path.clone()).collect()
    }

    /// Unpacks files to a folder, each to its path there. Symbolic links become plain files, so nothing can point outside.
    ///
    /// # Errors
    /// When there is no such file, it is damaged, too large, or cannot be written.
    pub fn unpack(&mut self, folder: &Path, files: &[String]) -> Result<()> {
        for path in files {
            self.unpack_file(path, &folder.join(path))?;
        }
        Ok(())
    }

    fn unpack_entry(&mut self, index: usize, path: &str, target: &Path) -> Result<()> {
        let mut created = File::create_new(target);
        if created.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::NotFound)
            && let Some(folder) = target.parent()
        {
            fs::create_dir_all(folder)?;
            created = File::create_new(target);
        }
        let mut file = created.map_err(|error| match error.kind() {
            // Names that differ by case only are one name on some systems.
            io::ErrorKind::AlreadyExists => ArchiveError::Twice {
                first: target.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                second: path.to_owned(),
            },
            _ => ArchiveError::Read(error),
        })?;
        self.copy(index, u64::MAX, path, &mut file)
    }

    /// The content of an entry within the limits, if it is one of those that are inflated in one piece.
    fn whole(&mut self, index: usize, most: u64) -> Option<Vec<u8>> {
        if self.is_untrue {
            return None;
        }
        let content = whole::content(&mut self.zip, index, most.min(self.allowance));
        self.is_untrue = content.is_err();
        let content = content.ok()??;
        self.allowance -= content.len() as u64;
        Some(content)
    }

    /// Copies an entry within the limits.
    fn copy(&mut self, index: usize, most: u64, path: &str, to: &mut dyn Write) -> Result<()> {
        if let Some(content) = self.whole(index, most) {
            return Ok(to.write_all(&content)?);
        }
        self.stream(index, most, path, to)
    }

    /// The same as a stream. The sizes that the archive states are not trusted.
    fn stream(&mut self, index: usize, most: u64, path: &str, to: &mut dyn Write) -> Result<()> {
        let too_large = |limit| Err(ArchiveError::Limit { what: format!("{path} is too large"), limit });
        let entry = self.zip.by_index(index).map_err(damaged)?;
        let room = most.min(self.allowance);
        let mut reader = entry.take(room.saturating_add(1));
        let copied = copy(&mut reader, to, &mut self.buffer)?;
        if copied > most {
            return too_large(format!("at most {} MiB of one document", MAX_DOCUMENT >> 20));
        }
        if copied > self.allowance {
            return too_large(format!(
                "at most {} MiB of this archive ({} MiB and {MAX_RATIO} times its own size, never more than {} GiB)",
                self.most >> 20,
                FREE_UNPACKED >> 20,
                MAX_UNPACKED >> 30
            ));
        }
        self.allowance -= copied;
        Ok(())
    }
}

/// Copies, and distinguishes a damaged archive from a full disk.
fn copy(from: &mut dyn Read, to: &mut dyn Write, buffer: &mut [u8]) -> Result<u64> {
    let mut copied = 0;
    let mut filled = 0;
    loop {
        match from.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(ArchiveError::NotAZip(error.to_string())),
        }
        if filled == buffer.len() {
            to.write_all(buffer)?;
            copied += filled as u64;
            filled = 0;
        }
    }
    to.write_all(&buffer[..filled])?;
    Ok(copied + filled as u64)
}

/// Opens a regular file. Opening a pipe would block.
///
/// # Errors
/// When it cannot be read, or is a folder, a pipe or a device.
pub fn plain_file(path: &Path) -> io::Result<File> {
    let metadata = fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    if !metadata.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a pipe or a device, not a file"));
    }
    File::open(path)
}

#[allow(clippy::needless_pass_by_value)] // it is given to map_err
fn damaged(error: ZipError) -> ArchiveError {
    ArchiveError::NotAZip(error.to_string())
}

/// The path of an entry with `/` between folders and without `.`; `None` if it points outside. Some packers write `\`,
/// or `./` in front.
fn inside(name: &str) -> Option<String> {
    let name = name.replace('\\', "/");
    let has_drive = name.as_bytes().get(1) == Some(&b':');
    if name.starts_with('/') || has_drive || name.contains('\0') {
        return None;
    }
    let mut parts = Vec::new();
    for part in name.split('/') {
        match part {
            "" | "." => {}
            ".." => _ = parts.pop()?,
            part => parts.push(part),
        }
    }
    let folder = if name.ends_with('/') && !parts.is_empty() { "/" } else { "" };
    Some(parts.join("/") + folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_read_as_they_are_meant() {
        for (name, path) in [
            ("a/b.txt", Some("a/b.txt")),
            ("./a/b.txt", Some("a/b.txt")),
            ("a\\b.txt", Some("a/b.txt")),
            (".\\a\\.\\b.txt", Some("a/b.txt")),
            ("a//b/", Some("a/b/")),
            ("a/../b", Some("b")),
            ("./", Some("")),
            ("../b", None),
            ("a\\..\\..\\b", None),
            ("/b", None),
            ("\\b", None),
            ("C:\\b", None),
            ("C:b", None),
        ] {
            assert_eq!(inside(name).as_deref(), path, "{name}");
        }
    }
}
