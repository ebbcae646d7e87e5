//! A memory barrier that every processor passes, and a number for each thread: what [`Guard`](super::guard::Guard) needs of the system.
//! Where there is none of it, guards have no owners.

pub use system::{HAS_BARRIER, barrier, can_bar, this_thread};

/// Linux has the system call `membarrier` since version 4.14 (2017). Sandboxes may forbid it.
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod system {
    use std::arch::asm;
    use std::ffi::{c_int, c_long};
    use std::sync::atomic::{AtomicU8, Ordering};

    /// Whether there can be such a barrier: [`can_bar`] asks the system.
    pub const HAS_BARRIER: bool = true;

    unsafe extern "C" {
        /// Of the C library, which is linked anyway.
        fn syscall(number: c_long, ...) -> c_long;
    }

    const MEMBARRIER: c_long = if cfg!(target_arch = "x86_64") { 324 } else { 283 };
    // Of `linux/membarrier.h`.
    const QUERY: c_int = 0;
    const PRIVATE_EXPEDITED: c_int = 1 << 3;
    const REGISTER_PRIVATE_EXPEDITED: c_int = 1 << 4;

    fn membarrier(command: c_int) -> c_long {
        // SAFETY: the system call takes three such numbers, and no memory.
        unsafe { syscall(MEMBARRIER, command, 0 as c_int, 0 as c_int) }
    }

    const UNKNOWN: u8 = 2;
    /// Whether there is such a barrier: 0 or 1 once it is known.
    static FOUND: AtomicU8 = AtomicU8::new(UNKNOWN);

    /// Makes all processors that run a thread of this process pass a memory barrier. Where a sandbox has forbidden that since somebody
    /// relied on it, waits: all processors see a store in far less time.
    pub fn barrier() {
        let pass = || membarrier(PRIVATE_EXPEDITED) == 0;
        // A process has to say once that it uses it. That can take milliseconds, so not before it is needed.
        let has_passed = pass() || (membarrier(REGISTER_PRIVATE_EXPEDITED) == 0 && pass());
        if !has_passed {
            FOUND.store(0, Ordering::Relaxed);
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
    }

    /// Whether there is such a barrier.
    pub fn can_bar() -> bool {
        let found = FOUND.load(Ordering::Relaxed);
        if found != UNKNOWN {
            return found == 1;
        }
        let needed = c_long::from(PRIVATE_EXPEDITED | REGISTER_PRIVATE_EXPEDITED);
        let known = membarrier(QUERY);
        let can = known > 0 && known & needed == needed;
        FOUND.store(u8::from(can), Ordering::Relaxed);
        can
    }

    /// A number that no other living thread has: where its thread-local memory is.
    #[allow(clippy::inline_always)] // On the way of every step.
    #[inline(always)]
    pub fn this_thread() -> usize {
        let thread: usize;
        // SAFETY: reads a register or, through it, a word, which the ABI of thread-local memory has in every thread.
        unsafe {
            #[cfg(target_arch = "x86_64")]
            asm!("mov {}, fs:[0]", out(reg) thread, options(pure, readonly, nostack, preserves_flags));
            #[cfg(target_arch = "aarch64")]
            asm!("mrs {}, tpidr_el0", out(reg) thread, options(pure, nomem, nostack, preserves_flags));
        }
        thread
    }
}

#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod system {
    pub const HAS_BARRIER: bool = false;

    /// Nobody relies on it: there are no owners.
    pub fn barrier() {}

    pub fn can_bar() -> bool {
        false
    }

    /// Nobody asks which it is: there are no owners.
    #[inline]
    pub fn this_thread() -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn living_threads_have_different_numbers_and_each_keeps_its_own() {
        let own = this_thread();
        assert_eq!(own, this_thread());
        let other = std::thread::scope(|scope| scope.spawn(this_thread).join().unwrap());
        assert_eq!(own != other, can_bar() || own != 0);
        // A barrier that the system says it has is one: it is still there once it was used.
        let could = can_bar();
        barrier();
        assert_eq!(can_bar(), could);
    }
}
