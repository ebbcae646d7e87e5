//! Which registers the networks are evaluated in: the widest the processor has. The bits are the same in all of them.

/// Whether the processor has registers of four lanes, and can shift the numbers in them.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn has_wide_registers() -> bool {
    #[cfg(test)]
    if narrow::is_on() {
        return false;
    }
    std::arch::is_x86_feature_detected!("avx2")
}

/// For tests that compare: a thread that computes as on a processor without wide registers.
#[cfg(test)]
pub(crate) mod narrow {
    use std::cell::Cell;

    thread_local! {
        static ON: Cell<bool> = const { Cell::new(false) };
    }

    #[cfg(target_arch = "x86_64")]
    pub(super) fn is_on() -> bool {
        ON.get()
    }

    /// What `work` gives without wide registers.
    pub fn narrowly<T>(work: impl FnOnce() -> T) -> T {
        ON.set(true);
        let result = work();
        ON.set(false);
        result
    }
}
