//! The process that watches the working one.
//!
//! Code of an FMU can do anything to its process: call `_exit`, die of a signal, close every file, ignore every interrupt,
//! hang when the process ends. So the tool splits into two processes before it loads anything. The copy works. The original
//! never runs foreign code and waits. Both share a page of memory, in which the copy stores its exit code at its end;
//! without this code, foreign code has ended the copy. The tool is copied (`fork`) and not started again, because at this
//! point there is one thread and nothing is buffered: a copy is safe, and it takes less than a millisecond.

use std::io::{self, Read};
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;
use std::ptr::{self, NonNull};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use fmi2_cosim::files;
use libc::{SIGCHLD, SIGHUP, SIGINT, SIGKILL, SIGQUIT, SIGTERM, c_int, pid_t};
use signal_hook::flag;
use signal_hook::low_level::{emulate_default_handler, pipe};

use super::{TIME_TO_END, aside, journal, worker};
use crate::cli::print_error;

/// An interrupted process that is still there after this time does not heed interrupts.
const TIME_TO_HEED: Duration = Duration::from_secs(2);
/// How often the working process is looked at without a signal.
const TICK: Duration = Duration::from_millis(500);
/// The exit code of a failure.
const FAILURE: u8 = 1;

/// A remark on the existing result files when the working process ends early.
const SO_FAR: &str = "files that were complete by then are in their places";

/// Runs `work` in a process of its own. Returns in both processes: in the working one when the work is done, in the
/// watching one when the other has ended.
pub fn run(work: impl FnOnce() -> u8) -> u8 {
    let Some(outcome) = ExitSlot::new() else { return cannot_begin() };
    let watching = libc::pid_t::try_from(std::process::id()).unwrap_or(-1);
    // SAFETY: there is one thread, so the copy has no lock that nobody would ever release.
    match unsafe { libc::fork() } {
        -1 => cannot_begin(),
        0 => {
            let code = worker::run(outcome, watching, work);
            // The watching process removes temporary files, if it is still there.
            if worker::is_alone(watching) {
                super::clean();
            }
            std::process::exit(code.into())
        }
        worker => {
            aside::step();
            watch(worker, &outcome)
        }
    }
}

fn cannot_begin() -> u8 {
    let error = io::Error::last_os_error();
    print_error(&format!(
        "error: cannot begin the process that works ({error}); the system lacks memory or processes\n"
    ));
    FAILURE
}

/// A place in memory that both processes see: 0, or the exit code and 1.
pub struct ExitSlot(NonNull<AtomicU32>);

// SAFETY: it is a pointer to an atomic that is never unmapped.
unsafe impl Send for ExitSlot {}
// SAFETY: as above.
unsafe impl Sync for ExitSlot {}

impl ExitSlot {
    fn new() -> Option<Self> {
        let (access, kind) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_SHARED | libc::MAP_ANONYMOUS);
        // SAFETY: asks for new memory, which is zero and aligned to a page.
        let page = unsafe { libc::mmap(ptr::null_mut(), size_of::<AtomicU32>(), access, kind, -1, 0) };
        (page != libc::MAP_FAILED).then_some(()).and_then(|()| NonNull::new(page.cast())).map(Self)
    }

    fn cell(&self) -> &AtomicU32 {
        // SAFETY: mapped until the process ends.
        unsafe { self.0.as_ref() }
    }

    /// The work is done: from now on this is the exit code.
    pub fn set(&self, code: u8) {
        self.cell().store(u32::from(code) + 1, Ordering::SeqCst);
    }

    fn get(&self) -> Option<u8> {
        self.cell().load(Ordering::SeqCst).checked_sub(1).and_then(|code| code.try_into().ok())
    }
}

/// The signals that interrupt the tool, but for those that it was started to ignore, as by `nohup`.
pub fn heeded() -> Vec<c_int> {
    [SIGINT, SIGTERM, SIGHUP, SIGQUIT].into_iter().filter(|signal| !is_ignored(*signal)).collect()
}

fn is_ignored(signal: c_int) -> bool {
    // SAFETY: a null action asks for the present one, which is written to valid memory.
    unsafe {
        let mut present: libc::sigaction = std::mem::zeroed();
        libc::sigaction(signal, ptr::null(), &raw mut present) == 0 && present.sa_sigaction == libc::SIG_IGN
    }
}

/// Holds signals back until both processes can handle them.
pub fn block() {
    mask(libc::SIG_BLOCK);
}

/// Lets a file that may not grow further (`ulimit -f`) be an error like a full disk, not the end of the process.
pub fn keep_writing() {
    // SAFETY: sets an action that runs no code.
    unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
}

/// Delivers the signals that [`block`] held back.
pub fn unblock() {
    mask(libc::SIG_UNBLOCK);
}

fn mask(how: c_int) {
    // SAFETY: the set is made here and lives until the end of the call.
    unsafe {
        let mut set: libc::sigset_t = std::mem::zeroed();
        libc::sigemptyset(&raw mut set);
        for signal in [SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGCHLD] {
            libc::sigaddset(&raw mut set, signal);
        }
        libc::sigprocmask(how, &raw const set, ptr::null_mut());
    }
}

/// Lets the process that watches this one, and has this number, look at what has been [set](ExitSlot::set): it gets a signal as at this
/// one's end.
pub fn call(watching: pid_t) {
    if !worker::is_alone(watching) {
        send(watching, SIGCHLD);
    }
}

/// How a process ended.
enum End {
    Code(c_int),
    Signal(c_int),
}

