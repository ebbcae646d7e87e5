//! Intervals of real numbers with outward rounding: a result computed with them contains the exact result.
//!
//! IEEE arithmetic rounds to the nearest number, so the exact result of one operation lies between the neighbours of the
//! rounded one. Every operation here moves its lower end to the next smaller number and its upper end to the next larger
//! one.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A closed interval that contains the exact value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    lo: f64,
    hi: f64,
}

impl Interval {
    /// All real numbers: the result of a division by an interval that contains zero.
    const ALL: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

    /// The interval of one number.
    #[must_use]
    pub const fn exact(value: f64) -> Self {
        Self { lo: value, hi: value }
    }

    /// The lower end.
    #[must_use]
    pub const fn lo(self) -> f64 {
        self.lo
    }

    /// The upper end.
    #[must_use]
    pub const fn hi(self) -> f64 {
        self.hi
    }

    /// The smallest interval of representable numbers around ends that were rounded to nearest. NaN (∞ − ∞, 0·∞) gives the
    /// interval of all numbers.
    fn around(lo: f64, hi: f64) -> Self {
        if lo.is_nan() || hi.is_nan() { Self::ALL } else { Self { lo: lo.next_down(), hi: hi.next_up() } }
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::around(self.lo + other.lo, self.hi + other.hi)
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::around(self.lo - other.hi, self.hi - other.lo)
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let products = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        if products.iter().any(|product| product.is_nan()) {
            return Self::ALL;
        }
        let lo = products.into_iter().fold(f64::INFINITY, f64::min);
        let hi = products.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Self::around(lo, hi)
    }
}

impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if other.lo <= 0.0 && other.hi >= 0.0 {
            return Self::ALL;
        }
        let quotients = [self.lo / other.lo, self.lo / other.hi, self.hi / other.lo, self.hi / other.hi];
        if quotients.iter().any(|quotient| quotient.is_nan()) {
            return Self::ALL;
        }
        let lo = quotients.into_iter().fold(f64::INFINITY, f64::min);
        let hi = quotients.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Self::around(lo, hi)
    }
}

/// The number type of the certificate's formulas: floating point for the search, intervals for the proof.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A number taken as exact.
    fn exact(value: f64) -> Self;
    /// The square root of something that is not negative.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Whether it is certainly above zero.
    fn is_positive(self) -> bool;
    /// Whether a multiple of it need not be added to anything. Of intervals each is: a product with zero is rounded outwards, too.
    fn vanishes(self) -> bool;
}

impl Number for f64 {
    fn exact(value: f64) -> Self {
        value
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    fn is_positive(self) -> bool {
        self > 0.0
    }
    fn vanishes(self) -> bool {
        self == 0.0
    }
}

impl Number for Interval {
    fn exact(value: f64) -> Self {
        Self::exact(value)
    }
    fn sqrt(self) -> Self {
        let root = Self::around(self.lo.max(0.0).sqrt(), self.hi.sqrt());
        Self { lo: root.lo.max(0.0), hi: root.hi }
    }
    fn is_positive(self) -> bool {
        self.lo > 0.0
    }
    fn vanishes(self) -> bool {
        false
    }
}

/// Whether a symmetric matrix is certainly positive definite: all pivots of its LDLᵀ factorisation are certainly positive.
#[must_use]
#[allow(clippy::needless_range_loop)] // Rows i and j of one matrix, with the indices of the formula.
pub fn is_positive_definite<N: Number, const SIZE: usize>(matrix: &[[N; SIZE]; SIZE]) -> bool {
    let mut a = *matrix;
    for k in 0..SIZE {
        let pivot = a[k][k];
        if !pivot.is_positive() {
            return false;
        }
        for i in k + 1..SIZE {
            let factor = a[i][k] / pivot;
            for j in k + 1..=i {
                a[i][j] = a[i][j] - factor * a[j][k];
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.1 + 0.2, 1/3, √2 are not floating-point numbers; their squares and products show on which side an end lies.
    #[test]
    fn results_are_inside() {
        let third = Interval::exact(1.0) / Interval::exact(3.0);
        assert!(third.lo() < third.hi());
        let one = third * Interval::exact(3.0);
        assert!(one.lo() < 1.0 && 1.0 < one.hi());
        let root = Number::sqrt(Interval::exact(2.0));
        let two = root * root;
        assert!(two.lo() < 2.0 && 2.0 < two.hi());
        let mixed = Interval { lo: -1.0, hi: 2.0 };
        let product = mixed * Interval { lo: -3.0, hi: 1.0 };
        assert!(product.lo() <= -6.0 && product.hi() >= 3.0);
        assert_eq!(Interval::exact(1.0) / mixed, Interval::ALL);
        assert!(!(Interval::ALL - Interval::ALL).is_positive());
    }

    /// The 3 × 3 Hilbert matrix minus a shift is definite up to its smallest eigenvalue, 0.002687340355773529.
    #[test]
    fn definiteness_changes_at_the_smallest_eigenvalue() {
        let hilbert = |shift: f64| -> [[Interval; 3]; 3] {
            std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let entry = Interval::exact(1.0) / Interval::exact((i + j + 1) as f64);
                    if i == j { entry - Interval::exact(shift) } else { entry }
                })
            })
        };
        assert!(is_positive_definite(&hilbert(0.002_687_340_355)));
        assert!(!is_positive_definite(&hilbert(0.002_687_340_356)));
    }
}
