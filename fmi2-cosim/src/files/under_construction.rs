//! Unfinished files, and their removal when the process must end.

use std::collections::HashSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use tempfile::NamedTempFile;

use super::place::{out_of_the_way, usual_permissions};

/// Paths of this process that are useless if it ends now: unfinished files, and folders made for them.
#[derive(Default)]
struct Unfinished {
    paths: HashSet<PathBuf>,
    /// Once there was one of them, if there is a journal.
    journal: Option<File>,
}

static UNFINISHED: Mutex<Option<Unfinished>> = Mutex::new(None);
/// The file of the journal.
static JOURNAL: OnceLock<PathBuf> = OnceLock::new();

fn unfinished() -> MutexGuard<'static, Option<Unfinished>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on this process records its unfinished files in this file, so that another process can remove them with
/// [`clean_up_after`] if this one ends without doing so. It is made for the first of them, where only this process makes files.
pub fn keep_journal(file: PathBuf) {
    JOURNAL.get_or_init(|| file);
}

/// What begins an entry of the journal: a path that was begun, or one that is no more unfinished. Its end is a zero, which no path has.
const BEGUN: u8 = b'+';
const ENDED: u8 = b'-';

/// Removes the unfinished files of a process that has ended, by its journal.
pub fn clean_up_after(journal: &Path) {
    let Ok(entries) = fs::read(journal) else { return };
    let mut unfinished = HashSet::new();
    for entry in entries.split_inclusive(|byte| *byte == 0) {
        // A process may have ended before it had written all of its last entry.
        let [kind, path @ .., 0] = entry else { continue };
        let path = path_of(path.to_vec());
        if *kind == BEGUN {
            unfinished.insert(path)
        } else {
            unfinished.remove(&path)
        };
    }
    remove(unfinished.into_iter().collect());
}

/// Adds an unfinished path.
fn begun(unfinished: &mut Option<Unfinished>, path: PathBuf) {
    let unfinished = unfinished.get_or_insert_default();
    if unfinished.journal.is_none() {
        let file = JOURNAL.get().and_then(|file| OpenOptions::new().create(true).append(true).open(file).ok());
        unfinished.journal = file.map(out_of_the_way);
    }
    unfinished.note(BEGUN, &path);
    unfinished.paths.insert(path);
}

/// Removes a path from the unfinished ones.
fn ended(path: &Path) {
    if let Some(unfinished) = unfinished().as_mut()
        && unfinished.paths.remove(path)
    {
        unfinished.note(ENDED, path);
    }
}

impl Unfinished {
    /// Writes an entry of the journal. Without it the file is only removed by this process.
    fn note(&mut self, kind: u8, path: &Path) {
        if let Some(journal) = &mut self.journal {
            let _ = journal.write_all(&[&[kind], bytes_of(path), &[0]].concat());
        }
    }
}

#[cfg(unix)]
fn bytes_of(path: &Path) -> &[u8] {
    std::os::unix::ffi::OsStrExt::as_bytes(path.as_os_str())
}

#[cfg(unix)]
fn path_of(bytes: Vec<u8>) -> PathBuf {
    PathBuf::from(<std::ffi::OsString as std::os::unix::ffi::OsStringExt>::from_vec(bytes))
}

#[cfg(not(unix))]
fn bytes_of(path: &Path) -> &[u8] {
    path.to_str().unwrap_or_default().as_bytes()
}

