//! What the tool keeps out of reach of the code that FMUs bring into its process: its standard output, its exit code,
//! the meaning of relative paths; and what it cleans up when the process has to end early.

use std::fs::{self, File};
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use fmi2_cosim::files;

use super::print_error;

/// The standard output the process was started with.
static STANDARD_OUTPUT: OnceLock<File> = OnceLock::new();
/// Everything that is unpacked is unpacked in here.
static TEMPORARY_FOLDER: OnceLock<PathBuf> = OnceLock::new();
/// The process ends because the tool is done, not because an FMU calls `exit`.
static IS_DONE: AtomicBool = AtomicBool::new(false);

/// While it lives, the tool is at work. Dropped, it removes temporary files.
pub struct AtWork(());

/// Prepares the process, before the first FMU is loaded.
pub fn prepare() -> AtWork {
    files::remember_current_folder();
    // Without a folder of its own the tool uses the common one: some commands need none at all.
    if let Ok(folder) = tempfile::Builder::new().prefix("dualarm-").tempdir() {
        let folder = TEMPORARY_FOLDER.get_or_init(|| folder.keep());
        let _ = tempfile::env::override_temp_dir(folder);
    }
    #[cfg(unix)]
    unix::prepare();
    AtWork(())
}

impl Drop for AtWork {
    fn drop(&mut self) {
        clean();
        IS_DONE.store(true, Ordering::SeqCst);
    }
}

/// The standard output of the process. What an FMU prints goes to standard error.
pub fn standard_output() -> &'static File {
    STANDARD_OUTPUT.get_or_init(standard_output_now)
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

/// Does something that FMUs may never come back from. After `limit` the process ends with exit code 1 and a complaint.
pub fn within<T>(limit: Duration, complaint: &str, work: impl FnOnce() -> T) -> T {
    let (is_done, wait) = mpsc::channel::<()>();
    thread::scope(|scope| {
        scope.spawn(move || {
            if wait.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
                end(complaint);
            }
        });
        let result = work();
        drop(is_done);
        result
    })
}

/// Removes what only a running process needs.
fn clean() {
    files::abandon();
    if let Some(folder) = TEMPORARY_FOLDER.get() {
        let _ = fs::remove_dir_all(folder);
    }
}

/// Ends the process at once, without the destructors of loaded code.
fn end(complaint: &str) -> ! {
    print_error(&format!("error: {complaint}\n"));
    clean();
    IS_DONE.store(true, Ordering::SeqCst);
    #[cfg(unix)]
    unix::leave(1);
    #[cfg(not(unix))]
    std::process::exit(1)
}

#[cfg(unix)]
mod unix {
    use std::os::fd::{FromRawFd, OwnedFd, RawFd};

    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
    use signal_hook::iterator::Signals;

    use super::{AtomicBool, File, IS_DONE, Ordering, STANDARD_OUTPUT, clean, end, thread};

    /// Code that closes files it did not open closes the first ones.
    const OUT_OF_THE_WAY: RawFd = 200;

    pub fn prepare() {
        keep_standard_output();
        // SAFETY: the handler is a function that lives as long as the process.
        unsafe { libc::atexit(at_exit) };
        clean_when_interrupted();
    }

    /// Takes standard output away from everybody else; what they print goes to standard error.
    fn keep_standard_output() {
        // SAFETY: no memory is involved; nothing else owns the new descriptor.
        let kept = [OUT_OF_THE_WAY, 3]
            .into_iter()
            .map(|least| unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_DUPFD_CLOEXEC, least) })
            .find(|descriptor| *descriptor >= 0);
        let Some(kept) = kept else { return };
        // SAFETY: as above.
        let kept = File::from(unsafe { OwnedFd::from_raw_fd(kept) });
        if STANDARD_OUTPUT.set(kept).is_ok() {
            // SAFETY: as above.
            unsafe { libc::dup2(libc::STDERR_FILENO, libc::STDOUT_FILENO) };
        }
    }

    /// Runs when somebody calls `exit`.
    extern "C" fn at_exit() {
        static IS_ENDING: AtomicBool = AtomicBool::new(false);
        if !IS_DONE.load(Ordering::SeqCst) && !IS_ENDING.swap(true, Ordering::SeqCst) {
            end("an FMU ended the process (it called exit); files that were complete by then are in their places");
        }
    }

    /// Ends the process without anybody's handlers.
    pub fn leave(code: i32) -> ! {
        // SAFETY: ends the process.
        unsafe { libc::_exit(code) }
    }

    /// An interrupted process leaves nothing half-made, and then dies of the signal as its parent expects.
    fn clean_when_interrupted() {
        let signals: Vec<_> =
            [SIGINT, SIGTERM, SIGHUP, SIGQUIT].into_iter().filter(|signal| !is_ignored(*signal)).collect();
        let Ok(mut signals) = Signals::new(signals) else { return };
        thread::spawn(move || {
            for signal in &mut signals {
                clean();
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        });
    }

    /// Whether the process was started with this signal ignored, as by `nohup`.
    fn is_ignored(signal: i32) -> bool {
        // SAFETY: a null action asks for the present one, which is written to valid memory.
        unsafe {
            let mut present: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, std::ptr::null(), &raw mut present) == 0 && present.sa_sigaction == libc::SIG_IGN
        }
    }
}
