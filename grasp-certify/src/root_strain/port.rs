//! One end of the arms under the root-strain law: a hub, or the object.
//!
//! With position p (e_i at a hub), load S (EI q''(0) at a hub, ΣEI q'''(l) at the object) and inertia m:
//!
//! ```text
//! s = G p + ṗ + c S,    v = S − m̂ (k s + f (G ṗ + c Ṡ)) − ṗ/c − Δ̂,    m p̈ = v − S + Δ.
//! ```
//!
//! With m̂ ≠ m it is the same law with k m̂/m and f m̂/m. The estimate Δ̂ is taken as part of the disturbance Δ.

use serde::Serialize;

/// Gains and inertia of one end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Port {
    /// True inertia m \[kg, or kg·m²\].
    pub inertia: f64,
    /// Inertia m̂ that the law reckons with.
    pub assumed_inertia: f64,
    /// G \[1/s\].
    pub slope: f64,
    /// k \[1/s\].
    pub reach: f64,
    /// c \[(m/s)/N, or (rad/s)/(N·m)\].
    pub strain: f64,
    /// f, the share of the inertia that is fed forward.
    pub feedforward: f64,
}

impl Port {
    /// Coefficients of v = −(… p + … ṗ + … S + … Ṡ).
    #[must_use]
    pub fn feedback(&self) -> [f64; 4] {
        let (m, c) = (self.assumed_inertia, self.strain);
        [
            m * self.reach * self.slope,
            m * self.reach + m * self.feedforward * self.slope + 1.0 / c,
            m * self.reach * c - 1.0,
            m * self.feedforward * c,
        ]
    }

    /// k m̂/m.
    pub(super) fn effective_reach(&self) -> f64 {
        self.reach * (self.assumed_inertia / self.inertia)
    }

    /// f m̂/m.
    pub(super) fn effective_feedforward(&self) -> f64 {
        self.feedforward * (self.assumed_inertia / self.inertia)
    }

    /// The law that acts like this one with a disturbance −`coefficient` Ṡ \[s\] added, for that is what the built-in
    /// uncertainties of Section IV are. None if no such law has positive gains.
    #[must_use]
    pub fn with_load_rate(&self, coefficient: f64) -> Option<Self> {
        let [a1, a2, a3, a4] = self.feedback();
        let (a3, a4, m) = (a3 + 1.0, a4 + coefficient, self.inertia);
        let rest = a2 - a1 * a4 / a3;
        let strain = (a3 + 1.0) / rest;
        (a3 > 0.0 && rest > 0.0).then(|| Self {
            inertia: m,
            assumed_inertia: m,
            slope: a1 * strain / a3,
            reach: a3 / (m * strain),
            strain,
            feedforward: a4 / (m * strain),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_rate_only_changes_the_load_rate() {
        let port = Port { inertia: 0.5, assumed_inertia: 0.6, slope: 8.0, reach: 30.0, strain: 2.0, feedforward: 0.4 };
        let same = port.with_load_rate(0.0).unwrap();
        let more = port.with_load_rate(0.1).unwrap();
        for i in 0..4 {
            let extra = if i == 3 { 0.1 } else { 0.0 };
            assert!((same.feedback()[i] - port.feedback()[i]).abs() < 1e-12 * 100.0);
            assert!((more.feedback()[i] - port.feedback()[i] - extra).abs() < 1e-12 * 100.0);
        }
    }
}