#[cfg(not(unix))]
fn path_of(bytes: Vec<u8>) -> PathBuf {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

/// Removes files, and the folders that are then empty.
fn remove(mut paths: Vec<PathBuf>) {
    // The contents of a folder come before the folder.
    paths.sort_unstable_by_key(|path| std::cmp::Reverse(path.components().count()));
    for path in &paths {
        if fs::remove_file(path).is_err() {
            let _ = fs::remove_dir(path);
        }
    }
}

/// Removes all unfinished files, for a process that is about to end; existing files stay unchanged. Waits for files
/// that are being moved to their places, and prevents further moves.
pub fn abandon() {
    let mut unfinished = unfinished();
    remove(unfinished.take().unwrap_or_default().paths.into_iter().collect());
    // No file is begun or moved until the process has ended.
    std::mem::forget(unfinished);
}

/// An unfinished file beside its destination.
#[derive(Debug)]
pub(super) struct Part {
    target: PathBuf,
    file: NamedTempFile,
    way: Way,
    written: u64,
    folders: Folders, // the last one to be dropped: folders can be removed only when they are empty
}

/// How a part gets to its place.
#[derive(Debug)]
enum Way {
    /// By a rename.
    Rename,
    /// By its content: the existing file has other names too, or another owner, and must stay the same file.
    Fill(File),
}

/// Folders that were made for a file, the innermost first; they go when it does not come.
#[derive(Debug)]
struct Folders {
    made: Vec<PathBuf>,
    are_used: bool,
}

impl Part {
    pub(super) fn new(target: PathBuf) -> io::Result<Self> {
        let folder = target.parent().unwrap_or(Path::new("/")).to_owned();
        let folders = Folders::create(&folder)?;
        let existing = fs::metadata(&target).ok();
        // The user must be allowed to write to the file, although a rename only needs the permission of the folder.
        let opened = existing.as_ref().map(|_| OpenOptions::new().write(true).open(&target)).transpose()?;
        // An interrupt waits until the new file is among the unfinished ones.
        let mut guard = unfinished();
        let part = match begin(&folder, existing.as_ref()) {
            Ok(part) => part,
            // If no file can be created beside it, an existing file can still be filled.
            Err(_) if opened.is_some() => begin(&std::env::temp_dir(), existing.as_ref())?,
            Err(error) => return Err(error),
        };
        let beside = part.path().parent() == Some(folder.as_path());
        begun(&mut guard, part.path().to_owned());
        drop(guard);
        let way = match (existing, opened) {
            (Some(existing), Some(opened)) if !beside || !can_stand_for(&part, &existing) => Way::Fill(opened),
            _ => Way::Rename,
        };
        Ok(Self { target, file: part, way, written: 0, folders })
    }

    /// Whether all that was written is still there: code loaded into this process can close any file.
    pub(super) fn checked(mut self) -> io::Result<Self> {
        self.file.flush()?;
        let there = fs::metadata(self.file.path())?;
        if there.len() != self.written {
            let message = format!("{} of {} bytes arrived: something else closed the file", there.len(), self.written);
            return Err(io::Error::other(message));
        }
        Ok(self)
    }

    /// Takes its place.
    pub(super) fn appear(mut self) -> io::Result<()> {
        let guard = unfinished();
        let result = self.take_place();
        drop(guard);
        result
    }

    /// Takes its place; the caller keeps others from ending the process meanwhile.
    fn take_place(&mut self) -> io::Result<()> {
        let path = self.file.path();
        match &mut self.way {
            Way::Rename => match fs::rename(path, &self.target) {
                // A file that is mounted there keeps its name, but takes content.
                Err(error) if error.kind() == io::ErrorKind::ResourceBusy => {
                    let mut mounted = OpenOptions::new().write(true).open(&self.target)?;
                    fill(&mut mounted, path)?;
                }
                result => result?,
            },
            Way::Fill(file) => fill(file, path)?,
        }
        self.folders.are_used = true;
        Ok(())
    }
}

impl Write for Part {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.written += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// All parts take their places, or all stay away; then the error has the index of the one that cannot.
pub(super) fn appear_together(mut parts: Vec<Part>) -> Result<(), (usize, io::Error)> {
    let guard = unfinished();
    let mut former: Vec<(&Path, Option<PathBuf>)> = Vec::new();
    let mut failure = None;
    for (index, part) in parts.iter_mut().enumerate() {
        let other_name = keep_former(&part.target, part.file.path());
        let result = part.take_place();
        former.push((&part.target, other_name));
        if let Err(error) = result {
            failure = Some((index, error));
            break;
        }
    }
    for (target, other_name) in former.iter().rev() {
        match (other_name, failure.is_some()) {
            (Some(other_name), true) => drop(fs::rename(other_name, target)),
            (Some(other_name), false) => drop(fs::remove_file(other_name)),
            (None, true) => drop(fs::remove_file(target)),
            (None, false) => {}
        }
    }
    drop(guard);
    failure.map_or(Ok(()), Err)
}

/// Another name for the file that a part will replace, if there is one, so that it can come back.
fn keep_former(target: &Path, part: &Path) -> Option<PathBuf> {
    let mut name = part.file_name()?.to_owned();
    name.push(".former");
    let former = target.with_file_name(name);
    fs::hard_link(target, &former).ok().map(|()| former)
}

/// A new file in a folder, with no more permissions than the file that it replaces.
fn begin(folder: &Path, existing: Option<&fs::Metadata>) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The permissions of a new file, without those in the user's umask, as for any other file.
        let mode = existing.map_or(0o666, |existing| existing.permissions().mode() & 0o666);
        builder.permissions(fs::Permissions::from_mode(mode));
    }
    // Elsewhere a new file has the permissions of its folder.
    #[cfg(not(unix))]
    let _ = existing;
    usual_permissions();
    let (file, path) = builder.tempfile_in(folder)?.into_parts();
    Ok(NamedTempFile::from_parts(out_of_the_way(file), path))
}

/// Whether the part can replace this file unnoticed: same owner, same permissions, no further names. Sets owner and
/// permissions of the part if that is allowed.
#[cfg(unix)]
fn can_stand_for(part: &NamedTempFile, existing: &fs::Metadata) -> bool {
    use std::os::unix::fs::{MetadataExt, fchown};
    if existing.nlink() > 1 {
        return false;
    }
    let Ok(own) = part.as_file().metadata() else { return false };
    let has_owner = (own.uid(), own.gid()) == (existing.uid(), existing.gid())
        || fchown(part.as_file(), Some(existing.uid()), Some(existing.gid())).is_ok();
    has_owner && part.as_file().set_permissions(existing.permissions()).is_ok()
}

#[cfg(not(unix))]
fn can_stand_for(_: &NamedTempFile, existing: &fs::Metadata) -> bool {
    !existing.permissions().readonly()
}

fn fill(file: &mut File, from: &Path) -> io::Result<()> {
    let mut from = File::open(from)?;
    file.set_len(0)?;
    file.rewind()?;
    io::copy(&mut from, file).map(drop)
}

impl Folders {
    fn create(folder: &Path) -> io::Result<Self> {
        let missing = folder.ancestors().take_while(|folder| !folder.exists()).map(Path::to_owned);
        let folders = Self { made: missing.collect(), are_used: false };
        for folder in &folders.made {
            begun(&mut unfinished(), folder.clone());
        }
        usual_permissions();
        fs::create_dir_all(folder)?;
        Ok(folders)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        ended(self.file.path());
    }
}

impl Drop for Folders {
    fn drop(&mut self) {
        for folder in &self.made {
            if !self.are_used {
                let _ = fs::remove_dir(folder);
            }
            ended(folder);
        }
    }
}
