//! The meaning of a path given for output.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The destination of output.
pub(super) enum Place {
    /// A file, which need not be there yet: an absolute path without a link at its end.
    File(PathBuf),
    /// A pipe, a device or an open file of this process.
    Stream(File),
}

/// The largest number of links in a row; more are treated as a circle.
const LINKS: usize = 40;

static CURRENT_FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();

/// Stores the current folder and the umask. From now on relative paths count from this folder, and new files have the
/// permissions of this umask, whatever a loaded library changes. Call it before threads are started.
pub fn remember_surroundings() {
    CURRENT_FOLDER.get_or_init(|| std::env::current_dir().ok());
    #[cfg(unix)]
    UMASK.get_or_init(|| {
        // The system returns the mask only when another one is set.
        let mask = rustix::process::umask(rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO);
        rustix::process::umask(mask);
        mask
    });
}

/// The permissions that new files of this process lack; see [`remember_surroundings`].
#[cfg(unix)]
static UMASK: OnceLock<rustix::fs::Mode> = OnceLock::new();

/// Restores the umask, so that new files have the user's usual permissions.
pub(super) fn usual_permissions() {
    #[cfg(unix)]
    if let Some(mask) = UMASK.get() {
        rustix::process::umask(*mask);
    }
}

/// The path as an absolute one; see [`remember_surroundings`].
#[must_use]
pub fn absolute(path: &Path) -> PathBuf {
    match CURRENT_FOLDER.get_or_init(|| std::env::current_dir().ok()) {
        Some(folder) => folder.join(path),
        None => path.to_owned(),
    }
}

/// Whether a path is another name of standard output, such as `/dev/stdout`.
#[must_use]
pub fn is_standard_output(path: &Path) -> bool {
    matches!(follow(path), Ok(End::Descriptor(Some(1), _)))
}

/// Whether both paths mean the same existing file, also under different names.
#[must_use]
pub fn are_same(one: &Path, other: &Path) -> bool {
    let (one, other) = (absolute(one), absolute(other));
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        if let (Ok(one), Ok(other)) = (fs::metadata(&one), fs::metadata(&other)) {
            return (one.dev(), one.ino()) == (other.dev(), other.ino());
        }
    }
    matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}

impl Place {
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        let target = match follow(path)? {
            // Opening it by name would overwrite the file from its beginning, although it is already half written.
            End::Descriptor(Some(1), _) => return own_stream(io::stdout()).map(Self::Stream),
            End::Descriptor(Some(2), _) => return own_stream(io::stderr()).map(Self::Stream),
            End::Descriptor(_, path) => {
                return OpenOptions::new().append(true).open(path).map(Self::Stream);
            }
            End::Path(target) => target,
        };
        match fs::metadata(&target) {
            Ok(existing) if existing.is_dir() => Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder")),
            Ok(existing) if !existing.is_file() => OpenOptions::new().write(true).open(target).map(Self::Stream),
            _ => Ok(Self::File(target)),
        }
    }
}

#[cfg(unix)]
fn own_stream(stream: impl std::os::fd::AsFd) -> io::Result<File> {
    stream.as_fd().try_clone_to_owned().map(File::from)
}

#[cfg(windows)]
fn own_stream(stream: impl std::os::windows::io::AsHandle) -> io::Result<File> {
    stream.as_handle().try_clone_to_owned().map(File::from)
}

/// The file under a high number. Code that closes files that it did not open closes those with low numbers.
#[cfg(unix)]
pub(super) fn out_of_the_way(file: File) -> File {
    const LEAST: i32 = 100;
    match rustix::io::fcntl_dupfd_cloexec(&file, LEAST) {
        Ok(descriptor) => File::from(descriptor),
        Err(_) => file,
    }
}

#[cfg(not(unix))]
pub(super) fn out_of_the_way(file: File) -> File {
    file
}

/// The end of a chain of links.
enum End {
    Path(PathBuf),
    /// An open file of a process, by its entry in `/proc` or `/dev/fd`; with its number if the process is this one.
    Descriptor(Option<u32>, PathBuf),
}

fn follow(path: &Path) -> io::Result<End> {
    let mut path = absolute(path);
    for _ in 0..LINKS {
        if let Some(number) = descriptor(&path) {
            return Ok(End::Descriptor(number, path));
        }
        match fs::symlink_metadata(&path) {
            Ok(entry) if entry.is_symlink() => {
                let folder = path.parent().unwrap_or(Path::new("/"));
                path = folder.join(fs::read_link(&path)?);
            }
            _ => return Ok(End::Path(path)),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

/// Whether a path is an entry for an open file; with its number if it is this process's.
#[allow(clippy::option_option)] // is it one, and do we know which
fn descriptor(path: &Path) -> Option<Option<u32>> {
    let folder = path.parent()?.canonicalize().ok()?;
    let folder = folder.to_str()?;
    let number = || path.file_name()?.to_str()?.parse().ok();
    if folder == "/dev/fd" {
        return Some(number());
    }
    let process = folder.strip_prefix("/proc/")?.strip_suffix("/fd")?;
    let own = process.split('/').next() == Some(std::process::id().to_string().as_str());
    Some(if own { number() } else { None })
}
