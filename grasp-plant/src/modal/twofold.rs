//! Numbers of twice the precision, as unevaluated sums of two, for the set-up of the modal plant.
//!
//! Only plain additions and multiplications: without fused ones the product's error comes from Dekker's splitting, and the
//! bits are the same on every processor.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo, with |lo| at most half a unit in the last place of hi.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Twofold {
    pub hi: f64,
    pub lo: f64,
}

/// a + b and its rounding error (Knuth).
#[inline(always)]
pub(super) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let other = sum - a;
    (sum, (a - (sum - other)) + (b - other))
}

/// The same if |a| ≥ |b| (Dekker).
#[inline(always)]
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Upper and lower half of a's digits (Veltkamp).
#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    const FACTOR: f64 = 134_217_729.0; // 2²⁷ + 1
    let scaled = FACTOR * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

/// a b and its rounding error (Dekker).
#[inline(always)]
pub(super) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_1, a_2), (b_1, b_2)) = (split(a), split(b));
    (product, ((a_1 * b_1 - product) + a_1 * b_2 + a_2 * b_1) + a_2 * b_2)
}

impl Twofold {
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// hi + lo for |hi| ≥ |lo|.
    #[inline(always)]
    fn quick(hi: f64, lo: f64) -> Self {
        let (hi, lo) = quick_two_sum(hi, lo);
        Self { hi, lo }
    }

    /// a b, exactly.
    pub fn product(a: f64, b: f64) -> Self {
        let (hi, lo) = two_product(a, b);
        Self { hi, lo }
    }

    pub fn sqrt(self) -> Self {
        let root = self.hi.sqrt();
        if root == 0.0 {
            return Self::default();
        }
        // Heron's step from the root of the upper half.
        let rest = self - Self::product(root, root);
        Self::quick(root, rest.hi / (2.0 * root))
    }

    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }
}

impl From<f64> for Twofold {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Neg for Twofold {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Twofold {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (hi, error) = two_sum(self.hi, other.hi);
        let (lo, rest) = two_sum(self.lo, other.lo);
        let (hi, error) = quick_two_sum(hi, error + lo);
        Self::quick(hi, error + rest)
    }
}

impl Sub for Twofold {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (hi, error) = two_product(self.hi, other.hi);
        Self::quick(hi, error + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Div for Twofold {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let rest = self - other * Self::from(first);
        let second = rest.hi / other.hi;
        let rest = rest - other * Self::from(second);
        Self::quick(first, second) + Self::from(rest.hi / other.hi)
    }
}

/// A vector of such numbers.
#[derive(Clone, Debug)]
pub(super) struct Long {
    pub hi: Vec<f64>,
    pub lo: Vec<f64>,
}

impl Long {
    pub fn zeros(length: usize) -> Self {
        Self { hi: vec![0.0; length], lo: vec![0.0; length] }
    }

    pub fn of(values: &[f64]) -> Self {
        Self { hi: values.to_vec(), lo: vec![0.0; values.len()] }
    }

    pub fn len(&self) -> usize {
        self.hi.len()
    }

    pub fn get(&self, i: usize) -> Twofold {
        Twofold { hi: self.hi[i], lo: self.lo[i] }
    }

    /// Entries of a range.
    pub fn part(&self, range: std::ops::Range<usize>) -> Self {
        Self { hi: self.hi[range.clone()].to_vec(), lo: self.lo[range].to_vec() }
    }

    /// Adds `factor` · `column`.
    pub fn add_scaled(&mut self, factor: Twofold, column: &[f64]) {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.add_scaled_wide(factor, column) };
        }
        self.add_scaled_here(factor, column);
    }

    /// The same bits in registers of four lanes.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn add_scaled_wide(&mut self, factor: Twofold, column: &[f64]) {
        self.add_scaled_here(factor, column);
    }

    #[inline(always)]
    fn add_scaled_here(&mut self, factor: Twofold, column: &[f64]) {
        for ((hi, lo), entry) in self.hi.iter_mut().zip(&mut self.lo).zip(column) {
            let (product, error) = two_product(factor.hi, *entry);
            let (sum, rest) = two_sum(*hi, product);
            (*hi, *lo) = quick_two_sum(sum, *lo + (rest + (error + factor.lo * entry)));
        }
    }

    /// Adds `factor` times another vector.
    pub fn add_multiple(&mut self, factor: Twofold, other: &Self) {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.add_multiple_wide(factor, other) };
        }
        self.add_multiple_here(factor, other);
    }

    /// The same bits in registers of four lanes.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn add_multiple_wide(&mut self, factor: Twofold, other: &Self) {
        self.add_multiple_here(factor, other);
    }

    #[inline(always)]
    fn add_multiple_here(&mut self, factor: Twofold, other: &Self) {
        let entries = other.hi.iter().zip(&other.lo);
        for ((hi, lo), (other_hi, other_lo)) in self.hi.iter_mut().zip(&mut self.lo).zip(entries) {
            let (product, error) = two_product(factor.hi, *other_hi);
            let (sum, rest) = two_sum(*hi, product);
            let small = error + (factor.hi * other_lo + factor.lo * other_hi);
            (*hi, *lo) = quick_two_sum(sum, *lo + (rest + small));
        }
    }

    /// Multiplies by a number.
    pub fn scale(&mut self, factor: Twofold) {
        let mut scaled = Self::zeros(self.len());
        scaled.add_multiple(factor, self);
        *self = scaled;
    }

    pub fn dot(&self, other: &Self) -> Twofold {
        (0..self.len()).fold(Twofold::default(), |sum, i| sum + self.get(i) * other.get(i))
    }

    /// The inner product with plain numbers.
    pub fn dot_plain(&self, other: &[f64]) -> Twofold {
        other.iter().enumerate().fold(Twofold::default(), |sum, (i, entry)| sum + self.get(i) * Twofold::from(*entry))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1/3 by division, √2 by root, and their products: thirty digits and more.
    #[test]
    fn arithmetic_has_twice_the_digits() {
        let third = Twofold::ONE / Twofold::from(3.0);
        let error = third + third + third - Twofold::ONE;
        assert!(error.hi.abs() < 1e-31, "{error:?}");
        let root = Twofold::from(2.0).sqrt();
        let error = root * root - Twofold::from(2.0);
        assert!(error.hi.abs() < 1e-30, "{error:?}");
        assert_eq!(two_product(1.0 + f64::EPSILON, 1.0 + f64::EPSILON).1.to_bits(), f64::EPSILON.powi(2).to_bits());
    }

    #[test]
    fn sums_keep_what_cancels() {
        let mut sum = Long::zeros(5);
        let big = [1e16, -3e15, 7.0, 1.0, -1e10];
        sum.add_scaled(Twofold::from(3.0), &big);
        sum.add_multiple(Twofold::ONE / Twofold::from(7.0), &Long::of(&[7.0; 5]));
        sum.add_scaled(Twofold::from(-3.0), &big);
        for i in 0..5 {
            assert!((sum.get(i) - Twofold::ONE).hi.abs() < 1e-14, "{:?}", sum.get(i));
        }
    }
}
