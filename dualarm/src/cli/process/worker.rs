//! The process that works: loaded code runs in it.

use std::fs::File;
use std::os::fd::{FromRawFd, OwnedFd, RawFd};
use std::panic::{self, AssertUnwindSafe};
use std::sync::OnceLock;
use std::thread;

use fmi2_cosim::files;
use signal_hook::iterator::Signals;

use super::supervisor::{ExitSlot, call, unblock};
use super::{STANDARD_OUTPUT, journal};

/// Where the watching process finds the exit code.
static OUTCOME: OnceLock<ExitSlot> = OnceLock::new();

/// Code that closes files it did not open closes the first ones.
const OUT_OF_THE_WAY: RawFd = 200;

/// Exit code of work that nobody waits for any more.
const FAILURE: u8 = 1;
/// Exit code of a program in Rust that found a mistake in itself.
const PANICKED: u8 = 101;

/// Does the work, then marks in the shared page that everything after it does not count.
pub fn run(outcome: ExitSlot, watching: libc::pid_t, work: impl FnOnce() -> u8) -> u8 {
    let outcome = OUTCOME.get_or_init(|| outcome);
    #[cfg(target_os = "linux")]
    // SAFETY: asks for a signal when the watching process ends, which involves no memory.
    unsafe {
        libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGTERM)
    };
    // It may have been killed before this process could ask for a signal.
    if is_alone(watching) {
        return FAILURE;
    }
    if let Some(journal) = journal() {
        files::keep_journal(journal);
    }
    keep_standard_output();
    end_when_interrupted(watching);
    let code = panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or(PANICKED);
    outcome.set(code);
    call(watching);
    code
}

/// Whether the watching process, which has this number, is no longer there.
pub fn is_alone(watching: libc::pid_t) -> bool {
    // SAFETY: asks for a number.
    unsafe { libc::getppid() != watching }
}

/// Ends the process without anybody's handlers.
pub fn leave(code: u8) -> ! {
    if let Some(outcome) = OUTCOME.get() {
        outcome.set(code);
    }
    // SAFETY: ends the process.
    unsafe { libc::_exit(code.into()) }
}

/// Reserves standard output for the tool; the output of all other code goes to standard error.
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

/// Lets an interrupted process finish moving files and then die of the signal. The watching process removes the rest, if it
/// still exists. On Linux this process is interrupted too when the watching process is killed.
fn end_when_interrupted(watching: libc::pid_t) {
    let signals = Signals::new(super::supervisor::heeded());
    unblock();
    let Ok(mut signals) = signals else { return };
    thread::spawn(move || {
        for signal in &mut signals {
            files::abandon();
            if is_alone(watching) {
                super::clean();
            }
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    });
}
