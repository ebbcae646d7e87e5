//! The first time at which a signal becomes negative.
//!
//! Because |φ_m| ≤ 1, c_0 − Σ_{m≥1} |c_m| bounds the polynomial from below: nearly every piece is decided by that. Otherwise the
//! interval is halved, from the left, and a part is dropped as soon as bounds on p' or p'' show that p has no sign change
//! there, or show that it has exactly one, which Newton's method then finds. No root is missed and none is invented, whatever
//! the step size; a graze (p touches zero) is no root.

use super::super::decay::decay;
use super::{Basis, Series};

/// Parts narrower than this (of the piece) are not halved again: below the rounding of ξ itself.
const NARROWEST: f64 = 1.0 / (1u64 << 52) as f64;

/// Looks after which a search gives up. Hardly any root takes a hundred; a signal that stays near zero may take more, and is then
/// looked at in shorter pieces. In powers, where bounds are sharp, the number is out of reach.
const fn most_looks(basis: Basis) -> u32 {
    match basis {
        Basis::Legendre => 300,
        Basis::Powers => 20_000,
    }
}

/// A search has looked too often.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undecided;

/// What is known of p on a part [a, b].
struct Bounds {
    /// p is not less.
    least: f64,
    /// p' is not less, and not more.
    slope: (f64, f64),
}

/// The interval, times all numbers from a to b, a ≥ 0.
fn times((low, high): (f64, f64), a: f64, b: f64) -> (f64, f64) {
    (if low >= 0.0 { low * a } else { low * b }, if high >= 0.0 { high * b } else { high * a })
}

impl Series {
    /// The smallest p can be, from the coefficients alone.
    fn least(&self) -> f64 {
        let [first, rest @ ..] = self.terms() else { return 0.0 };
        let decaying = if self.amplitude > 0.0 { self.amplitude * decay(self.rate) } else { self.amplitude };
        let variation: f64 = rest.iter().map(|c| c.abs()).sum();
        // In powers, what is positive only adds.
        let variation = match self.basis {
            Basis::Legendre => variation,
            Basis::Powers => rest.iter().map(|c| c.min(0.0).abs()).sum(),
        };
        first - variation + decaying
    }

    /// A bound of |p''| by the coefficients: |P_m''| ≤ (m−1)m(m+1)(m+2)/8 on [−1, 1].
    fn curvature(&self) -> f64 {
        let bound = |(m, c): (usize, &f64)| {
            let m = m as f64;
            0.5 * (m - 1.0) * m * (m + 1.0) * (m + 2.0) * c.abs()
        };
        self.terms().iter().enumerate().map(bound).sum::<f64>().abs()
    }

    /// Bounds on [a, b]; `curvature` is that of the polynomial.
    fn bounds(&self, a: f64, b: f64, curvature: f64) -> Bounds {
        let (middle, radius) = (f64::midpoint(a, b), 0.5 * (b - a));
        let (value, slope) = self.polynomial(middle);
        let (mut least, mut slope) = match self.basis {
            // About the middle.
            Basis::Legendre => (
                value - slope.abs() * radius - 0.5 * curvature * radius * radius,
                (slope - curvature * radius, slope + curvature * radius),
            ),
            // Horner's rule on intervals, and the mean value: sharp however many derivatives vanish at a root.
            Basis::Powers => {
                let (mut p, mut d) = ((0.0, 0.0), (0.0, 0.0));
                for c in self.terms().iter().rev() {
                    let next = times(d, a, b);
                    d = (next.0 + p.0, next.1 + p.1);
                    let next = times(p, a, b);
                    p = (next.0 + c, next.1 + c);
                }
                (p.0.max(value - d.0.abs().max(d.1.abs()) * radius), d)
            }
        };
        if self.amplitude != 0.0 {
            let (first, last) = (self.amplitude * decay(self.rate * a), self.amplitude * decay(self.rate * b));
            least += first.min(last);
            slope = (slope.0 - self.rate * first.max(last), slope.1 - self.rate * first.min(last));
        }
        Bounds { least, slope }
    }

    /// The smallest ξ in [0, 1] from which on p is negative, by more than `noise`, before it is anything else: where it
    /// crosses zero, or 0 if it starts below.
    ///
    /// # Errors
    /// When the search finds no end.
    pub fn first_negative(&self, noise: f64) -> Result<Option<f64>, Undecided> {
        if self.least() >= -noise {
            return Ok(None);
        }
        let curvature = self.curvature();
        // Parts still to be looked at, the leftmost on top: at most one for each halving.
        let mut stack = [(0.0, 0.0); 64];
        stack[0] = (0.0, 1.0);
        let mut height = 1;
        for _ in 0..most_looks(self.basis) {
            if height == 0 {
                return Ok(None);
            }
            height -= 1;
            let (a, b) = stack[height];
            let Bounds { least, slope } = self.bounds(a, b, curvature);
            if least >= -noise {
                continue;
            }
            let start = self.value_and_slope(a).0;
            if start < -noise {
                return Ok(Some(self.before(a)));
            }
            if slope.0 >= 0.0 {
                continue;
            }
            if slope.1 <= 0.0 {
                if self.value_and_slope(b).0 >= -noise {
                    continue;
                }
                return Ok(Some(if start <= 0.0 { self.before(a) } else { self.root(a, b) }));
            }
            if b - a > NARROWEST {
                let middle = f64::midpoint(a, b);
                stack[height] = (middle, b);
                stack[height + 1] = (a, middle);
                height += 2;
            }
        }
        Err(Undecided)
    }

    /// Where p crossed zero before b, where it is below by no more than rounding: without this, each of many small bounces would
    /// fall that much too deep, and gain what it costs to come back.
    fn before(&self, b: f64) -> f64 {
        let mut b = b;
        while b > NARROWEST {
            let a = 0.5 * b;
            if self.value_and_slope(a).0 > 0.0 {
                return self.root(a, b);
            }
            b = a;
        }
        0.0
    }

    /// The root between a, where p > 0, and b, where p ≤ 0: Newton, kept inside by halving.
    fn root(&self, a: f64, b: f64) -> f64 {
        let (mut low, mut high, mut xi) = (a, b, f64::midpoint(a, b));
        for _ in 0..100 {
            let (value, slope) = self.value_and_slope(xi);
            if value > 0.0 {
                low = xi;
            } else {
                high = xi;
            }
            let newton = xi - value / slope;
            let next = if newton > low && newton < high { newton } else { f64::midpoint(low, high) };
            if next == xi || high - low <= f64::EPSILON * high {
                break;
            }
            xi = next;
        }
        xi
    }
}
