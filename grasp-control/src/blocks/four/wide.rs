//! One register of four lanes.

use super::{Four, Lanes, Number, Wide};
use std::arch::x86_64::{
    __m128d, __m256d, _CMP_GT_OQ, _mm_set_pd, _mm256_add_epi64, _mm256_and_pd, _mm256_andnot_pd, _mm256_blend_pd,
    _mm256_blendv_pd, _mm256_castpd_si256, _mm256_castpd128_pd256, _mm256_castsi256_pd, _mm256_cmp_pd,
    _mm256_insertf128_pd, _mm256_max_pd, _mm256_min_pd, _mm256_or_pd, _mm256_permute2f128_pd, _mm256_set1_pd,
    _mm256_slli_epi64, _mm256_sub_epi64, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
};

#[target_feature(enable = "avx2")]
#[inline]
fn whole(mut register: __m256d) -> __m256d {
    // SAFETY: no instruction at all; the register stays what it is.
    unsafe {
        std::arch::asm!("/* {0} */", inout(ymm_reg) register, options(pure, nomem, nostack, preserves_flags));
    }
    register
}

#[target_feature(enable = "avx2")]
#[inline]
fn now(mut register: __m256d) -> __m256d {
    // SAFETY: no instruction at all; the register stays what it is. Not `pure`: then the compiler may find it later.
    unsafe {
        std::arch::asm!("/* {0} */", inout(ymm_reg) register, options(nomem, nostack, preserves_flags));
    }
    register
}

/// The same two numbers, of which the compiler does not know any more where they come from.
#[target_feature(enable = "avx2")]
#[inline]
fn pair(mut register: __m128d) -> __m128d {
    // SAFETY: no instruction at all; the register stays what it is.
    unsafe {
        std::arch::asm!("/* {0} */", inout(xmm_reg) register, options(pure, nomem, nostack, preserves_flags));
    }
    register
}

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
    fn pairs([a, b]: [f64; 2], [c, d]: [f64; 2]) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe {
            let first = pair(_mm_set_pd(b, a));
            _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(first), _mm_set_pd(d, c))
        })
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

    #[inline(always)]
    fn powers_of_two(self) -> [Self; 2] {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let one = _mm256_castpd_si256(_mm256_set1_pd(1.0));
            let exponent = _mm256_slli_epi64::<52>(_mm256_castpd_si256(self.register()));
            [_mm256_add_epi64(one, exponent), _mm256_sub_epi64(one, exponent)]
                .map(|bits| Self::of(_mm256_castsi256_pd(bits)))
        }
    }

    #[inline(always)]
    fn last(self) -> f64 {
        self.lanes()[3]
    }

    #[inline(always)]
    fn with_last(self, value: f64) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe { _mm256_blend_pd::<0b1000>(self.register(), _mm256_set1_pd(value)) })
    }

    #[inline(always)]
    fn whole(self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe { whole(self.register()) })
    }

    #[inline(always)]
    fn now(self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe { now(self.register()) })
    }

    #[inline(always)]
    fn columns(rows: [Self; 4]) -> [Self; 4] {
        let [a, b, c, d] = rows.map(Self::register);
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let (even, odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (even2, odd2) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            [
                Self::of(_mm256_permute2f128_pd::<0x20>(even, even2)),
                Self::of(_mm256_permute2f128_pd::<0x20>(odd, odd2)),
                Self::of(_mm256_permute2f128_pd::<0x31>(even, even2)),
                Self::of(_mm256_permute2f128_pd::<0x31>(odd, odd2)),
            ]
        }
    }
}
