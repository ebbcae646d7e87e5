//! One register of four lanes.

use super::{Add, Div, Four, Lanes, Mul, Number, Sub};
use std::arch::x86_64::{
    __m256d, _CMP_GT_OQ, _mm256_add_epi64, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd,
    _mm256_castpd_si256, _mm256_castsi256_pd, _mm256_cmp_pd, _mm256_div_pd, _mm256_loadu_pd, _mm256_max_pd,
    _mm256_min_pd, _mm256_mul_pd, _mm256_or_pd, _mm256_set1_pd, _mm256_slli_epi64, _mm256_storeu_pd, _mm256_sub_pd,
};

/// A register of four lanes. Only functions that are called where the processor has AVX2 may make one.
#[derive(Clone, Copy)]
pub(crate) struct Wide(__m256d);

/// Operators of [`Wide`], one instruction each.
macro_rules! one_instruction {
    ($($operator:ident $name:ident $instruction:ident),*) => {$(
        impl $operator for Wide {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: the processor has AVX2, see `Wide`.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    )*};
}

one_instruction!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

impl Number for Wide {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self(unsafe { _mm256_set1_pd(value) })
    }

    #[inline(always)]
    fn constant(lanes: &Lanes) -> Self {
        Self::load(lanes)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Self(_mm256_or_pd(_mm256_andnot_pd(sign, self.0), _mm256_and_pd(sign, other.0)))
        }
    }

    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`. Of a number and none, both instructions give the second.
        unsafe {
            let raised = _mm256_max_pd(_mm256_set1_pd(-limit), self.0);
            Self(_mm256_min_pd(_mm256_set1_pd(limit), raised))
        }
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`. Of a number and none, the instruction gives the second.
        Self(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`. Of a number and none, the instruction gives the second.
        Self(unsafe { _mm256_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn where_larger(self, other: Self, then: Self, or: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self(unsafe { _mm256_blendv_pd(or.0, then.0, _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0)) })
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let one = _mm256_castpd_si256(_mm256_set1_pd(1.0));
            let exponent = _mm256_slli_epi64::<52>(_mm256_castpd_si256(self.0));
            Self(_mm256_castsi256_pd(_mm256_add_epi64(exponent, one)))
        }
    }
}

impl Four for Wide {
    const IS_WIDE: bool = true;

    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`; four numbers are read of four.
        Self(unsafe { _mm256_loadu_pd(lanes.as_ptr()) })
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        let mut lanes = [0.0; 4];
        // SAFETY: the processor has AVX2, see `Wide`; four numbers are written to four.
        unsafe { _mm256_storeu_pd(lanes.as_mut_ptr(), self.0) };
        lanes
    }

    #[inline(always)]
    fn above(self, least: f64) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let larger = _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, _mm256_set1_pd(least));
            Self(_mm256_and_pd(self.0, larger))
        }
    }
}
