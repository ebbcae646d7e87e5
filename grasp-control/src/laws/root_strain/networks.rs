//! Networks and robust terms in the place of the constant basis function: Δ̂ = Ŵᵀ Y(X) + ε̂ tanh(ẽ/ϵ).
//!
//! The paper's networks (35), (53) with their inputs and robust terms, but driven by the prediction error ẽ of the
//! [`Observer`], not by s: of ẽ only disturbances make any, and the rates among the inputs are predicted ones, so the noise in ẽ is not
//! in Y.
//!
//! ```text
//! Ŵ˙ = Proj(J ω² ẽ Y/‖Y(0)‖² − ℓ Ŵ),   ε̂˙ = ρ J ω² ẽ tanh(ẽ/ϵ) − ℓ ε̂,   ϵ = F_max/(J ω)
//! ```
//!
//! Proj keeps Ŵ in Lemma 3's ball, whose radius is the actuator's limit. At the target, where all inputs are zero, the output
//! changes as the observer's constant does; what the network adds is that it tells places apart. It is evaluated once per
//! step, at the step's mean inputs.

mod continuous;

pub(super) use continuous::{NetworkDirection, Sight, SightChange};

use super::loops::Point;
use crate::blocks::adaptation::LeakyLaw;
use crate::blocks::exponential::{exp, tanh};
use crate::blocks::observer::{Known, Motion, Observer, RateSource};
use crate::blocks::rbf::Network;
use crate::laws::nabfc::RbfLayout;
use crate::target::Arms;
use serde::{Deserialize, Serialize};

/// What learns the disturbances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Learner {
    /// The observers: one constant basis function per coordinate.
    #[default]
    Observer,
    /// Networks and robust terms.
    Networks,
}

/// Gains of networks and robust terms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NetworkGains {
    /// Forgetting rate ℓ \[1/s\].
    pub leakage: f64,
    /// Share ρ of the robust terms' learning rate in that of the networks.
    pub robust: f64,
}

/// The learner of one coordinate.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Approximator<const D: usize> {
    network: Network<D>,
    /// ‖Y(0)‖².
    gain: f64,
    /// ε̂ \[N or N·m\].
    bound: f64,
}

/// ẽ as a rate, and tanh(ẽ/ϵ).
fn prediction_error(known: &Known, observer: &Observer, measured: Motion) -> (f64, f64) {
    let Known { source, bandwidth, inertia, limit } = *known;
    let error = match source {
        RateSource::Measured => measured.rate - observer.rate,
        RateSource::Estimated => bandwidth * (measured.position - observer.position),
    };
    (error, tanh(error * inertia * bandwidth / limit))
}

impl<const D: usize> Approximator<D> {
    fn new(mut network: Network<D>) -> Self {
        network.activate([0.0; D]);
        Self { gain: network.learning_gain(), network, bound: 0.0 }
    }

    /// Time derivatives of ‖Ŵ‖ and ε̂ where the network was evaluated last.
    fn rates(
        &self,
        gains: &NetworkGains,
        known: &Known,
        observer: &Observer,
        rates: &Observer,
        measured: Motion,
    ) -> [f64; 2] {
        let Known { bandwidth, inertia, .. } = *known;
        let (error, sign) = prediction_error(known, observer, measured);
        let forgetting = LeakyLaw { gain: 1.0, leakage: gains.leakage };
        let norm = self.network.norm_rate(&forgetting, rates.disturbance / self.gain);
        [norm, forgetting.rate(self.bound, gains.robust * inertia * bandwidth * bandwidth * error * sign)]
    }

    fn reset(&mut self) {
        self.network.reset();
        self.bound = 0.0;
    }

    /// Predicts and learns over a step of `h` \[s\] with everything held; `x` is the normalised input.
    fn step(
        &mut self,
        h: f64,
        gains: &NetworkGains,
        known: &Known,
        x: [f64; D],
        observer: &mut Observer,
        (measured, force): (Motion, f64),
    ) {
        let Known { bandwidth, inertia, limit, .. } = *known;
        let (error, sign) = prediction_error(known, observer, measured);
        self.network.activate(x);
        let robust = self.bound * sign;
        let start = (self.network.output() + robust).clamp(-limit, limit);
        observer.disturbance = start;
        observer.step(h, known, measured, force);
        let learnt = observer.disturbance - start;
        self.network.adapt(exp(-gains.leakage * h), learnt / self.gain);
        self.network.project(limit);
        let law = LeakyLaw { gain: 1.0, leakage: gains.leakage }.held(h);
        let forcing = gains.robust * inertia * bandwidth * bandwidth * error * sign;
        self.bound = law.apply(self.bound, forcing).min(limit);
        observer.disturbance = (self.network.output() + robust).clamp(-limit, limit);
    }
}

