//! Four numbers side by side: in one wide register, or one by one where the processor has none.
//!
//! Both ways do the same operations, none fused, so both give the same bits; so does one number alone. Formulas are written once,
//! for any [`Number`], loops for any [`Four`].

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

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
    /// As many of these as it has places.
    fn first(lanes: &Lanes) -> Self;
    fn abs(self) -> Self;
    /// The magnitude of this with the sign of `other`.
    fn with_sign_of(self, other: Self) -> Self;
    /// Clamped to ±`limit`; what is no number stays so.
    fn within(self, limit: f64) -> Self;
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
    fn first(lanes: &Lanes) -> Self {
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
    fn power_of_two(self) -> Self {
        Self::from_bits((self.to_bits() << 52).wrapping_add(1.0_f64.to_bits()))
    }
}

/// Four numbers one by one, for processors without wide registers.
#[derive(Clone, Copy)]
pub(crate) struct Narrow(Lanes);

/// Operators of [`Narrow`], lane by lane.
macro_rules! lane_by_lane {
    ($($operator:ident $name:ident),*) => {$(
        impl $operator for Narrow {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let (a, b) = (self.0, other.0);
                Self([a[0].$name(b[0]), a[1].$name(b[1]), a[2].$name(b[2]), a[3].$name(b[3])])
            }
        }
    )*};
}

lane_by_lane!(Add add, Sub sub, Mul mul, Div div);

impl Number for Narrow {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn first(lanes: &Lanes) -> Self {
        Self(*lanes)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane].copysign(other.0[lane])))
    }

    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        Self(self.0.map(|x| x.within(limit)))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self(self.0.map(f64::power_of_two))
    }
}

impl Four for Narrow {
    const IS_WIDE: bool = false;

    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        Self(*lanes)
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        self.0
    }

    #[inline(always)]
    fn above(self, least: f64) -> Self {
        Self(self.0.map(|x| if x > least { x } else { 0.0 }))
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) use wide::Wide;

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{Add, Div, Four, Lanes, Mul, Number, Sub};
    use std::arch::x86_64::{
        __m256d, _CMP_GT_OQ, _mm256_add_epi64, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_castpd_si256,
        _mm256_castsi256_pd, _mm256_cmp_pd, _mm256_div_pd, _mm256_loadu_pd, _mm256_max_pd, _mm256_min_pd,
        _mm256_mul_pd, _mm256_or_pd, _mm256_set1_pd, _mm256_slli_epi64, _mm256_storeu_pd, _mm256_sub_pd,
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
        fn first(lanes: &Lanes) -> Self {
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
}

/// Whether the processor has registers of four lanes, and can shift the numbers in them.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn has_wide_registers() -> bool {
    #[cfg(test)]
    if narrow::is_on() {
        return false;
    }
    std::arch::is_x86_feature_detected!("avx2")
}

/// For tests that compare: a thread that computes as on a processor without wide registers.
#[cfg(test)]
pub(crate) mod narrow {
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
