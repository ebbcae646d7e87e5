//! One end of the arms under the root-strain law: a hub, or the object.
//!
//! With position p (e_i at a hub), load S (EI q''(0) at a hub, ΣEI q'''(l) at the object) and inertia m:
//!
//! ```text
//! s = G p + v̂ + c S,    v = S − m̂ (k s + f (G v̂ + c Ṡ)) − v̂/c − Δ̂,    m p̈ = v − S − χ_u Ṡ + Δ.
//! ```
//!
//! χ_u is the effect of the built-in uncertainties of Section IV on the end. Rate v̂ and disturbance Δ̂ come from an
//! observer with both poles at −ω; without one (ω = 0), v̂ = ṗ and Δ̂ = 0.

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
    /// ω of the observer \[rad/s\]; 0 = none.
    pub observer: f64,
    /// χ_u \[s\].
    pub load_rate: f64,
}

impl Port {
    /// Coefficients of v = −(… p + … ṗ + … S + … Ṡ), without observer.
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

    /// The same end without observer.
    #[must_use]
    pub fn without_observer(self) -> Self {
        Self { observer: 0.0, ..self }
    }

    /// The load's share χ in ζ = ṗ + χ S, of which no Ṡ is left in ζ̇ \[m/(N·s)\].
    #[must_use]
    pub fn crossing(&self) -> f64 {
        (self.assumed_inertia * self.feedforward * self.strain + self.load_rate) / self.inertia
    }

    /// The load's share ν in ṗ − v̂ + ν S, whose rate does not contain the load's rate either.
    pub(super) fn observed_crossing(&self) -> f64 {
        ((self.assumed_inertia / self.inertia - 1.0) * self.feedforward * self.strain) + self.load_rate / self.inertia
    }

    /// A, B, w of V = ½A p² + ½B(ζ + w p)² for which −dV/dt − ṗS is ṗ²/χ + …, never negative, if such values exist
    /// (`docs/certificates.md`); otherwise a start for the search.
    pub(super) fn natural_storage(&self) -> [f64; 3] {
        let [_, rate, load, _] = self.feedback();
        let chi = self.crossing();
        let w = self.slope * chi / self.strain;
        let r = w - rate / self.inertia + (load + 1.0) / (self.inertia * chi);
        [self.slope / self.strain, 1.0 / (chi * r.abs().max(1e-3 * rate / self.inertia)), w]
    }

    /// Everything that the proof divides by or takes the logarithm of.
    pub(super) fn is_usable(&self) -> bool {
        let positive = [self.inertia, self.assumed_inertia, self.slope, self.reach, self.strain, self.crossing()];
        positive.iter().all(|value| *value > 0.0 && value.is_finite())
            && [self.observer, self.load_rate].iter().all(|value| *value >= 0.0 && value.is_finite())
    }
}
