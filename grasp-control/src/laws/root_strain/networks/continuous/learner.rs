//! One learner as differential equations.

use super::super::{Approximator, NetworkGains, prediction_error};
use crate::blocks::adaptation::LeakyLaw;
use crate::blocks::observer::{Known, Motion, Observer};
use crate::blocks::rbf::NetworkChange;
use crate::continuous::{Decision, Limit, slides, slides_change};

/// What a learner sees besides its network's input.
#[derive(Clone, Copy)]
pub(in crate::laws::root_strain) struct Sight {
    pub known: Known,
    pub observer: Observer,
    pub measured: Motion,
}

/// Change of that; of what is known only the inertia changes.
#[derive(Clone, Copy)]
pub(in crate::laws::root_strain) struct SightChange {
    pub inertia: f64,
    pub observer: Observer,
    pub measured: Motion,
}

/// What a learner makes of what it sees.
pub(super) struct Learning {
    /// Δ̂ before the clip.
    raw: f64,
    /// What the clip leaves.
    pub(super) output: f64,
    /// J ω² ẽ, which drives the observer's constant.
    learnt: f64,
    error: f64,
    sign: f64,
    /// Whether learning pushes Δ̂ away from zero.
    outwards: bool,
}

impl<const D: usize> Approximator<D> {
    #[inline]
    fn law(gains: &NetworkGains) -> LeakyLaw {
        LeakyLaw { gain: 1.0, leakage: gains.leakage }
    }

    /// Evaluates the network at the normalised input.
    #[inline]
    pub(super) fn learning(&mut self, x: [f64; D], sight: &Sight) -> Learning {
        let Known { bandwidth, inertia, limit, .. } = sight.known;
        let (error, sign) = prediction_error(&sight.known, &sight.observer, sight.measured);
        self.network.activate(x);
        let raw = self.network.output() + self.bound * sign;
        let learnt = inertia * bandwidth * bandwidth * error;
        Learning { raw, output: raw.clamp(-limit, limit), learnt, error, sign, outwards: raw * learnt > 0.0 }
    }

    /// Forcing of the weights' law.
    #[inline]
    fn forcing(&self, learning: &Learning, limit: f64) -> f64 {
        learning.learnt * slides(learning.raw, limit, learning.outwards) / self.gain
    }

    /// The robust term and its limit.
    #[inline]
    fn bound_limit(&self, gains: &NetworkGains, learning: &Learning, limit: f64) -> Limit {
        let outward = Self::law(gains).rate(self.bound, gains.robust * learning.learnt * learning.sign);
        Limit { most: limit, magnitude: self.bound, outward }
    }

    /// ε̂˙; Ŵ˙ into `weights`. `held`: the ball, the robust term's limit.
    #[inline]
    pub(super) fn derivatives(
        &mut self,
        gains: &NetworkGains,
        x: [f64; D],
        sight: &Sight,
        held: [bool; 2],
        weights: &mut [f64],
    ) -> f64 {
        let learning = self.learning(x, sight);
        let forcing = self.forcing(&learning, sight.known.limit);
        self.network.put_rates(&Self::law(gains), forcing, held[0], weights);
        if held[1] { 0.0 } else { self.bound_limit(gains, &learning, sight.known.limit).outward }
    }

    /// Change of Δ̂ for a change of the normalised input, of what is seen, and of (Ŵ, ε̂).
    #[inline]
    pub(super) fn output_change(&self, learning: &Learning, sight: &Sight, by: &Change<'_, D>) -> f64 {
        if learning.raw.abs() > sight.known.limit { 0.0 } else { self.raw_change(learning, sight, by) }
    }

    #[inline]
    fn raw_change(&self, learning: &Learning, sight: &Sight, by: &Change<'_, D>) -> f64 {
        let network = self.network.output_change(by.weights, by.x);
        network + by.bound * learning.sign + self.bound * sign_change(learning, sight, &by.sight)
    }

    /// Exact change of [`derivatives`](Self::derivatives).
    #[inline]
    pub(super) fn derivative_change(
        &mut self,
        gains: &NetworkGains,
        x: [f64; D],
        sight: &Sight,
        held: [bool; 2],
        by: &Change<'_, D>,
        weights: &mut [f64],
    ) -> f64 {
        let learning = self.learning(x, sight);
        let Learning { raw, learnt, sign, outwards, .. } = learning;
        let limit = sight.known.limit;
        let learnt_change = learnt_change(&learning, sight, &by.sight);
        let share_change = slides_change(raw, limit, outwards, self.raw_change(&learning, sight, by));
        let forcing = self.forcing(&learning, limit);
        let forcing_change = (learnt_change * slides(raw, limit, outwards) + learnt * share_change) / self.gain;
        let change = NetworkChange { weights: by.weights, x: by.x, forcing: forcing_change };
        self.network.put_rate_changes(&Self::law(gains), forcing, held[0], &change, weights);
        if held[1] {
            return 0.0;
        }
        let driven = learnt_change * sign + learnt * sign_change(&learning, sight, &by.sight);
        Self::law(gains).rate(by.bound, gains.robust * driven)
    }

    #[inline]
    pub(super) fn indicators(&mut self, gains: &NetworkGains, x: [f64; D], sight: &Sight, held: [bool; 2]) -> [f64; 3] {
        let limit = sight.known.limit;
        let learning = self.learning(x, sight);
        let ball = self.network.limit(&Self::law(gains), self.forcing(&learning, limit), limit);
        let bound = self.bound_limit(gains, &learning, limit);
        [ball.indicator(held[0]), bound.indicator(held[1]), limit - learning.raw.abs()]
    }

    #[inline]
    pub(super) fn decide(
        &mut self,
        gains: &NetworkGains,
        x: [f64; D],
        sight: &Sight,
        held: [&mut bool; 2],
        decision: &mut Decision,
    ) {
        let limit = sight.known.limit;
        let learning = self.learning(x, sight);
        let forcing = self.forcing(&learning, limit);
        let [ball, robust] = held;
        self.network.decide(&Self::law(gains), forcing, limit, ball, decision);
        self.bound *= self.bound_limit(gains, &learning, limit).decide(robust, decision);
    }
}

/// What changes around a learner.
pub(super) struct Change<'a, const D: usize> {
    pub weights: &'a [f64],
    pub bound: f64,
    /// Normalised input.
    pub x: [f64; D],
    pub sight: SightChange,
}

/// Change of ẽ.
#[inline]
fn error_change(sight: &Sight, by: &SightChange) -> f64 {
    // Linear in both.
    by.observer.error(&sight.known, by.measured)
}

/// Change of J ω² ẽ.
#[inline]
fn learnt_change(learning: &Learning, sight: &Sight, by: &SightChange) -> f64 {
    let Known { bandwidth, inertia, .. } = sight.known;
    bandwidth * bandwidth * (inertia * error_change(sight, by) + by.inertia * learning.error)
}

/// Change of tanh(ẽ/ϵ), ϵ = F_max/(J ω).
#[inline]
fn sign_change(learning: &Learning, sight: &Sight, by: &SightChange) -> f64 {
    let Known { bandwidth, inertia, limit, .. } = sight.known;
    let argument = (error_change(sight, by) * inertia + learning.error * by.inertia) * bandwidth / limit;
    (1.0 - learning.sign * learning.sign) * argument
}
