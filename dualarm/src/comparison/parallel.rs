//! Pieces of work on all processors, and memory between them.

use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Does `count` pieces of work, as many at once as there are processors, so that no more is in memory at a time than need be. Returns
/// their results in order.
///
/// # Errors
/// The first one of a piece; pieces that have begun are completed, others are not begun.
pub fn each<T: Send, E: Send>(count: usize, work: impl Fn(usize) -> Result<T, E> + Sync) -> Result<Vec<T>, E> {
    let next = AtomicUsize::new(0);
    let some = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return Ok(done);
            }
            done.push((index, work(index).inspect_err(|_| next.store(count, Ordering::Relaxed))?));
        }
    };
    let processors = thread::available_parallelism().map_or(1, NonZero::get);
    let mut done = Vec::with_capacity(count);
    for some in thread::scope(|scope| {
        let workers: Vec<_> = (0..processors.min(count)).map(|_| scope.spawn(some)).collect();
        let done = workers.into_iter().map(|worker| worker.join().unwrap_or_else(|panic| resume_unwind(panic)));
        done.collect::<Result<Vec<_>, E>>()
    })? {
        done.extend(some);
    }
    done.sort_by_key(|(index, _)| *index);
    Ok(done.into_iter().map(|(_, done)| done).collect())
}

/// Lets the system have large blocks as soon as they are free. The C library of Linux would keep them for the thread that had them, once
/// it has seen some: a quarter of what a comparison takes.
pub fn give_back_from_now_on() {
    // SAFETY: sets a number inside the allocator, which may be done at any time.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 20)
    };
}

/// Lets the system have what is free now.
pub fn give_back() {
    // SAFETY: looks through the allocator's own lists, which may be done at any time.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    unsafe {
        libc::malloc_trim(0)
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_and_an_error_ends_the_work() {
        assert_eq!(each(100, |index| Ok::<_, ()>(index * index)).unwrap()[99], 9801);
        assert_eq!(each(0, |_| Ok::<_, ()>(())), Ok(Vec::new()));
        let begun = AtomicUsize::new(0);
        let failing = |index| {
            begun.fetch_add(1, Ordering::Relaxed);
            if index == 3 { Err("the fourth") } else { Ok(()) }
        };
        assert_eq!(each(1_000_000, failing), Err("the fourth"));
        assert!(begun.into_inner() < 1_000_000);
    }
}
