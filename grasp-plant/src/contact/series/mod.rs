//! A signal over one piece of a step.
//!
//! Over a piece of duration τ a gap or a contact force is, to rounding, a polynomial in ξ = t/τ ∈ [0, 1] (in the shifted
//! Legendre basis or in powers) plus what decays: a free face that relaxes, or the mode's stiff part:
//!
//! ```text
//! p(ξ) = Σ c_m φ_m(ξ) + E e^{−Kξ},    |φ_m| ≤ 1.
//! ```

mod search;

use super::decay::decay;
pub(super) use search::Undecided;

/// The most coefficients of a piece.
pub(super) const MOST_TERMS: usize = 48;

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
    /// E.
    pub amplitude: f64,
    /// K, not negative.
    pub rate: f64,
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

    /// Becomes another polynomial.
    ///
    /// # Panics
    /// If there are more than [`MOST_TERMS`] coefficients.
    pub fn assign(&mut self, basis: Basis, coefficients: &[f64]) {
        let (terms, rest) = self.terms.split_at_mut(coefficients.len());
        terms.copy_from_slice(coefficients);
        rest.fill(0.0);
        (self.basis, self.length, self.amplitude, self.rate) = (basis, coefficients.len(), 0.0, 0.0);
    }

    fn terms(&self) -> &[f64] {
        &self.terms[..self.length]
    }

    /// `value` + `factor` ∫₀^ξ p.
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
        if self.amplitude != 0.0 && self.rate > 0.0 {
            let decaying = factor * self.amplitude / self.rate;
            integral.add(0, decaying);
            integral.amplitude = -decaying;
        }
        integral
    }

    /// What would stand beyond the last term is below rounding.
    fn add(&mut self, m: usize, c: f64) {
        if let Some(term) = self.terms.get_mut(m) {
            *term += c;
        }
    }

    /// `own` p + `others` q of two series in the same basis that decay alike.
    pub fn combined(&self, own: f64, q: &Self, others: f64) -> Self {
        let terms = std::array::from_fn(|m| own * self.terms[m] + others * q.terms[m]);
        let amplitude = own * self.amplitude + others * q.amplitude;
        Self { terms, length: self.length.max(q.length), amplitude, ..*self }
    }

    /// p and p'.
    pub fn value_and_slope(&self, xi: f64) -> (f64, f64) {
        let (mut value, mut slope) = self.polynomial(xi);
        if self.amplitude != 0.0 {
            let decaying = self.amplitude * decay(self.rate * xi);
            value += decaying;
            slope -= self.rate * decaying;
        }
        (value, slope)
    }

    /// p and p' without what decays.
    fn polynomial(&self, xi: f64) -> (f64, f64) {
        match self.basis {
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
        }
    }

    /// ∫₀^end p² dξ by a Gauss rule on [0, 1]: exact if it has as many nodes as the polynomial has terms. What decays is integrated
    /// over parts in which it falls by e⁻¹⁶ at most, until nothing is left of it.
    pub fn square(&self, end: f64, rule: &[(f64, f64)]) -> f64 {
        if end >= 1.0 && self.basis == Basis::Legendre {
            // Parseval.
            let square = self.terms().iter().enumerate().map(|(m, c)| c * c / (2 * m + 1) as f64).sum();
            let largest: f64 = self.terms().iter().map(|c| c.abs()).sum::<f64>() + self.amplitude.abs();
            if 2.0 * self.amplitude.abs() * largest <= f64::EPSILON / 16.0 * square * self.rate.max(1.0) {
                return square;
            }
        }
        let over = |from: f64, to: f64| -> f64 {
            let square = |(node, weight): &(f64, f64)| {
                let xi = from + node * (to - from);
                weight * (to - from) * self.value_and_slope(xi).0.powi(2)
            };
            rule.iter().map(square).sum()
        };
        let (mut from, mut sum) = (0.0, 0.0);
        if self.amplitude != 0.0 {
            while self.rate * from < 48.0 && self.rate * (end - from) > 16.0 {
                let to = from + 16.0 / self.rate;
                sum += over(from, to);
                from = to;
            }
        }
        sum + over(from, end)
    }
}

#[cfg(test)]
mod tests;
