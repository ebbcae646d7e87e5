//! Estimate of the moving mass by least squares.
//!
//! The update law (39) answers to s and so to everything that makes s; it cannot tell a heavy object from a disturbance,
//! and stops as soon as s is small. What tells the mass is the prediction error of (11), m ÿ = F + ΔF with the known
//! force F = u − ΣQ: composite adaptation (Slotine and Li, 1989, doi:10.1016/0005-1098(89)90094-0). No acceleration is
//! measured, so both sides go through the same filters, which also take constants away:
//!
//! ```text
//! a = filtered ÿ,  f = filtered F;   Ṡ_ff = f² (1 − S_ff/S),   Ṡ_af = a f − f² S_af/S
//! 1/m̂ = (S_af + w/m₀)/(S_ff + w), clamped
//! ```
//!
//! It regresses acceleration on force, because force is the better known of the two. S forgets by excitation and not by
//! time: without motion nothing is learnt and nothing forgotten.

mod continuous;

use crate::blocks::adaptation::phi1;
use crate::blocks::exponential::{exp, exp_m1};
use serde::{Deserialize, Serialize};

/// Settings of the estimator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MassGains {
    /// Mass m₀ at the start \[kg\].
    pub initial: f64,
    /// Smallest estimate \[kg\].
    pub smallest: f64,
    /// Largest estimate \[kg\].
    pub largest: f64,
    /// Bandwidth of the filter that stands for the differentiation \[rad/s\].
    pub filter: f64,
    /// Corner below which both sides are taken away \[rad/s\]: constant disturbances do not count.
    pub high_pass: f64,
    /// Weight w of the initial mass \[N²·s\].
    pub prior: f64,
    /// Excitation S that is remembered \[N²·s\].
    pub memory: f64,
}

/// The estimator's state, or its time derivative.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct MassEstimator {
    /// Low-passed velocity \[m/s\] and force \[N\].
    velocity: f64,
    force: f64,
    /// What the high-pass takes away: acceleration \[m/s²\] and force \[N\].
    slow_acceleration: f64,
    slow_force: f64,
    /// `S_ff` \[N²·s\] and `S_af` \[N·m/s\].
    force_force: f64,
    acceleration_force: f64,
}

impl MassEstimator {
    /// Nothing learnt, filters in equilibrium at this velocity.
    pub fn settled(velocity: f64) -> Self {
        Self { velocity, ..Self::default() }
    }

    /// 1/m̂ before the clamp.
    fn mobility(&self, gains: &MassGains) -> f64 {
        (self.acceleration_force + gains.prior / gains.initial) / (self.force_force + gains.prior)
    }

    /// m̂ \[kg\].
    pub fn mass(&self, gains: &MassGains) -> f64 {
        // A mobility that is not positive speaks for a mass beyond all bounds.
        1.0 / self.mobility(gains).clamp(gains.largest.recip(), gains.smallest.recip())
    }

    /// Filtered (ÿ, F).
    fn regressors(&self, gains: &MassGains, velocity: f64) -> (f64, f64) {
        let acceleration = gains.filter * (velocity - self.velocity);
        (acceleration - self.slow_acceleration, self.force - self.slow_force)
    }

    /// d/dt m̂ \[kg/s\] for the object's `velocity`.
    pub fn mass_rate(&self, gains: &MassGains, velocity: f64) -> f64 {
        let mobility = self.mobility(gains);
        if !(gains.largest.recip()..=gains.smallest.recip()).contains(&mobility) {
            return 0.0;
        }
        let (a, f) = self.regressors(gains, velocity);
        let force_force = f * f * (1.0 - self.force_force / gains.memory);
        let acceleration_force = a * f - f * f * self.acceleration_force / gains.memory;
        -(acceleration_force - mobility * force_force) / (self.force_force + gains.prior) / mobility.powi(2)
    }

    /// Advances by `h` \[s\] with held velocity and force. The sums hold their regressors over the step.
    pub fn step(&mut self, h: f64, gains: &MassGains, velocity: f64, force: f64) {
        let (a, f) = self.regressors(gains, velocity);
        let z = f * f * h / gains.memory;
        let decay = exp(-z);
        let weight = h * phi1(z);
        self.force_force = decay * self.force_force + weight * f * f;
        self.acceleration_force = decay * self.acceleration_force + weight * a * f;
        let slow = -exp_m1(-gains.high_pass * h);
        self.slow_acceleration += slow * a;
        self.slow_force += slow * f;
        let follow = -exp_m1(-gains.filter * h);
        self.velocity += follow * (velocity - self.velocity);
        self.force += follow * (force - self.force);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: MassGains = MassGains {
        initial: 0.5,
        smallest: 0.15,
        largest: 20.0,
        filter: 60.0,
        high_pass: 5.0,
        prior: 3e-4,
        memory: 0.01,
    };

    /// A mass under a force that goes to and fro, and under a constant one that nobody knows. 2 %: the prior's weight
    /// 3e-4 beside an excitation of ½·0.09 N² for two seconds, remembered up to 0.01; the constant force passes the
    /// high-pass for 1/5 s only.
    #[test]
    fn the_mass_is_found_under_a_constant_disturbance() {
        for mass in [0.25, 0.5, 2.3, 10.2] {
            let mut estimator = MassEstimator::settled(0.0);
            let (h, mut velocity) = (1e-4, 0.0);
            for step in 0..30_000 {
                let force = 0.3 * (12.0 * f64::from(step) * h).sin();
                velocity += 0.5 * h * (force + 0.05) / mass;
                estimator.step(h, &GAINS, velocity, force);
                velocity += 0.5 * h * (force + 0.05) / mass;
            }
            let ratio = estimator.mass(&GAINS) / mass;
            // The prior pulls towards 0.5 kg with 3 % of the weight.
            assert!((ratio.recip() - 1.0).abs() < 0.03 * (mass / 0.5 - 1.0).abs() + 0.02, "{mass} kg: {ratio}");
        }
    }

    /// Without motion the estimate stays, however long.
    #[test]
    fn nothing_is_forgotten_at_rest() {
        let mut estimator =
            MassEstimator { force_force: 0.008, acceleration_force: 0.008 / 3.0, ..MassEstimator::default() };
        let before = estimator.mass(&GAINS);
        for _ in 0..1_000_000 {
            estimator.step(1e-3, &GAINS, 0.0, 0.0);
        }
        assert!((estimator.mass(&GAINS) - before).abs() < 1e-12);
    }
}
