//! The effect of the paper's adaptation on a certificate.
//!
//! An estimate x̂ of a constant x with x̂˙ = a(r y − b x̂), where y is the regressor of x and r = B(ζ + w p)/m (which is s
//! with full feed-forward), adds x̃²/2a to H and −½b x̃² + ½b x² to its rate. So φ falls to min(φ, a b), and W ≤ Σ½b
//! x²/(φθ) in the end. Laws (37)–(39) and (55)–(57) are of this kind; for a network x are its ideal weights.

use super::{Bound, Certificate};
use crate::Grasp;
use serde::Serialize;

/// One estimate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimator {
    /// The estimated quantity.
    pub name: String,
    /// Learning rate a.
    pub gain: f64,
    /// Leakage b.
    pub leakage: f64,
    /// |x|, or an upper bound.
    pub size: f64,
}

/// The part of a certificate that remains if estimates have leakage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Leakage {
    /// The estimates, those with a = 0 left out.
    pub estimators: Vec<Estimator>,
    /// min(φ, a b) \[1/s\].
    pub phi: f64,
    /// In the end, without any other disturbance.
    pub ultimate: Bound,
}

impl Certificate {
    /// The certificate with these estimates in the loop.
    #[must_use]
    pub fn with_leakage(&self, grasp: &Grasp, estimators: Vec<Estimator>) -> Leakage {
        let estimators: Vec<_> = estimators.into_iter().filter(|e| e.gain > 0.0).collect();
        let phi = estimators.iter().fold(self.phi, |phi, e| phi.min(e.gain * e.leakage));
        let cost: f64 = estimators.iter().map(|e| 0.5 * e.leakage * e.size * e.size).sum();
        // Without leakage nothing decays, and nothing stays either.
        let energy = if cost > 0.0 { cost / (phi * self.theta) } else { 0.0 };
        Leakage { estimators, phi, ultimate: self.implied(grasp, energy) }
    }
}
