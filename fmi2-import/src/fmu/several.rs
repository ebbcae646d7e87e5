//! Several FMUs are unpacked at once.

use std::fs;
use std::io;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use super::Fmu;
use crate::error::FmuError;

/// So many FMUs are unpacked at the same time.
const AT_ONCE: usize = 8;

impl Fmu {
    /// Unpacks FMUs, several at a time, each as often as it is named.
    ///
    /// # Errors
    /// When one cannot be used. If several cannot, the error is that of the first one.
    ///
    /// # Panics
    /// When unpacking does.
    pub fn unpack_all<P: AsRef<Path>>(paths: &[P]) -> Result<Vec<Self>, FmuError> {
        let mut unpacked = Vec::with_capacity(paths.len());
        for some in paths.chunks(AT_ONCE) {
            // The largest one, which takes longest, begins at once: on this thread.
            let largest = (0..some.len()).max_by_key(|place| size(some[*place].as_ref()));
            let begin = |place| (Some(place) != largest).then(|| Begun::new(some[place].as_ref()));
            let begun: Vec<_> = (0..some.len()).map(begin).collect();
            let mut here = largest.map(|place| Self::unpack(&some[place]));
            let done = some.iter().zip(begun).map(|(path, begun)| match begun {
                Some(begun) => begun.unpacked(),
                None => here.take().unwrap_or_else(|| Self::unpack(path)),
            });
            // No thread that works is left alone, whatever happens to others.
            let done: Vec<_> = done.collect();
            for fmu in done {
                unpacked.push(fmu?);
            }
        }
        Ok(unpacked)
    }
}

/// How many bytes a file has; none, if it cannot be asked.
fn size(path: &Path) -> u64 {
    fs::metadata(path).map_or(0, |file| file.len())
}

/// An FMU that a thread unpacks, if it gets a processor before somebody else has done the work.
struct Begun {
    /// Who takes it does the work.
    path: Arc<Mutex<Option<PathBuf>>>,
    thread: io::Result<JoinHandle<Option<Result<Fmu, FmuError>>>>,
}

impl Begun {
    /// Begins on another processor.
    fn new(path: &Path) -> Self {
        let path = Arc::new(Mutex::new(Some(path.to_owned())));
        let shared = Arc::clone(&path);
        let work = move || taken(&shared).map(Fmu::unpack);
        #[cfg(target_os = "linux")]
        let thread = elsewhere::spawn(work);
        #[cfg(not(target_os = "linux"))]
        let thread = thread::Builder::new().spawn(work);
        Self { path, thread }
    }

    /// The FMU. A thread that has waited in vain until now, when all processors work for others, finds nothing to do later; and perhaps
    /// there is none.
    fn unpacked(self) -> Result<Fmu, FmuError> {
        if let Some(path) = taken(&self.path) {
            return Fmu::unpack(path);
        }
        let done = self.thread.map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
        match done {
            Ok(Some(done)) => done,
            _ => unreachable!("a thread has taken it, which then has a result"),
        }
    }
}

fn taken(path: &Mutex<Option<PathBuf>>) -> Option<PathBuf> {
    path.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// Some kernels (seen on Linux 6.18 in a virtual machine) begin a thread on the processor of its maker and look for an idle one only
/// milliseconds later, when this work would be done.
#[cfg(target_os = "linux")]
mod elsewhere {
    use std::os::unix::thread::JoinHandleExt;

    use super::{JoinHandle, io, thread};

    /// Starts a thread on any processor but the present one, which it may use later.
    pub fn spawn<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> io::Result<JoinHandle<T>> {
        let allowed = allowed();
        let begin = move || {
            if let Some(allowed) = &allowed {
                // SAFETY: reads a set of the stated size; 0 is this thread.
                unsafe { libc::sched_setaffinity(0, size_of_val(allowed), allowed) };
            }
            work()
        };
        let thread = thread::Builder::new().spawn(begin)?;
        if let Some(others) = allowed.and_then(others) {
            // If the thread was faster, it stays on the others.
            // SAFETY: a thread that was not joined, and a set of the stated size.
            unsafe { libc::pthread_setaffinity_np(thread.as_pthread_t(), size_of_val(&others), &raw const others) };
        }
        Ok(thread)
    }

    /// The processors that this thread may use.
    fn allowed() -> Option<libc::cpu_set_t> {
        // SAFETY: a set of no processors is all zeros; it is written to by the call, whose size is stated.
        unsafe {
            let mut set: libc::cpu_set_t = std::mem::zeroed();
            (libc::sched_getaffinity(0, size_of_val(&set), &raw mut set) == 0).then_some(set)
        }
    }

    /// All of them but the present one; `None` if there are no others.
    fn others(mut set: libc::cpu_set_t) -> Option<libc::cpu_set_t> {
        // SAFETY: asks for a number.
        let present = usize::try_from(unsafe { libc::sched_getcpu() }).ok()?;
        // SAFETY: the functions check the range of the number.
        let count = unsafe {
            libc::CPU_CLR(present, &mut set);
            libc::CPU_COUNT(&set)
        };
        (count > 0).then_some(set)
    }
}
