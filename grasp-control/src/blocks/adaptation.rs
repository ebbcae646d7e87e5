//! Exact stepping of the estimate laws.
//!
//! Every update law of the paper, (37)–(39) and (55)–(57), is ẋ = a φ(t) − a σ x: linear in its estimate x, with
//! adaptation gain a ≥ 0, leakage σ ≥ 0 and a forcing φ that depends on the inputs alone. Its solution over a step h is
//!
//! ```text
//! x(h) = e^{−aσh} x(0) + a ∫₀ʰ e^{−aσ(h−t)} φ(t) dt.
//! ```
//!
//! [`LeakyLaw::held`] gives it in closed form for a constant φ, [`LeakyLaw::sampled`] for a φ known at two points.

use crate::blocks::exponential::{exp, exp_m1};
use serde::{Deserialize, Serialize};

/// φ₁(−z) = (1 − e^{−z})/z, the mean of e^{−z(1−t)} over 0 ≤ t ≤ 1; z ≥ 0.
pub(crate) fn phi1(z: f64) -> f64 {
    if z == 0.0 { 1.0 } else { -exp_m1(-z) / z }
}

/// φ₂(−z) = (1 − φ₁(−z))/z, the mean of t e^{−z(1−t)} over 0 ≤ t ≤ 1; z ≥ 0.
pub(crate) fn phi2(z: f64) -> f64 {
    // The closed form cancels near zero; the series Σ (−z)ⁿ/(n+2)! is exact to round-off with these terms below ½.
    const TERMS: i32 = 14;
    if z > 0.5 {
        return (1.0 - phi1(z)) / z;
    }
    (0..TERMS).rev().fold(0.0, |sum, n| (1.0 - z * sum) / f64::from(n + 2))
}

/// The law ẋ = a φ − a σ x of one estimate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LeakyLaw {
    /// Adaptation gain a ≥ 0.
    pub gain: f64,
    /// Leakage σ ≥ 0; the estimate forgets at the rate a σ \[1/s\].
    pub leakage: f64,
}

impl LeakyLaw {
    /// ẋ.
    #[must_use]
    pub fn rate(&self, x: f64, forcing: f64) -> f64 {
        self.gain * (forcing - self.leakage * x)
    }

    /// The step over `h` \[s\] with a constant forcing: exact, also for a = 0 or σ = 0.
    #[must_use]
    pub fn held(&self, h: f64) -> HeldStep {
        let z = self.gain * self.leakage * h;
        HeldStep { decay: exp(-z), weight: self.gain * h * phi1(z) }
    }

    /// The step over `h` \[s\] with a forcing sampled at [`NODES`].
    ///
    /// The forcing is interpolated linearly between the samples and its product with the exponential integrated
    /// exactly. So the two weights add up to the one of [`held`](Self::held); and because the nodes are those of
    /// Gauss and Legendre, the error over a step is O(h⁵).
    #[must_use]
    pub fn sampled(&self, h: f64) -> SampledStep {
        let z = self.gain * self.leakage * h;
        let (mean, moment) = (phi1(z), phi2(z));
        let scale = self.gain * h / (NODES[1] - NODES[0]);
        SampledStep {
            decay: exp(-z),
            weights: [scale * (NODES[1] * mean - moment), scale * (moment - NODES[0] * mean)],
        }
    }
}

/// Where in a step, as fractions of it, a forcing is sampled: the two Gauss–Legendre points ½ ∓ √3/6.
pub const NODES: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// x ← decay·x + weight·φ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldStep {
    /// e^{−aσh}.
    pub decay: f64,
    /// a ∫ e^{−aσ(h−t)} dt \[s·a\].
    pub weight: f64,
}

impl HeldStep {
    /// The estimate after the step.
    #[must_use]
    pub fn apply(&self, x: f64, forcing: f64) -> f64 {
        self.decay * x + self.weight * forcing
    }
}

/// x ← decay·x + Σ weightⱼ·φⱼ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledStep {
    /// e^{−aσh}.
    pub decay: f64,
    /// Weights of the forcing at [`NODES`].
    pub weights: [f64; 2],
}

impl SampledStep {
    /// What one node contributes: the step is the part of the first, followed by that of the second.
    #[must_use]
    pub fn part(&self, node: usize) -> HeldStep {
        HeldStep { decay: if node == 0 { self.decay } else { 1.0 }, weight: self.weights[node] }
    }

    /// The estimate after the step.
    #[must_use]
    pub fn apply(&self, x: f64, forcing: [f64; 2]) -> f64 {
        self.part(1).apply(self.part(0).apply(x, forcing[0]), forcing[1])
    }
}

