//! Four numbers in one wide register.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::{DeadZones, Four};
use super::step::NEGLIGIBLE;
use super::table::Lanes;
pub(crate) use grasp_kernel::Wide;
use std::arch::x86_64::{
    _CMP_GE_OQ, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _CMP_NLT_UQ, _mm_add_pd, _mm_cmplt_pd, _mm_loadu_pd,
    _mm_movemask_pd, _mm_setzero_pd, _mm256_and_pd, _mm256_blend_pd, _mm256_castpd_si256, _mm256_castpd256_pd128,
    _mm256_cmp_pd, _mm256_extractf128_pd, _mm256_hadd_pd, _mm256_max_pd, _mm256_min_pd, _mm256_movemask_pd,
    _mm256_or_pd, _mm256_permute2f128_pd, _mm256_permute4x64_pd, _mm256_set1_epi64x, _mm256_set1_pd,
    _mm256_testc_si256, _mm256_testz_si256, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
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
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn spread<const LANE: usize>(self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe {
            match LANE {
                0 => _mm256_permute4x64_pd::<0b00_00_00_00>(self.register()),
                1 => _mm256_permute4x64_pd::<0b01_01_01_01>(self.register()),
                2 => _mm256_permute4x64_pd::<0b10_10_10_10>(self.register()),
                _ => _mm256_permute4x64_pd::<0b11_11_11_11>(self.register()),
            }
        })
    }

    #[inline(always)]
    fn with_last_of(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe { _mm256_blend_pd::<0b1000>(self.register(), other.register()) })
    }

    #[inline(always)]
    fn last_twos(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe { _mm256_permute2f128_pd::<0x31>(self.register(), other.register()) })
    }

    #[inline(always)]
    fn in_turns(self, other: Self) -> (Self, Self) {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            (
                Self::of(_mm256_unpacklo_pd(self.register(), other.register())),
                Self::of(_mm256_unpackhi_pd(self.register(), other.register())),
            )
        }
    }

    #[inline(always)]
    fn apart(self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        let rest = Self::of(unsafe { _mm256_permute4x64_pd::<0b11_01_00_00>(self.register()) });
        rest + self.spread::<2>() * Self::load(&[1.0, -1.0, 0.0, 0.0])
    }

    #[inline(always)]
    fn limited(self, low: Self, high: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`. Of numbers that are equal, and of NaN, the second is taken, as above.
        unsafe {
            let limited = _mm256_max_pd(low.register(), self.register());
            Self::of(_mm256_min_pd(high.register(), limited))
        }
    }

    #[inline(always)]
    fn behind_dead_zones(self, zones: &DeadZones) -> Self {
        let [(right, right_slope), (left, left_slope)] =
            [&zones.upper, &zones.lower].map(|(ends, slopes)| (Self::load(ends), Self::load(slopes)));
        let (beyond, below) = (right_slope * (self - right), left_slope * (self - left));
        // SAFETY: the processor has AVX2, see `Wide`. No number is on both sides.
        unsafe {
            let beyond =
                _mm256_and_pd(beyond.register(), _mm256_cmp_pd::<_CMP_GT_OQ>(self.register(), right.register()));
            let below = _mm256_and_pd(below.register(), _mm256_cmp_pd::<_CMP_LT_OQ>(self.register(), left.register()));
            Self::of(_mm256_or_pd(beyond, below))
        }
    }

    #[inline(always)]
    fn is_any_limited(self, low: Self, high: Self) -> bool {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let below = _mm256_cmp_pd::<_CMP_LE_OQ>(self.register(), low.register());
            let above = _mm256_cmp_pd::<_CMP_GE_OQ>(self.register(), high.register());
            _mm256_movemask_pd(_mm256_or_pd(below, above)) != 0
        }
    }

    #[inline(always)]
    fn are_sizes_below(self, other: Self, limit: f64) -> bool {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let size = (self.abs() + other.abs()).register();
            _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(size, _mm256_set1_pd(limit))) == 0b1111
        }
    }

    #[inline(always)]
    fn are_zeros(numbers: &[f64; 6]) -> bool {
        let some = |first: usize| Self::load(numbers[first..].first_chunk().unwrap_or(&[f64::NAN; 4])).register();
        // SAFETY: the processor has AVX2, see `Wide`. Without the signs: a negative zero is one.
        unsafe {
            let bits = _mm256_castpd_si256(_mm256_or_pd(some(0), some(2)));
            _mm256_testz_si256(bits, _mm256_set1_epi64x(i64::MAX)) != 0
        }
    }

    #[inline(always)]
    fn is_any_sum_negative([first, second]: [Self; 2], addends: [f64; 2]) -> bool {
        // SAFETY: the processor has AVX2, see `Wide`; two numbers are read of two.
        unsafe {
            let pairs = _mm256_hadd_pd(first.register(), second.register());
            let (lower, upper) = (_mm256_castpd256_pd128(pairs), _mm256_extractf128_pd::<1>(pairs));
            let sums = _mm_add_pd(_mm_add_pd(lower, upper), _mm_loadu_pd(addends.as_ptr()));
            _mm_movemask_pd(_mm_cmplt_pd(sums, _mm_setzero_pd())) != 0
        }
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
    fn common(self, other: Self) -> Self {
        // SAFETY: the processor has AVX2, see `Wide`.
        Self::of(unsafe { _mm256_and_pd(self.register(), other.register()) })
    }

    #[inline(always)]
    fn have_all(self, bit: u64) -> bool {
        // SAFETY: the processor has AVX2, see `Wide`.
        unsafe {
            let bit = _mm256_set1_epi64x(bit.cast_signed());
            _mm256_testc_si256(_mm256_castpd_si256(self.register()), bit) != 0
        }
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
