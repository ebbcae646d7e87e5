//! The floating-point environment of a thread, which foreign code may change: how results are rounded, whether small
//! numbers are flushed to zero, whether an overflow raises a signal. A library that was compiled with `-ffast-math` changes
//! it when it is loaded; others change it when they compute. This must not affect the host or other FMUs.

/// The floating-point environment of a thread at one moment. Who makes many calls one after the other, and changes nothing in between,
/// looks once: to look takes the processor as long as dozens of other instructions.
#[derive(Debug, Clone, Copy)]
pub struct Environment(Settings);

impl Environment {
    /// The present one of this thread.
    #[inline]
    #[must_use]
    pub fn now() -> Self {
        Self(control())
    }

    /// Runs foreign code, and leaves this environment.
    #[allow(clippy::inline_always)] // As a call of its own it would cost more than it does.
    #[inline(always)]
    pub(crate) fn guard<T>(self, foreign: impl FnOnce() -> T) -> T {
        let result = foreign();
        if control() != self.0 {
            restore(self.0);
        }
        result
    }
}

/// Runs foreign code, and leaves the environment as it was before.
#[inline]
pub(crate) fn guarded<T>(foreign: impl FnOnce() -> T) -> T {
    Environment::now().guard(foreign)
}

#[cfg(target_arch = "x86_64")]
type Settings = u32;
#[cfg(target_arch = "aarch64")]
type Settings = u64;
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
type Settings = ();

/// The settings of the environment.
#[cfg(target_arch = "x86_64")]
#[inline]
fn control() -> Settings {
    /// The lowest six bits are flags of exceptions that occurred; every operation may change them.
    const SETTINGS: u32 = !0x3f;
    let mut register = 0_u32;
    // SAFETY: writes the register MXCSR to the given place, which has its size.
    unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &mut register, options(nostack, preserves_flags)) };
    register & SETTINGS
}

/// Sets the environment. The older x87 unit, which the C library changes together with it and Rust never uses, gets the
/// initial settings of a process.
#[cfg(target_arch = "x86_64")]
#[cold]
fn restore(settings: Settings) {
    const X87: u16 = 0x037f;
    // SAFETY: reads the registers from places of their sizes. Pending exceptions of the older unit are cleared first: a
    // trap that is armed there would go off.
    unsafe {
        std::arch::asm!("fnclex", "fldcw [{}]", "ldmxcsr [{}]", in(reg) &X87, in(reg) &settings, options(nostack));
    }
}

/// The settings of the environment.
#[cfg(target_arch = "aarch64")]
#[inline]
fn control() -> Settings {
    let register: u64;
    // SAFETY: reads a register.
    unsafe { std::arch::asm!("mrs {}, fpcr", out(reg) register, options(nostack, preserves_flags)) };
    register
}

/// Sets the environment.
#[cfg(target_arch = "aarch64")]
#[cold]
fn restore(settings: Settings) {
    // SAFETY: gives the register the value that it had.
    unsafe { std::arch::asm!("msr fpcr, {}", in(reg) settings, options(nostack, preserves_flags)) };
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn control() {}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn restore((): ()) {}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use std::hint::black_box;

    use super::*;

    #[test]
    fn what_foreign_code_changes_is_as_before() {
        const FLUSH_TO_ZERO: u32 = 1 << 15;
        const UPWARD: u32 = 0b10 << 13;
        const TRAP_ON_DIVISION: u32 = 1 << 9;
        let tiny = || black_box(f64::MIN_POSITIVE) * black_box(0.5);
        let third = || black_box(1.0_f64) / black_box(3.0);
        let before = (control(), tiny().to_bits(), third().to_bits());
        for change in [FLUSH_TO_ZERO, UPWARD, TRAP_ON_DIVISION] {
            let host = Environment::now();
            // Twice: the environment at the beginning does for all.
            for _ in 0..2 {
                let inside = host.guard(|| {
                    restore(before.0 ^ change);
                    control()
                });
                assert_eq!(inside, before.0 ^ change);
                assert_eq!((control(), tiny().to_bits(), third().to_bits()), before);
            }
        }
        assert!((black_box(1.0) / black_box(0.0_f64)).is_infinite(), "no trap is left");
    }
}
