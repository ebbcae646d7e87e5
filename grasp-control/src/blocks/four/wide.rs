//! One register of four lanes.

use super::{Four, Lanes, Number, Wide};
use std::arch::x86_64::{
    _CMP_GT_OQ, _mm256_add_epi64, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd, _mm256_castpd_si256,
    _mm256_castsi256_pd, _mm256_cmp_pd, _mm256_max_pd, _mm256_min_pd, _mm256_or_pd, _mm256_set1_pd, _mm256_slli_epi64,
};

impl Number for Wide {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self::splat(value)
    }

    #[inline(always)]
    fn constant(lanes: &Lanes) -> Self {
        Self::load(lanes)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Self::of(_mm256_or_pd(_mm256_andnot_pd(sign, self.register()), _mm256_and_pd(sign, other.register())))
        }
    }

    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`. Of a number and none, both instructions give the second.
        unsafe {
            let raised = _mm256_max_pd(_mm256_set1_pd(-limit), self.register());
            Self::of(_mm256_min_pd(_mm256_set1_pd(limit), raised))
        }
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`. Of a number and none, the instruction gives the second.
        Self::of(unsafe { _mm256_max_pd(self.register(), other.register()) })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`. Of a number and none, the instruction gives the second.
        Self::of(unsafe { _mm256_min_pd(self.register(), other.register()) })
    }

    #[inline(always)]
    fn where_larger(self, other: Self, then: Self, or: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe {
            _mm256_blendv_pd(
                or.register(),
                then.register(),
                _mm256_cmp_pd::<_CMP_GT_OQ>(self.register(), other.register()),
            )
        })
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let one = _mm256_castpd_si256(_mm256_set1_pd(1.0));
            let exponent = _mm256_slli_epi64::<52>(_mm256_castpd_si256(self.register()));
            Self::of(_mm256_castsi256_pd(_mm256_add_epi64(exponent, one)))
        }
    }
}

impl Four for Wide {
    const IS_WIDE: bool = true;

    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        Self::load(lanes)
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        self.lanes()
    }

    #[inline(always)]
    fn above(self, least: f64) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let larger = _mm256_cmp_pd::<_CMP_GT_OQ>(self.register(), _mm256_set1_pd(least));
            Self::of(_mm256_and_pd(self.register(), larger))
        }
    }
}
