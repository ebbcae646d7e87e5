//! Complex numbers, as far as characteristic functions need them.

use std::ops::{Add, Mul, Neg, Sub};

/// re + i im.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    /// re + i im.
    #[must_use]
    pub const fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    /// |z|.
    #[must_use]
    pub fn abs(self) -> f64 {
        self.re.hypot(self.im)
    }

    pub(super) fn arg(self) -> f64 {
        self.im.atan2(self.re)
    }

    pub(super) fn sqrt(self) -> Self {
        let (size, angle) = (self.abs().sqrt(), 0.5 * self.arg());
        Self::new(size * angle.cos(), size * angle.sin())
    }

    pub(super) fn div(self, other: Self) -> Self {
        let square = other.re * other.re + other.im * other.im;
        Self::new(
            (self.re * other.re + self.im * other.im) / square,
            (self.im * other.re - self.re * other.im) / square,
        )
    }

    /// sin, cos, sinh, cosh.
    pub(super) fn waves(self) -> [Self; 4] {
        let (s, c) = self.re.sin_cos();
        let (sh, ch) = (self.im.sinh(), self.im.cosh());
        let (s2, c2) = self.im.sin_cos();
        let (sh2, ch2) = (self.re.sinh(), self.re.cosh());
        [
            Self::new(s * ch, c * sh),
            Self::new(c * ch, -s * sh),
            Self::new(sh2 * c2, ch2 * s2),
            Self::new(ch2 * c2, sh2 * s2),
        ]
    }
}

impl From<f64> for Complex {
    fn from(re: f64) -> Self {
        Self::new(re, 0.0)
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.im - other.im)
    }
}

impl Neg for Complex {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.re, -self.im)
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)
    }
}

impl Mul<f64> for Complex {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::new(self.re * factor, self.im * factor)
    }
}
