//! A signal over one piece of a step, and the first time at which it becomes negative.
//!
//! Over a piece of duration τ a gap or a contact force is, to rounding, a polynomial in ξ = t/τ ∈ [0, 1] (in the shifted
//! Legendre basis or in powers) plus what a free face adds while it relaxes:
//!
//! ```text
//! p(ξ) = Σ c_m φ_m(ξ) + E e^{−Kξ},    |φ_m| ≤ 1.
//! ```
//!
//! Because |φ_m| ≤ 1, c_0 − Σ_{m≥1} |c_m| bounds the polynomial from below: nearly every piece is decided by that. Otherwise the
//! interval is halved, from the left, and a part is dropped as soon as bounds on p' or p'' show that p has no sign change
//! there, or show that it has exactly one, which Newton's method then finds. No root is missed and none is invented, whatever
//! the step size; a graze (p touches zero) is no root.

use super::decay::decay;

/// The most coefficients of a piece.
pub(super) const MOST_TERMS: usize = 48;

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
pub(super) struct Undecided;

/// The functions φ_m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Basis {
    /// P_m(2ξ − 1).
    Legendre,
    /// ξ^m.
    Powers,
}

/// p(ξ).
#[derive(Clone, Copy, Debug)]
pub(super) struct Series {
    basis: Basis,
    terms: [f64; MOST_TERMS],
    length: usize,
    /// E, not negative.
    pub amplitude: f64,
    /// K, not negative.
    pub rate: f64,
}

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
    /// A polynomial.
    ///
    /// # Panics
    /// If there are more than [`MOST_TERMS`] coefficients.
    pub fn new(basis: Basis, coefficients: &[f64]) -> Self {
        let mut terms = [0.0; MOST_TERMS];
        terms[..coefficients.len()].copy_from_slice(coefficients);
        Self { basis, terms, length: coefficients.len(), amplitude: 0.0, rate: 0.0 }
    }

    fn terms(&self) -> &[f64] {
        &self.terms[..self.length]
    }

    /// `value` + `factor` ∫₀^ξ p of a polynomial p.
    pub fn integrated(&self, value: f64, factor: f64) -> Self {
        let mut integral = Self { terms: [0.0; MOST_TERMS], length: (self.length + 1).min(MOST_TERMS), ..*self };
        for (m, c) in self.terms().iter().enumerate() {
            let c = factor * c;
            match self.basis {
                Basis::Powers => integral.add(m + 1, c / (m + 1) as f64),
                // ∫₀^ξ P_m(2s−1) ds = (P_{m+1} − P_{m−1}) / (4m + 2), and (P_1 + P_0)/2 for m = 0.
                Basis::Legendre => {
                    let share = c / (4 * m + 2) as f64;
                    integral.add(m + 1, share);
                    if m == 0 {
                        integral.add(0, share);
                    } else {
                        integral.add(m - 1, -share);
                    }
                }
            }
        }
        integral.add(0, value);
        integral
    }

    /// What would stand beyond the last term is below rounding.
    fn add(&mut self, m: usize, c: f64) {
        if let Some(term) = self.terms.get_mut(m) {
            *term += c;
        }
    }

    /// `own` p + `others` q of two polynomials in the same basis.
    pub fn combined(&self, own: f64, q: &Self, others: f64) -> Self {
        let terms = std::array::from_fn(|m| own * self.terms[m] + others * q.terms[m]);
        Self { terms, length: self.length.max(q.length), ..*self }
    }

    /// p and p'.
    pub fn value_and_slope(&self, xi: f64) -> (f64, f64) {
        let (mut value, mut slope) = match self.basis {
            Basis::Powers => self.terms().iter().rev().fold((0.0, 0.0), |(p, d), c| (p * xi + c, d * xi + p)),
            Basis::Legendre => {
                let t = 2.0 * xi - 1.0;
                let (mut before, mut now) = ((0.0, 0.0), (1.0, 0.0));
                let (mut p, mut d) = (0.0, 0.0);
                for (m, c) in self.terms().iter().enumerate() {
                    p += c * now.0;
                    d += c * now.1;
                    let m = m as f64;
                    let next =
                        (((2.0 * m + 1.0) * t * now.0 - m * before.0) / (m + 1.0), before.1 + (2.0 * m + 1.0) * now.0);
                    (before, now) = (now, next);
                }
                (p, 2.0 * d)
            }
        };
        if self.amplitude != 0.0 {
            let relaxing = self.amplitude * decay(self.rate * xi);
            value += relaxing;
            slope -= self.rate * relaxing;
        }
        (value, slope)
    }

    /// The smallest p can be, from the coefficients alone.
    fn least(&self) -> f64 {
        let [first, rest @ ..] = self.terms() else { return 0.0 };
        let relaxing = if self.amplitude == 0.0 { 0.0 } else { self.amplitude * decay(self.rate) };
        let variation: f64 = rest.iter().map(|c| c.abs()).sum();
        // In powers, what is positive only adds.
        let variation = match self.basis {
            Basis::Legendre => variation,
            Basis::Powers => rest.iter().map(|c| c.min(0.0).abs()).sum(),
        };
        first - variation + relaxing
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
        let polynomial = Self { amplitude: 0.0, ..*self };
        let (value, slope) = polynomial.value_and_slope(middle);
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
            least += last;
            slope = (slope.0 - self.rate * first, slope.1 - self.rate * last);
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

    /// ∫₀^end p² dξ by a Gauss rule on [0, 1]: exact if it has as many nodes as the polynomial has terms.
    pub fn square(&self, end: f64, rule: &[(f64, f64)]) -> f64 {
        if end >= 1.0 && self.basis == Basis::Legendre {
            // Parseval.
            return self.terms().iter().enumerate().map(|(m, c)| c * c / (2 * m + 1) as f64).sum();
        }
        rule.iter().map(|(node, weight)| weight * end * self.value_and_slope(node * end).0.powi(2)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::gauss;

    fn found(series: &Series) -> Option<f64> {
        series.first_negative(1e-15).unwrap()
    }

    /// (ξ−a)(ξ−b)… with known roots: the first one where the sign goes down, to rounding.
    #[test]
    fn the_first_crossing_is_found_among_many_roots() {
        let product = |roots: &[f64], sign: f64| {
            let mut c = vec![sign];
            for root in roots {
                let mut next = vec![0.0; c.len() + 1];
                for (m, c) in c.iter().enumerate() {
                    next[m + 1] += c;
                    next[m] -= root * c;
                }
                c = next;
            }
            Series::new(Basis::Powers, &c)
        };
        for (roots, sign, expected) in [
            (vec![0.3], -1.0, Some(0.3)),
            (vec![0.3, 0.7], 1.0, Some(0.3)),
            (vec![0.3, 0.3, 0.8], -1.0, Some(0.8)),
            (vec![0.25, 0.5, 0.75, 1e-3], 1.0, Some(1e-3)),
            (vec![0.5, 0.500_001], 1.0, Some(0.5)),
            (vec![1.5, 2.0], 1.0, None),
        ] {
            let found = found(&product(&roots, sign));
            match (found, expected) {
                (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-9, "{roots:?} {found}"),
                pair => assert_eq!(pair.0, pair.1, "{roots:?}"),
            }
        }
    }

    /// A parabola that touches zero, or stays above it by as little as numbers can say, is no crossing; one that dips below
    /// by a part in a billion is.
    #[test]
    fn grazes_are_no_crossings() {
        let parabola = |depth: f64| Series::new(Basis::Powers, &[0.25 - depth, -1.0, 1.0]);
        for depth in [0.0, -1e-16, -1e-12, -1e-6] {
            assert_eq!(found(&parabola(depth)), None, "{depth}");
        }
        for depth in [1e-9, 1e-6, 1e-3] {
            let expected = 0.5 - f64::sqrt(depth);
            assert!((found(&parabola(depth)).unwrap() - expected).abs() < 1e-6 * f64::sqrt(depth), "{depth}");
        }
        // What leaves zero like t³ is not negative, whatever rounding makes of its first coefficients.
        assert_eq!(found(&Series::new(Basis::Powers, &[0.0, -1e-20, 1e-19, 1.0])), None);
    }

    /// e^{−Kξ} − ½ crosses zero at ln 2/K, for slow faces and for those that are back at once.
    #[test]
    fn a_relaxing_face_is_part_of_the_signal() {
        for rate in [1.0, 30.0, 1e4, 1e9] {
            let series = Series { amplitude: 1.0, rate, ..Series::new(Basis::Powers, &[-0.5]) };
            let expected = std::f64::consts::LN_2 / rate;
            assert!((found(&series).unwrap() - expected).abs() < 1e-14 * expected.max(1e-2), "{rate}");
        }
    }

    #[test]
    fn both_bases_integrate_and_square_alike() {
        // p = 1 + 2ξ + 3ξ² = 3 + 2.5 P_1 + 0.5 P_2.
        let powers = Series::new(Basis::Powers, &[1.0, 2.0, 3.0]);
        let legendre = Series::new(Basis::Legendre, &[3.0, 2.5, 0.5]);
        let rule = gauss(6);
        for xi in [0.0, 0.3, 1.0] {
            for series in [powers, legendre] {
                assert!((series.value_and_slope(xi).0 - (1.0 + 2.0 * xi + 3.0 * xi * xi)).abs() < 1e-14);
                assert!((series.value_and_slope(xi).1 - (2.0 + 6.0 * xi)).abs() < 1e-13);
                let integral = series.integrated(0.5, 2.0).value_and_slope(xi).0;
                assert!((integral - (0.5 + 2.0 * (xi + xi * xi + xi.powi(3)))).abs() < 1e-14);
                // ∫(1+2s+3s²)² ds
                let square = xi + 2.0 * xi.powi(2) + 10.0 / 3.0 * xi.powi(3) + 3.0 * xi.powi(4) + 1.8 * xi.powi(5);
                assert!((series.square(xi, &rule) - square).abs() < 1e-13, "{xi}");
            }
        }
    }
}
