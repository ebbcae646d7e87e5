//! Four numbers side by side: in one wide register, or one by one if the processor has none.
//!
//! Both ways do the same operations, none fused, so both give the same bits. Loops are written once, for any [`Four`].

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::step::NEGLIGIBLE;
use super::table::Lanes;

pub(super) trait Four: Copy {
    fn splat(value: f64) -> Self;
    fn load(lanes: &Lanes) -> Self;
    fn lanes(self) -> Lanes;
    fn plus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    /// Zero where it is [`NEGLIGIBLE`].
    fn kept(self) -> Self;
    /// Absolute values.
    fn size(self) -> Self;
    /// Whether all four are; NaN is not.
    fn is_below(self, limit: f64) -> bool;
}

impl Four for Lanes {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        [value; 4]
    }

    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        *lanes
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        self
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        [self[0] + other[0], self[1] + other[1], self[2] + other[2], self[3] + other[3]]
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        [self[0] * other[0], self[1] * other[1], self[2] * other[2], self[3] * other[3]]
    }

    #[inline(always)]
    fn kept(mut self) -> Self {
        for x in &mut self {
            if x.abs() < NEGLIGIBLE {
                *x = 0.0;
            }
        }
        self
    }

    #[inline(always)]
    fn size(self) -> Self {
        self.map(f64::abs)
    }

    #[inline(always)]
    fn is_below(self, limit: f64) -> bool {
        self.iter().all(|x| *x < limit)
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use grasp_kernel::Wide;

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{Four, Lanes, NEGLIGIBLE, Wide};
    use std::arch::x86_64::{_CMP_NLT_UQ, _mm256_and_pd, _mm256_cmp_pd, _mm256_movemask_pd, _mm256_set1_pd};

    impl Four for Wide {
        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self::splat(value)
        }

        #[inline(always)]
        fn load(lanes: &Lanes) -> Self {
            Self::load(lanes)
        }

        #[inline(always)]
        fn lanes(self) -> Lanes {
            self.lanes()
        }

        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            self + other
        }

        #[inline(always)]
        fn times(self, other: Self) -> Self {
            self * other
        }

        #[inline(always)]
        fn kept(self) -> Self {
            // SAFETY: the processor has AVX2, see `Wide`. NaN is kept, as above.
            unsafe {
                let keep = _mm256_cmp_pd::<_CMP_NLT_UQ>(self.abs().register(), _mm256_set1_pd(NEGLIGIBLE));
                Self::of(_mm256_and_pd(self.register(), keep))
            }
        }

        #[inline(always)]
        fn size(self) -> Self {
            self.abs()
        }

        #[inline(always)]
        fn is_below(self, limit: f64) -> bool {
            // SAFETY: the processor has AVX2, see `Wide`.
            unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_NLT_UQ>(self.register(), _mm256_set1_pd(limit))) == 0 }
        }
    }
}
