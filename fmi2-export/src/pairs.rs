//! Numbers and value references two at a time, for what a host sets and reads at every step.
//!
//! Each number is read by itself: where two numbers have just been written one by one, a processor that is to read both at once waits until they
//! are in its cache, some 20 cycles.
#![allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.

pub(crate) use numbers::{Range, Two};

/// Whether value references follow each other, from the first on; there must be as many references. An odd number of them leaves pairs behind
/// the first, which is what it is.
#[inline(always)]
pub(crate) fn follow_each_other(references: &[u32], first: u32) -> bool {
    let mut i = references.len() % 2;
    let mut expected = both(first, i);
    while i < references.len() {
        // SAFETY: an even number of them is left.
        if unsafe { two(references, i) } != expected {
            return false;
        }
        expected = expected.wrapping_add(TWO_LATER);
        i += 2;
    }
    true
}

/// Two value references as one number.
///
/// # Safety
/// There must be two from this place on.
#[inline(always)]
pub(crate) unsafe fn two(references: &[u32], i: usize) -> u64 {
    // SAFETY: the caller's promise.
    let (first, second) = unsafe { (*references.get_unchecked(i), *references.get_unchecked(i + 1)) };
    u64::from(first) | u64::from(second) << 32
}

/// The first reference, or the `i`-th after it, and the next one, as one number.
#[inline(always)]
pub(crate) fn both(first: u32, i: usize) -> u64 {
    let first = u64::from(first) + i as u64;
    first.wrapping_add(first << 32).wrapping_add(1 << 32)
}

/// To the two after the next.
pub(crate) const TWO_LATER: u64 = 0x2_0000_0002;

/// Every x86-64 processor has registers for two numbers.
#[cfg(target_arch = "x86_64")]
mod numbers {
    use std::arch::x86_64::{
        __m128d, _mm_cmpnle_pd, _mm_loadh_pd, _mm_movemask_pd, _mm_or_pd, _mm_set_sd, _mm_set1_pd, _mm_setzero_pd,
        _mm_storeu_pd,
    };

    /// Two numbers.
    #[derive(Clone, Copy)]
    pub struct Two(__m128d);

    impl Two {
        /// Those at a place and behind it.
        ///
        /// # Safety
        /// Both must be there.
        #[inline(always)]
        pub unsafe fn read(from: *const f64) -> Self {
            // SAFETY: the caller's promise. Volatile, or the compiler would read both at once.
            unsafe { Self(_mm_loadh_pd(_mm_set_sd(from.read_volatile()), from.add(1))) }
        }

        /// Puts them at a place and behind it.
        ///
        /// # Safety
        /// There must be room for both.
        #[inline(always)]
        pub unsafe fn write(self, to: *mut f64) {
            // SAFETY: the caller's promise.
            unsafe { _mm_storeu_pd(to, self.0) }
        }
    }

    /// Whether all numbers so far are between two others.
    pub struct Range {
        min: __m128d,
        max: __m128d,
        below: __m128d,
        above: __m128d,
    }

    impl Range {
        #[inline(always)]
        pub fn new(min: f64, max: f64) -> Self {
            // SAFETY: every x86-64 processor can do that.
            unsafe {
                Self { min: _mm_set1_pd(min), max: _mm_set1_pd(max), below: _mm_setzero_pd(), above: _mm_setzero_pd() }
            }
        }

        /// Looks at two more.
        #[inline(always)]
        pub fn add(&mut self, two: Two) {
            // SAFETY: every x86-64 processor can do that.
            unsafe {
                // As is NaN.
                self.below = _mm_or_pd(self.below, _mm_cmpnle_pd(self.min, two.0));
                self.above = _mm_or_pd(self.above, _mm_cmpnle_pd(two.0, self.max));
            }
        }

        /// Whether all were. NaN never is.
        #[inline(always)]
        pub fn has_all(&self) -> bool {
            // SAFETY: every x86-64 processor can do that.
            unsafe { _mm_movemask_pd(_mm_or_pd(self.below, self.above)) == 0 }
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod numbers {
    /// Two numbers.
    #[derive(Clone, Copy)]
    pub struct Two([f64; 2]);

    impl Two {
        /// Those at a place and behind it.
        ///
        /// # Safety
        /// Both must be there.
        #[inline(always)]
        pub unsafe fn read(from: *const f64) -> Self {
            // SAFETY: the caller's promise. Volatile, or the compiler would read both at once.
            unsafe { Self([from.read_volatile(), from.add(1).read_volatile()]) }
        }

        /// Puts them at a place and behind it.
        ///
        /// # Safety
        /// There must be room for both.
        #[inline(always)]
        pub unsafe fn write(self, to: *mut f64) {
            // SAFETY: the caller's promise.
            unsafe { to.cast::<[f64; 2]>().write(self.0) }
        }
    }

    /// Whether all numbers so far are between two others.
    pub struct Range {
        min: f64,
        max: f64,
        fit: bool,
    }

    impl Range {
        #[inline(always)]
        pub fn new(min: f64, max: f64) -> Self {
            Self { min, max, fit: true }
        }

        /// Looks at two more.
        #[inline(always)]
        pub fn add(&mut self, two: Two) {
            self.fit &= two.0.iter().all(|value| self.min <= *value && *value <= self.max);
        }

        /// Whether all were. NaN never is.
        #[inline(always)]
        pub fn has_all(&self) -> bool {
            self.fit
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_follow_each_other() {
        for first in [0, 7, u32::MAX - 7] {
            for count in 1..8 {
                let mut references: Vec<u32> = (first..).take(count).collect();
                assert!(follow_each_other(&references, first), "{references:?}");
                // The first is what it is.
                for i in 1..count {
                    let right = references[i];
                    for wrong in [0, 1, first, u32::MAX].into_iter().filter(|wrong| *wrong != right) {
                        references[i] = wrong;
                        assert!(!follow_each_other(&references, first), "{references:?}");
                    }
                    references[i] = right;
                }
            }
        }
    }

    /// Of each number by itself: between the two bounds, which belong to the range.
    #[test]
    fn a_range_has_what_is_between_its_bounds() {
        let numbers = [-0.0, 0.0, 1.0, -1.0, 2.0, -2.0, f64::MAX, f64::MIN, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        for (min, max) in [(f64::MIN, f64::MAX), (0.0, 1.0), (-1.0, 1.0), (-2.0, f64::MAX)] {
            for both in numbers.iter().flat_map(|first| numbers.map(|second| [*first, second])) {
                let mut range = Range::new(min, max);
                for two in [[max, min], both, [min, max]] {
                    // SAFETY: two numbers.
                    range.add(unsafe { Two::read(two.as_ptr()) });
                }
                let fits = both.iter().all(|number| (min..=max).contains(number));
                assert_eq!(range.has_all(), fits, "{both:?} in {min}..={max}");
            }
        }
    }

    #[test]
    fn numbers_arrive_in_their_order() {
        let (from, mut to) = ([1.0, -0.0, 3.0], [0.0; 3]);
        // SAFETY: there are three.
        unsafe { Two::read(from.as_ptr().add(1)).write(to.as_mut_ptr()) };
        assert_eq!(to.map(f64::to_bits), [-0.0, 3.0, 0.0].map(f64::to_bits));
    }
}
