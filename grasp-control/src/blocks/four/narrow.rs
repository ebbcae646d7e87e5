//! Two registers of two lanes, which every x86-64 processor has.

use super::{Add, Div, Four, Lanes, Mul, Number, Sub};
use std::arch::x86_64::{
    __m128d, _mm_add_epi64, _mm_add_pd, _mm_and_pd, _mm_andnot_pd, _mm_castpd_si128, _mm_castsi128_pd, _mm_cmpgt_pd,
    _mm_cvtsd_f64, _mm_div_pd, _mm_loadu_pd, _mm_max_pd, _mm_min_pd, _mm_mul_pd, _mm_or_pd, _mm_set_pd, _mm_set1_pd,
    _mm_slli_epi64, _mm_storeu_pd, _mm_sub_epi64, _mm_sub_pd, _mm_unpackhi_pd, _mm_unpacklo_pd,
};

/// Four lanes in two registers.
#[derive(Clone, Copy)]
pub(crate) struct Narrow([__m128d; 2]);

impl Narrow {
    #[inline(always)]
    fn each(self, operation: impl Fn(__m128d) -> __m128d) -> Self {
        Self([operation(self.0[0]), operation(self.0[1])])
    }

    #[inline(always)]
    fn with(self, other: Self, operation: impl Fn(__m128d, __m128d) -> __m128d) -> Self {
        Self([operation(self.0[0], other.0[0]), operation(self.0[1], other.0[1])])
    }
}

/// Operators of [`Narrow`], two instructions each.
macro_rules! two_instructions {
    ($($operator:ident $name:ident $instruction:ident),*) => {$(
        impl $operator for Narrow {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: every x86-64 processor has SSE2.
                self.with(other, |a, b| unsafe { $instruction(a, b) })
            }
        }
    )*};
}

two_instructions!(Add add _mm_add_pd, Sub sub _mm_sub_pd, Mul mul _mm_mul_pd, Div div _mm_div_pd);

impl Number for Narrow {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: every x86-64 processor has SSE2.
        Self([unsafe { _mm_set1_pd(value) }; 2])
    }

    #[inline(always)]
    fn constant(lanes: &Lanes) -> Self {
        // SAFETY: every x86-64 processor has SSE2; two numbers are read of four.
        Self([unsafe { _mm_loadu_pd(lanes.as_ptr()) }; 2])
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: every x86-64 processor has SSE2.
        self.each(|x| unsafe { _mm_andnot_pd(_mm_set1_pd(-0.0), x) })
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        // SAFETY: every x86-64 processor has SSE2.
        self.with(other, |x, y| unsafe {
            let sign = _mm_set1_pd(-0.0);
            _mm_or_pd(_mm_andnot_pd(sign, x), _mm_and_pd(sign, y))
        })
    }

    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        // SAFETY: every x86-64 processor has SSE2. Of a number and none, both instructions give the second.
        self.each(|x| unsafe { _mm_min_pd(_mm_set1_pd(limit), _mm_max_pd(_mm_set1_pd(-limit), x)) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: every x86-64 processor has SSE2. Of a number and none, the instruction gives the second.
        self.with(other, |x, y| unsafe { _mm_max_pd(x, y) })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // SAFETY: every x86-64 processor has SSE2. Of a number and none, the instruction gives the second.
        self.with(other, |x, y| unsafe { _mm_min_pd(x, y) })
    }

    #[inline(always)]
    fn where_larger(self, other: Self, then: Self, or: Self) -> Self {
        // SAFETY: every x86-64 processor has SSE2.
        let larger = self.with(other, |x, y| unsafe { _mm_cmpgt_pd(x, y) });
        // SAFETY: every x86-64 processor has SSE2.
        let rest = larger.with(or, |larger, or| unsafe { _mm_andnot_pd(larger, or) });
        // SAFETY: every x86-64 processor has SSE2.
        let chosen = larger.with(then, |larger, then| unsafe { _mm_and_pd(larger, then) });
        // SAFETY: every x86-64 processor has SSE2.
        chosen.with(rest, |chosen, rest| unsafe { _mm_or_pd(chosen, rest) })
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // SAFETY: every x86-64 processor has SSE2.
        self.each(|x| unsafe {
            let one = _mm_castpd_si128(_mm_set1_pd(1.0));
            _mm_castsi128_pd(_mm_add_epi64(_mm_slli_epi64::<52>(_mm_castpd_si128(x)), one))
        })
    }
}

