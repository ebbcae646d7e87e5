//! Four numbers side by side: in one wide register, or in two where the processor has no wide ones, or one by one.
//!
//! All ways do the same operations, none fused, so all give the same bits; so does one number alone. Formulas are written once,
//! for any [`Number`], loops for any [`Four`].

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

#[cfg(target_arch = "x86_64")]
mod narrow;
#[cfg(any(test, not(target_arch = "x86_64")))]
mod portable;
#[cfg(target_arch = "x86_64")]
mod wide;

#[cfg(target_arch = "x86_64")]
pub(crate) use narrow::Narrow;
#[cfg(test)]
pub(crate) use portable::Portable;
#[cfg(not(target_arch = "x86_64"))]
pub(crate) use portable::Portable as Narrow;
#[cfg(target_arch = "x86_64")]
pub(crate) use wide::Wide;

use std::ops::{Add, Div, Mul, Sub};

/// Numbers that are computed with at once.
pub(crate) const LANES: usize = 4;

/// Four numbers in memory.
pub(crate) type Lanes = [f64; LANES];

/// One number, or several side by side.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn splat(value: f64) -> Self;
    /// A number that stands in four lanes.
    fn constant(lanes: &Lanes) -> Self;
    fn abs(self) -> Self;
    /// The magnitude of this with the sign of `other`.
    fn with_sign_of(self, other: Self) -> Self;
    /// Clamped to ±`limit`; what is no number stays so.
    fn within(self, limit: f64) -> Self;
    /// The larger one; `other` where one of them is no number.
    fn larger(self, other: Self) -> Self;
    /// The smaller one; `other` where one of them is no number.
    fn smaller(self, other: Self) -> Self;
    /// `then` where this is larger than `other`, else `or`.
    fn where_larger(self, other: Self, then: Self, or: Self) -> Self;
    /// 2^k where the lowest bits of this are those of the integer k.
    fn power_of_two(self) -> Self;
}

/// Four numbers.
pub(crate) trait Four: Number {
    /// Whether it is one wide register.
    const IS_WIDE: bool;
    fn load(lanes: &Lanes) -> Self;
    fn lanes(self) -> Lanes;
    /// Zero where it is not larger than `least`, and where it is no number.
    fn above(self, least: f64) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn constant(lanes: &Lanes) -> Self {
        lanes[0]
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        self.copysign(other)
    }

    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        self.clamp(-limit, limit)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn where_larger(self, other: Self, then: Self, or: Self) -> Self {
        if self > other { then } else { or }
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self::from_bits((self.to_bits() << 52).wrapping_add(1.0_f64.to_bits()))
    }
}

/// Whether to compute in registers of four lanes: the processor has them, and can shift the numbers in them.
///
/// Built with `--cfg narrow_registers` it never is, which is for measurements.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn has_wide_registers() -> bool {
    #[cfg(test)]
    if narrowed::is_on() {
        return false;
    }
    !cfg!(narrow_registers) && std::arch::is_x86_feature_detected!("avx2")
}

/// For tests that compare: a thread that computes as on a processor without wide registers.
#[cfg(test)]
pub(crate) mod narrowed {
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