/// The learners of hubs and object.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Networks {
    hubs: [Approximator<3>; 2],
    object: Approximator<7>,
    /// 1/scale of Z and of X.
    hub_scales: [f64; 3],
    object_scales: [f64; 7],
    /// 1/EIᵢ.
    compliance: [f64; 2],
}

/// What the networks see besides the point: the surfaces at it.
pub(super) struct Seen<'a> {
    pub at: &'a Point,
    pub surface: f64,
    pub posture: [f64; 2],
    /// Rates of the virtual controls: α̇₁, α̇₂ᵢ.
    pub alpha_rate: f64,
    pub posture_alpha_rate: [f64; 2],
    /// Shears and their rates of each arm.
    pub shear: [f64; 2],
    pub shear_rate: [f64; 2],
}

impl Networks {
    pub fn new(layout: &RbfLayout, arms: &Arms) -> Self {
        let hub = Approximator::new(Network::new(layout.posture(), layout.width_posture));
        Self {
            hubs: [hub.clone(), hub],
            object: Approximator::new(Network::new(layout.object(), layout.width_object)),
            hub_scales: [layout.angle_scale, layout.posture_surface_scale, layout.posture_alpha_scale].map(f64::recip),
            object_scales: [
                layout.position_scale,
                layout.object_surface_scale,
                layout.object_alpha_scale,
                layout.shear_scale,
                layout.shear_scale,
                layout.shear_rate_scale,
                layout.shear_rate_scale,
            ]
            .map(f64::recip),
            compliance: arms.ei.map(f64::recip),
        }
    }

    /// Nothing learnt.
    pub fn reset(&mut self) {
        for hub in &mut self.hubs {
            hub.reset();
        }
        self.object.reset();
    }

    /// Whether nodes, widths and scales are those of other networks.
    pub fn has_settings_of(&self, other: &Self) -> bool {
        let hubs = self.hubs.iter().zip(&other.hubs);
        hubs.into_iter().all(|(one, other)| one.network.has_layout_of(&other.network))
            && self.object.network.has_layout_of(&other.object.network)
            && self.hub_scales == other.hub_scales
            && self.object_scales == other.object_scales
            && self.compliance == other.compliance
    }

    /// Predicts and learns over a step, from motions and known forces.
    pub fn step(
        &mut self,
        h: f64,
        gains: &NetworkGains,
        known: &[Known; 3],
        seen: &Seen<'_>,
        observers: &mut [Observer; 3],
        measured: &[(Motion, f64); 3],
    ) {
        for i in 0..2 {
            let z = self.z(seen, i);
            self.hubs[i].step(h, gains, &known[i], z, &mut observers[i], measured[i]);
        }
        let x = self.x(seen);
        self.object.step(h, gains, &known[2], x, &mut observers[2], measured[2]);
    }

    /// Normalised inputs of hub `i`, or their change.
    fn z(&self, seen: &Seen<'_>, i: usize) -> [f64; 3] {
        let z = [seen.at.e[i], seen.posture[i], seen.posture_alpha_rate[i]];
        std::array::from_fn(|axis| z[axis] * self.hub_scales[axis])
    }

    /// Normalised inputs of the object's network, or their change.
    fn x(&self, seen: &Seen<'_>) -> [f64; 7] {
        let [c1, c2] = self.compliance;
        let x = [
            seen.at.p,
            seen.surface,
            seen.alpha_rate,
            seen.shear[0] * c1,
            seen.shear[1] * c2,
            seen.shear_rate[0] * c1,
            seen.shear_rate[1] * c2,
        ];
        std::array::from_fn(|axis| x[axis] * self.object_scales[axis])
    }

    /// Time derivatives of [`norms`](Self::norms), where the networks were evaluated last; `observers` change at `rates`.
    pub fn norm_rates(
        &self,
        gains: &NetworkGains,
        known: &[Known; 3],
        observers: &[Observer; 3],
        rates: &[Observer; 3],
        motions: &[Motion; 3],
    ) -> ([f64; 2], [f64; 2], f64, f64) {
        let hub = |i: usize| self.hubs[i].rates(gains, &known[i], &observers[i], &rates[i], motions[i]);
        let ([u1, pi1], [u2, pi2]) = (hub(0), hub(1));
        let [w, epsilon] = self.object.rates(gains, &known[2], &observers[2], &rates[2], motions[2]);
        ([u1, u2], [pi1, pi2], w, epsilon)
    }

    /// ‖Ûᵢ‖, π̂ᵢ, ‖Ŵ‖, ε̂.
    pub fn norms(&self) -> ([f64; 2], [f64; 2], f64, f64) {
        let [hub1, hub2] = &self.hubs;
        (
            [hub1.network.norm(), hub2.network.norm()],
            [hub1.bound, hub2.bound],
            self.object.network.norm(),
            self.object.bound,
        )
    }
}