/// Steps of the three laws of one loop, computed once per step size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Steps {
    pub h: f64,
    pub held: [HeldStep; 3],
    pub sampled: [SampledStep; 3],
}

impl Steps {
    /// The steps over `h`.
    pub fn new(h: f64, laws: [LeakyLaw; 3]) -> Self {
        Self { h, held: laws.map(|law| law.held(h)), sampled: laws.map(|law| law.sampled(h)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Classic RK4 of ẋ = aφ(t) − aσx with many small steps.
    fn integrate(law: LeakyLaw, x: f64, h: f64, forcing: impl Fn(f64) -> f64) -> f64 {
        let n = 2000;
        let dt = h / f64::from(n);
        let f = |t: f64, x: f64| law.gain * forcing(t) - law.gain * law.leakage * x;
        (0..n).fold(x, |x, i| {
            let t = f64::from(i) * dt;
            let k1 = f(t, x);
            let k2 = f(t + 0.5 * dt, x + 0.5 * dt * k1);
            let k3 = f(t + 0.5 * dt, x + 0.5 * dt * k2);
            let k4 = f(t + dt, x + dt * k3);
            x + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        })
    }

    #[test]
    fn phi_functions_agree_on_both_sides_of_the_switch() {
        for z in [0.5, 0.499, 0.3] {
            let closed = (1.0 - phi1(z)) / z;
            assert!((phi2(z) - closed).abs() < 1e-15, "{z}");
        }
        assert_eq!(phi1(0.0), 1.0);
        assert_eq!(phi2(0.0), 0.5);
        assert!((phi1(1e-12) - (1.0 - 0.5e-12)).abs() < 1e-16);
    }

    #[test]
    fn no_leakage_and_no_gain_are_limits_not_special_cases() {
        let integrator = LeakyLaw { gain: 3.0, leakage: 0.0 };
        assert_eq!(integrator.held(0.1).apply(1.0, 2.0), 1.0 + 3.0 * 0.1 * 2.0);
        let off = LeakyLaw { gain: 0.0, leakage: 5.0 };
        assert_eq!(off.held(0.1).apply(0.7, 2.0), 0.7);
    }

    proptest! {
        /// Bound: RK4's own error at aσh ≤ 10 in 2000 steps is far below 1e-11.
        #[test]
        fn held_step_solves_the_law(
            gain in 0.0..50.0, leakage in 0.0..2.0, h in 1e-4..0.1, x in -3.0..3.0, forcing in -3.0..3.0,
        ) {
            let law = LeakyLaw { gain, leakage };
            let exact = integrate(law, x, h, |_| forcing);
            prop_assert!((law.held(h).apply(x, forcing) - exact).abs() < 1e-11);
        }

        /// A constant forcing makes the sampled step the held one; round-off of the weights.
        #[test]
        fn sampled_step_reduces_to_the_held_one(
            gain in 0.0..50.0, leakage in 0.0..200.0, h in 1e-5..0.1, x in -3.0..3.0, forcing in -3.0..3.0,
        ) {
            let law = LeakyLaw { gain, leakage };
            let (held, sampled) = (law.held(h).apply(x, forcing), law.sampled(h).apply(x, [forcing; 2]));
            prop_assert!((held - sampled).abs() <= 1e-14 * (1.0 + held.abs() + gain * h));
        }

        /// A forcing that ramps is integrated exactly, leakage or not.
        #[test]
        fn sampled_step_is_exact_for_ramps(
            gain in 0.0..50.0, leakage in 0.0..2.0, h in 1e-4..0.1, f0 in -3.0..3.0, slope in -30.0..30.0,
        ) {
            let law = LeakyLaw { gain, leakage };
            let exact = integrate(law, 0.3, h, |t| f0 + slope * t);
            let step = law.sampled(h).apply(0.3, NODES.map(|node| f0 + slope * node * h));
            prop_assert!((step - exact).abs() < 1e-11);
        }
    }

    /// Halving the step divides the error of one step by 2⁵ when the forcing is smooth.
    #[test]
    fn sampled_step_is_of_fourth_order() {
        let law = LeakyLaw { gain: 2.0, leakage: 1.5 };
        let forcing = |t: f64| (5.0 * t).sin();
        let error = |h: f64| {
            let step = law.sampled(h).apply(0.2, NODES.map(|node| forcing(node * h)));
            (step - integrate(law, 0.2, h, forcing)).abs()
        };
        let order = (error(0.1) / error(0.05)).log2();
        assert!((order - 5.0).abs() < 0.2, "order {order}");
    }
}
