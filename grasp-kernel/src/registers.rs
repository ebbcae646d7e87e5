//! Registers of four lanes, and whether to use them.

/// Four numbers in memory.
pub type Lanes = [f64; 4];

/// Whether to compute in registers of four lanes: the processor has them, and can shift the numbers in them (AVX2).
///
/// Built with `--cfg narrow_registers` it never is, which is for measurements; nor within [`narrowly`].
#[cfg(target_arch = "x86_64")]
#[inline(always)]
#[must_use]
pub fn has_wide_registers() -> bool {
    if cfg!(debug_assertions) && narrow::is_on() {
        return false;
    }
    !cfg!(narrow_registers) && std::arch::is_x86_feature_detected!("avx2")
}

/// The result of `work` as on a processor without wide registers: for tests that compare.
///
/// # Panics
/// In a build without checks, as the FMUs' libraries are: there every step would ask.
#[allow(clippy::assertions_on_constants)] // Of this build; a test that compares the same with the same must fail.
pub fn narrowly<T>(work: impl FnOnce() -> T) -> T {
    assert!(cfg!(debug_assertions), "built without checks, it would compute as ever");
    narrow::set(true);
    let result = work();
    narrow::set(false);
    result
}

/// Whether the thread computes narrowly.
mod narrow {
    use std::cell::Cell;

    thread_local! {
        static ON: Cell<bool> = const { Cell::new(false) };
    }

    #[cfg(target_arch = "x86_64")]
    pub fn is_on() -> bool {
        ON.get()
    }

    pub fn set(on: bool) {
        ON.set(on);
    }
}

#[cfg(target_arch = "x86_64")]
pub use wide::Wide;

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::Lanes;
    use std::arch::x86_64::{
        __m256d, _mm256_add_pd, _mm256_andnot_pd, _mm256_div_pd, _mm256_loadu_pd, _mm256_mul_pd, _mm256_set1_pd,
        _mm256_storeu_pd, _mm256_sub_pd,
    };
    use std::ops::{Add, Div, Mul, Sub};

    /// A register of four lanes. Only functions that are called where [`has_wide_registers`](super::has_wide_registers) is true may
    /// make one.
    #[derive(Clone, Copy, Debug)]
    pub struct Wide(__m256d);

    /// Operators, one instruction each.
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

    impl Wide {
        /// Of a register that the processor's own functions have filled.
        #[inline(always)]
        #[must_use]
        pub fn of(register: __m256d) -> Self {
            Self(register)
        }

        /// For the processor's own functions.
        #[inline(always)]
        #[must_use]
        pub fn register(self) -> __m256d {
            self.0
        }

        /// The same number in all lanes.
        #[inline(always)]
        #[must_use]
        pub fn splat(value: f64) -> Self {
            // SAFETY: the processor has AVX2, see `Wide`.
            Self(unsafe { _mm256_set1_pd(value) })
        }

        /// Four numbers from memory.
        #[inline(always)]
        #[must_use]
        pub fn load(lanes: &Lanes) -> Self {
            // SAFETY: the processor has AVX2, see `Wide`; four numbers are read of four.
            Self(unsafe { _mm256_loadu_pd(lanes.as_ptr()) })
        }

        /// The four numbers.
        #[inline(always)]
        #[must_use]
        pub fn lanes(self) -> Lanes {
            let mut lanes = [0.0; 4];
            // SAFETY: the processor has AVX2, see `Wide`; four numbers are written to four.
            unsafe { _mm256_storeu_pd(lanes.as_mut_ptr(), self.0) };
            lanes
        }

        /// Absolute values.
        #[inline(always)]
        #[must_use]
        pub fn abs(self) -> Self {
            // SAFETY: the processor has AVX2, see `Wide`.
            Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
        }
    }
}
