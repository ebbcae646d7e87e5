//! Protects parts of the process against the code of FMUs: its standard output, its exit code and the meaning of relative
//! paths. Also cleans up when the process has to end early.
//!
//! On Unix a second process does all the work and the first one watches it ([`supervisor`]). Whatever the code of an FMU
//! does to its process, the first process can report it, remove unfinished files and return an exit code.

#[cfg(unix)]
mod aside;
#[cfg(unix)]
mod supervisor;
#[cfg(unix)]
mod worker;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use fmi2_cosim::files;
use fmi2_import::Fmu;

use super::print_error;

/// Code of FMUs that does not come back from its end within this time does not come back.
pub const TIME_TO_END: Duration = Duration::from_secs(10);

/// The standard output the process was started with.
static STANDARD_OUTPUT: OnceLock<File> = OnceLock::new();
/// Whether standard output was closed at the start. When `main` runs, Rust's runtime has already replaced it by the null
/// device.
static HAD_NO_STANDARD_OUTPUT: AtomicBool = AtomicBool::new(false);
/// Everything that is unpacked is unpacked in here.
static TEMPORARY_FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// Does the tool's work. Returns its exit code, or that of the failure that prevented it.
pub fn run(work: impl FnOnce() -> u8) -> u8 {
    // An interrupt is held back until a process can clean up.
    #[cfg(unix)]
    {
        supervisor::block();
        supervisor::keep_writing();
    }
    files::remember_surroundings();
    // If the tool cannot create its own folder, it uses the common one: some commands need none at all.
    if let Ok(folder) = tempfile::Builder::new().prefix("dualarm-").tempdir() {
        let folder = TEMPORARY_FOLDER.get_or_init(|| folder.keep());
        let _ = tempfile::env::override_temp_dir(folder);
        Fmu::share_folder(folder);
    }
    #[cfg(unix)]
    let code = supervisor::run(work);
    #[cfg(not(unix))]
    let code = work();
    clean();
    code
}

/// The file in which the working process names its unfinished files.
#[cfg(unix)]
fn journal() -> Option<PathBuf> {
    TEMPORARY_FOLDER.get().map(|folder| folder.join("journal"))
}

/// The standard output of the process. The output of FMUs goes to standard error.
pub fn standard_output() -> &'static File {
    STANDARD_OUTPUT.get_or_init(standard_output_now)
}

/// Whether there is a standard output.
///
/// # Errors
/// When the process was started without one.
pub fn check_standard_output() -> io::Result<()> {
    if HAD_NO_STANDARD_OUTPUT.load(Ordering::Relaxed) {
        return Err(io::Error::other("it is closed"));
    }
    Ok(())
}

/// Writes to the standard output of the process.
///
/// # Errors
/// When it does not take everything.
pub fn write_to_standard_output(text: &[u8]) -> io::Result<()> {
    if !text.is_empty() {
        check_standard_output()?;
        standard_output().write_all(text)?;
    }
    Ok(())
}

#[cfg(unix)]
fn standard_output_now() -> File {
    use std::os::fd::AsFd;
    match std::io::stdout().as_fd().try_clone_to_owned() {
        Ok(descriptor) => File::from(descriptor),
        Err(error) => panic!("standard output cannot be used: {error}"),
    }
}

#[cfg(windows)]
fn standard_output_now() -> File {
    use std::os::windows::io::AsHandle;
    match std::io::stdout().as_handle().try_clone_to_owned() {
        Ok(handle) => File::from(handle),
        Err(error) => panic!("standard output cannot be used: {error}"),
    }
}

/// Runs before `main` and before the runtime of Rust.
#[cfg(any(target_os = "linux", target_os = "macos"))]
#[used]
#[cfg_attr(target_os = "linux", unsafe(link_section = ".init_array"))]
#[cfg_attr(target_os = "macos", unsafe(link_section = "__DATA,__mod_init_func"))]
static LOOK_AT_STANDARD_OUTPUT: extern "C" fn() = {
    extern "C" fn look() {
        // SAFETY: asks about a descriptor, which involves no memory.
        if unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFD) } == -1 {
            HAD_NO_STANDARD_OUTPUT.store(true, Ordering::Relaxed);
        }
    }
    look
};

/// Does work in which FMUs may hang for ever. After `limit` the process ends with exit code 1 and a message.
pub fn within<T>(limit: Duration, complaint: String, work: impl FnOnce() -> T) -> T {
    let (is_done, wait) = mpsc::channel::<()>();
    // When the work is done it ends by itself: nobody waits until it has a processor once more.
    thread::spawn(move || {
        if wait.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
            end(&complaint);
        }
    });
    let result = work();
    drop(is_done);
    result
}

/// Ends the process at once, without the destructors of loaded code.
fn end(complaint: &str) -> ! {
    print_error(&format!("error: {complaint}\n"));
    leave(1)
}

/// Ends the process at once and without a word.
pub fn leave(code: u8) -> ! {
    files::abandon();
    #[cfg(unix)]
    worker::leave(code);
    #[cfg(not(unix))]
    {
        clean();
        std::process::exit(code.into())
    }
}

/// Removes files that only a running process needs. Threads of a process that is ending may still be unpacking files: what they make
/// meanwhile is removed too, and in a folder that is no longer there they can make nothing.
fn clean() {
    const TRIES: u32 = 20;
    let Some(folder) = TEMPORARY_FOLDER.get() else { return };
    for _ in 0..TRIES {
        if fs::remove_dir_all(folder).is_ok() || !folder.exists() {
            return;
        }
        thread::sleep(Duration::from_millis(1));
    }
}