impl Four for Narrow {
    const IS_WIDE: bool = false;

    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        // SAFETY: every x86-64 processor has SSE2; four numbers are read of four.
        Self(unsafe { [_mm_loadu_pd(lanes.as_ptr()), _mm_loadu_pd(lanes.as_ptr().add(2))] })
    }

    #[inline(always)]
    fn pairs([a, b]: [f64; 2], [c, d]: [f64; 2]) -> Self {
        // SAFETY: every x86-64 processor has SSE2.
        Self(unsafe { [_mm_set_pd(b, a), _mm_set_pd(d, c)] })
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        let mut lanes = [0.0; 4];
        // SAFETY: every x86-64 processor has SSE2; four numbers are written to four.
        unsafe {
            _mm_storeu_pd(lanes.as_mut_ptr(), self.0[0]);
            _mm_storeu_pd(lanes.as_mut_ptr().add(2), self.0[1]);
        }
        lanes
    }

    #[inline(always)]
    fn above(self, least: f64) -> Self {
        // SAFETY: every x86-64 processor has SSE2.
        self.each(|x| unsafe { _mm_and_pd(x, _mm_cmpgt_pd(x, _mm_set1_pd(least))) })
    }

    #[inline(always)]
    fn powers_of_two(self) -> [Self; 2] {
        // SAFETY: every x86-64 processor has SSE2.
        let exponent = self.each(|x| unsafe { _mm_castsi128_pd(_mm_slli_epi64::<52>(_mm_castpd_si128(x))) });
        // SAFETY: every x86-64 processor has SSE2.
        let up = exponent.each(|x| unsafe {
            _mm_castsi128_pd(_mm_add_epi64(_mm_castpd_si128(_mm_set1_pd(1.0)), _mm_castpd_si128(x)))
        });
        // SAFETY: every x86-64 processor has SSE2.
        let down = exponent.each(|x| unsafe {
            _mm_castsi128_pd(_mm_sub_epi64(_mm_castpd_si128(_mm_set1_pd(1.0)), _mm_castpd_si128(x)))
        });
        [up, down]
    }

    #[inline(always)]
    fn last(self) -> f64 {
        // SAFETY: every x86-64 processor has SSE2.
        unsafe { _mm_cvtsd_f64(_mm_unpackhi_pd(self.0[1], self.0[1])) }
    }

    #[inline(always)]
    fn with_last(self, value: f64) -> Self {
        // SAFETY: every x86-64 processor has SSE2.
        Self([self.0[0], unsafe { _mm_unpacklo_pd(self.0[1], _mm_set1_pd(value)) }])
    }

    #[inline(always)]
    fn whole(self) -> Self {
        self
    }

    #[inline(always)]
    fn now(self) -> Self {
        self
    }

    #[inline(always)]
    fn columns(rows: [Self; 4]) -> [Self; 4] {
        let [a, b, c, d] = rows.map(|row| row.0);
        // SAFETY: every x86-64 processor has SSE2.
        unsafe {
            [
                Self([_mm_unpacklo_pd(a[0], b[0]), _mm_unpacklo_pd(c[0], d[0])]),
                Self([_mm_unpackhi_pd(a[0], b[0]), _mm_unpackhi_pd(c[0], d[0])]),
                Self([_mm_unpacklo_pd(a[1], b[1]), _mm_unpacklo_pd(c[1], d[1])]),
                Self([_mm_unpackhi_pd(a[1], b[1]), _mm_unpackhi_pd(c[1], d[1])]),
            ]
        }
    }
}
