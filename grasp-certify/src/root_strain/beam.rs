//! Two inequalities for a clamped beam, with their sharp constants.
//!
//! For q(0) = q'(0) = 0 on (0, l), with |·| the norm of L²:
//!
//! ```text
//! |(l−x) q'| ≤ c_1 l² |q''|,   c_1 = 1/(2 j),  j the first zero of the Bessel function J_{−1/4}:   0.249215…
//! |q|        ≤ c_2 l² |q''|,   c_2 = 1/β²,     β the first root of 1 + cos β cosh β:               0.284413…
//! ```
//!
//! The second is the first frequency of the clamped–free beam. The first maximises ∫ξ²u² over ∫u'² with u = q', ξ = l−x,
//! u(ξ=l) = 0: u'' + ξ²u/c² = 0 with u'(0) = 0, so u = √ξ J_{−1/4}(ξ²/2c), which has to vanish at l.

use crate::interval::Number;

/// A lower bound of j, the first zero of J_{−1/4}.
const BESSEL_ZERO: f64 = 2.006_299;
/// A lower bound of β².
const FREQUENCY_NUMBER: f64 = 3.516_015;

/// An upper bound of c_1.
pub(super) fn slope_constant<N: Number>() -> N {
    N::exact(0.5) / N::exact(BESSEL_ZERO)
}

/// An upper bound of c_2.
pub(super) fn deflection_constant<N: Number>() -> N {
    N::exact(1.0) / N::exact(FREQUENCY_NUMBER)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    /// Σ(−t)^k/(k! (3/4)_k), which is J_{−1/4}(2√t) up to a positive factor, is 1 at t = 0 and falls for 0 < t < 7/4,
    /// because its derivative is an alternating series with falling terms there. So a positive value at t means that there
    /// is no zero before. An alternating series with falling terms lies between its partial sums; the remainder after
    /// twenty terms is below 1e-30.
    #[test]
    fn the_bessel_function_has_no_zero_before_the_bound() {
        let n = Interval::exact;
        let series = |zero: f64| {
            let t = n(zero) * n(zero) / n(4.0);
            assert!(t.hi() < 1.75);
            let (mut term, mut sum) = (n(1.0), n(1.0));
            for k in 1..20 {
                let k = f64::from(k);
                term = -(term * t / (n(k) * n(k - 0.25)));
                sum = sum + term;
            }
            sum
        };
        assert!(series(BESSEL_ZERO).is_positive());
        // And the bound is close: at 1e-6 more there is a zero behind.
        assert!((-series(BESSEL_ZERO + 1e-6)).is_positive());
    }

    /// cos β cosh β = Σ(−4)^k β^{4k}/(4k)! falls on (0, π), as tanh β < tan β before π/2 and cos β < 0 after.
    #[test]
    fn the_beam_has_no_frequency_before_the_bound() {
        let n = Interval::exact;
        let function = |square: f64| {
            let fourth = n(square) * n(square);
            let (mut term, mut sum) = (n(1.0), n(2.0));
            for k in 1..12 {
                let k = f64::from(4 * k);
                term = -(term * n(4.0) * fourth / (n(k) * n(k - 1.0) * n(k - 2.0) * n(k - 3.0)));
                sum = sum + term;
            }
            sum
        };
        assert!(function(FREQUENCY_NUMBER).is_positive());
        assert!((-function(FREQUENCY_NUMBER + 1e-6)).is_positive());
    }
}
