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
    /// The larger of these and of the filler minus the sizes of `values`: a filler of −0.0 leaves the sizes, one of −1.0 makes each result
    /// −1.0 or less. Of numbers that are all finite.
    fn lowered(self, values: Self, filler: &Lanes) -> Self;
    /// Whether any is.
    fn is_any_above(self, limit: f64) -> bool;
    /// The sum of the lanes of each.
    fn sums(of: [Self; 4]) -> Self;
    /// Whether the sums of all rows fit into the registers.
    const HOLDS_ALL_ROWS: bool;
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
    fn lowered(self, values: Self, filler: &Lanes) -> Self {
        std::array::from_fn(|lane| {
            let value = f64::from_bits(values[lane].to_bits() | filler[lane].to_bits());
            if value > self[lane] { value } else { self[lane] }
        })
    }

    #[inline(always)]
    fn is_any_above(self, limit: f64) -> bool {
        self.iter().any(|x| *x > limit)
    }

    #[inline(always)]
    fn sums(of: [Self; 4]) -> Self {
        of.map(|lanes| (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]))
    }

    const HOLDS_ALL_ROWS: bool = false;
}

#[cfg(target_arch = "x86_64")]
pub(super) use grasp_kernel::Wide;

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{Four, Lanes, NEGLIGIBLE, Wide};
    use std::arch::x86_64::{
        _CMP_GT_OQ, _CMP_NLT_UQ, _mm256_and_pd, _mm256_cmp_pd, _mm256_hadd_pd, _mm256_max_pd, _mm256_movemask_pd,
        _mm256_or_pd, _mm256_permute2f128_pd, _mm256_set1_pd,
    };

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
        fn lowered(self, values: Self, filler: &Lanes) -> Self {
            // SAFETY: the processor has AVX2, see `Wide`.
            unsafe {
                let values = _mm256_or_pd(values.register(), Self::load(filler).register());
                Self::of(_mm256_max_pd(values, self.register()))
            }
        }

        #[inline(always)]
        fn is_any_above(self, limit: f64) -> bool {
            // SAFETY: the processor has AVX2, see `Wide`.
            unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(self.register(), _mm256_set1_pd(limit))) != 0 }
        }

        #[inline(always)]
        fn sums([a, b, c, d]: [Self; 4]) -> Self {
            // SAFETY: the processor has AVX2, see `Wide`.
            unsafe {
                let (left, right) =
                    (_mm256_hadd_pd(a.register(), b.register()), _mm256_hadd_pd(c.register(), d.register()));
                let lower = _mm256_permute2f128_pd::<0x20>(left, right);
                Self::of(lower) + Self::of(_mm256_permute2f128_pd::<0x31>(left, right))
            }
        }

        const HOLDS_ALL_ROWS: bool = true;
    }
}