/// Waits for the working process, passes interrupts on, and reports its end.
fn watch(worker: pid_t, outcome: &ExitSlot) -> u8 {
    let interrupts = Interrupts::new();
    unblock();
    let mut interrupted = None;
    let mut deadline = None;
    let mut was_killed = false;
    let end = loop {
        if let Some(end) = ended(worker) {
            break end;
        }
        if let Some(signal) = interrupts.take() {
            // A second interrupt ends the process without waiting.
            let signal_to_send = if interrupted.is_some() { SIGKILL } else { signal };
            send(worker, signal_to_send);
            interrupted = Some(signal);
            deadline = Some(Instant::now() + TIME_TO_HEED);
        }
        if deadline.is_none() && outcome.get().is_some() {
            deadline = Some(Instant::now() + TIME_TO_END);
            // While the system takes the process apart, which is as long. Where there is a journal, unfinished files come first.
            if journal().is_none_or(|journal| !journal.exists()) {
                super::clean();
            }
        }
        if deadline.is_some_and(|deadline| Instant::now() >= deadline) && !was_killed {
            send(worker, SIGKILL);
            was_killed = true;
        }
        interrupts.wait(deadline.map_or(TICK, |deadline| deadline.saturating_duration_since(Instant::now()).min(TICK)));
    };
    if let Some(journal) = journal() {
        files::clean_up_after(&journal);
    }
    judge(&end, outcome.get(), interrupted, was_killed)
}

/// The exit code, with words about an end that was not the tool's own.
fn judge(end: &End, code: Option<u8>, interrupted: Option<c_int>, was_killed: bool) -> u8 {
    if code.is_none()
        && let Some(signal) = interrupted.or(match end {
            End::Signal(signal) if heeded().contains(signal) => Some(*signal),
            _ => None,
        })
    {
        super::clean();
        // A shell sees why the tool ended.
        let _ = emulate_default_handler(signal);
    }
    match (code, end) {
        (Some(_), _) if was_killed && interrupted.is_none() => {
            complain(&format!("code of an FMU did not let the process end within {TIME_TO_END:?}; {SO_FAR}"))
        }
        (Some(code), End::Signal(signal)) if code == 0 && interrupted.is_none() => {
            complain(&format!("code of an FMU crashed when the process ended ({}); {SO_FAR}", name(*signal)))
        }
        (Some(code), _) => code,
        (None, End::Code(code)) => {
            complain(&format!("an FMU ended the process (it called exit, with exit code {code}); {SO_FAR}"))
        }
        (None, End::Signal(SIGKILL)) => {
            complain(&format!("the process that ran the FMUs was killed, by somebody or for lack of memory; {SO_FAR}"))
        }
        (None, End::Signal(signal)) => complain(&format!("an FMU crashed the process ({}); {SO_FAR}", name(*signal))),
    }
}

fn complain(message: &str) -> u8 {
    print_error(&format!("error: {message}\n"));
    FAILURE
}

fn name(signal: c_int) -> String {
    match signal_hook::low_level::signal_name(signal) {
        Some(name) => name.to_owned(),
        None => format!("signal {signal}"),
    }
}

/// How the process ended, if it has.
fn ended(process: pid_t) -> Option<End> {
    let mut status = 0;
    // SAFETY: asks about a child, whose status is written to valid memory.
    let found = unsafe { libc::waitpid(process, &raw mut status, libc::WNOHANG) };
    match found {
        0 => None,
        -1 if io::Error::last_os_error().kind() == io::ErrorKind::Interrupted => None,
        -1 => Some(End::Code(FAILURE.into())),
        _ if libc::WIFSIGNALED(status) => Some(End::Signal(libc::WTERMSIG(status))),
        _ if libc::WIFEXITED(status) => Some(End::Code(libc::WEXITSTATUS(status))),
        _ => None,
    }
}

fn send(process: pid_t, signal: c_int) {
    // SAFETY: involves no memory. The process is our child and was not waited for yet, or our parent, so the number is its own.
    unsafe { libc::kill(process, signal) };
}

/// The interrupts that reach the watching process.
struct Interrupts {
    flags: Vec<(c_int, Arc<AtomicBool>)>,
    /// Has something to read after a signal.
    bell: Option<UnixStream>,
}

impl Interrupts {
    fn new() -> Self {
        let heeded = heeded();
        let flags: Vec<_> = heeded.iter().map(|signal| (*signal, Arc::new(AtomicBool::new(false)))).collect();
        for (signal, flag) in &flags {
            let _ = flag::register(*signal, Arc::clone(flag));
        }
        let bell = UnixStream::pair().ok().and_then(|(bell, button)| {
            bell.set_nonblocking(true).ok()?;
            for signal in heeded.into_iter().chain([SIGCHLD]) {
                pipe::register(signal, button.try_clone().ok()?).ok()?;
            }
            Some(bell)
        });
        Self { flags, bell }
    }

    /// The next interrupt that has not been handled yet.
    fn take(&self) -> Option<c_int> {
        self.flags.iter().find(|(_, flag)| flag.swap(false, Ordering::SeqCst)).map(|(signal, _)| *signal)
    }

    /// Waits for a signal, not longer than that.
    fn wait(&self, most: Duration) {
        let Some(mut bell) = self.bell.as_ref() else {
            // Without a bell a short sleep has to do.
            std::thread::sleep(most.min(Duration::from_millis(10)));
            return;
        };
        let mut asked = libc::pollfd { fd: bell.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        let milliseconds = c_int::try_from(most.as_millis()).unwrap_or(c_int::MAX);
        // SAFETY: one entry, which lives until the end of the call.
        unsafe { libc::poll(&raw mut asked, 1, milliseconds) };
        let mut rings = [0; 64];
        while matches!(bell.read(&mut rings), Ok(count) if count > 0) {}
    }
}
