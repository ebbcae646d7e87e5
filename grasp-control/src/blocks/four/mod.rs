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
pub(crate) use grasp_kernel::{Wide, has_wide_registers};
#[cfg(target_arch = "x86_64")]
pub(crate) use narrow::Narrow;
#[cfg(test)]
pub(crate) use portable::Portable;
#[cfg(not(target_arch = "x86_64"))]
pub(crate) use portable::Portable as Narrow;

use std::ops::{Add, Div, Mul, Sub};

/// Numbers that are computed with at once.
pub(crate) const LANES: usize = 4;

/// Four numbers in memory.
pub(crate) use grasp_kernel::Lanes;

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
    /// Two pairs of numbers, which are read pair by pair where they come from memory.
    fn pairs(first: [f64; 2], second: [f64; 2]) -> Self;
    fn lanes(self) -> Lanes;
    /// Zero where it is not larger than `least`, and where it is no number.
    fn above(self, least: f64) -> Self;
    /// 2^k and 2^−k where the lowest bits of this are those of the integer k.
    fn powers_of_two(self) -> [Self; 2];
    /// The last lane.
    fn last(self) -> f64;
    /// With another number in the last lane.
    fn with_last(self, value: f64) -> Self;
    /// The same, which the compiler then has in one register and stores at once: from two halves in memory that are on their way to the
    /// cache, a processor cannot read it back, and waits.
    #[must_use]
    fn whole(self) -> Self;
    /// The same, which the compiler finds here, and not where it is needed first.
    #[must_use]
    fn now(self) -> Self;
    /// The first lanes of four rows, the second ones, …
    fn columns(rows: [Self; LANES]) -> [Self; LANES];
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
