//! Networks and robust terms as differential equations.
//!
//! The learnt force Δ̂ = Ŵᵀ Y(X) + ε̂ tanh(ẽ/ϵ), clipped to the limit, follows states and inputs at once. Its learning stops where
//! it is beyond the limit and would be pushed further; forgetting brings it back, so it slides along the limit, as that of an
//! integral does.

use super::{Approximator, NetworkGains, Networks, Seen, prediction_error};
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

/// Rates of a learner's bound; of its weights where they are asked for.
struct Learning {
    /// Δ̂ before the clip.
    raw: f64,
    /// What the clip leaves.
    output: f64,
    /// J ω² ẽ, which drives the observer's constant.
    learnt: f64,
    error: f64,
    sign: f64,
    /// Whether learning pushes Δ̂ away from zero.
    outwards: bool,
}

impl<const D: usize> Approximator<D> {
    fn law(gains: &NetworkGains) -> LeakyLaw {
        LeakyLaw { gain: 1.0, leakage: gains.leakage }
    }

    /// Evaluates the network at the normalised input.
    fn learning(&mut self, x: [f64; D], sight: &Sight) -> Learning {
        let Known { bandwidth, inertia, limit, .. } = sight.known;
        let (error, sign) = prediction_error(&sight.known, &sight.observer, sight.measured);
        self.network.activate(x);
        let raw = self.network.output() + self.bound * sign;
        let learnt = inertia * bandwidth * bandwidth * error;
        Learning { raw, output: raw.clamp(-limit, limit), learnt, error, sign, outwards: raw * learnt > 0.0 }
    }

    /// Forcing of the weights' law.
    fn forcing(&self, learning: &Learning, limit: f64) -> f64 {
        learning.learnt * slides(learning.raw, limit, learning.outwards) / self.gain
    }

    /// The robust term and its limit.
    fn bound_limit(&self, gains: &NetworkGains, learning: &Learning, limit: f64) -> Limit {
        let outward = Self::law(gains).rate(self.bound, gains.robust * learning.learnt * learning.sign);
        Limit { most: limit, magnitude: self.bound, outward }
    }

    /// ε̂˙; Ŵ˙ into `weights`. `held`: the ball, the robust term's limit.
    fn derivatives(
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
    fn output_change(&self, learning: &Learning, sight: &Sight, by: &Change<'_, D>) -> f64 {
        if learning.raw.abs() > sight.known.limit { 0.0 } else { self.raw_change(learning, sight, by) }
    }

    fn raw_change(&self, learning: &Learning, sight: &Sight, by: &Change<'_, D>) -> f64 {
        let network = self.network.output_change(by.weights) + inner(&self.network.gradient(), &by.x);
        network + by.bound * learning.sign + self.bound * sign_change(learning, sight, &by.sight)
    }

    /// Exact change of [`derivatives`](Self::derivatives).
    fn derivative_change(
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

    fn indicators(&mut self, gains: &NetworkGains, x: [f64; D], sight: &Sight, held: [bool; 2]) -> [f64; 3] {
        let limit = sight.known.limit;
        let learning = self.learning(x, sight);
        let ball = self.network.limit(&Self::law(gains), self.forcing(&learning, limit), limit);
        let bound = self.bound_limit(gains, &learning, limit);
        [ball.indicator(held[0]), bound.indicator(held[1]), limit - learning.raw.abs()]
    }

    fn decide(
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
struct Change<'a, const D: usize> {
    weights: &'a [f64],
    bound: f64,
    /// Normalised input.
    x: [f64; D],
    sight: SightChange,
}

fn inner<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Change of ẽ.
fn error_change(sight: &Sight, by: &SightChange) -> f64 {
    // Linear in both.
    by.observer.error(&sight.known, by.measured)
}

/// Change of J ω² ẽ.
fn learnt_change(learning: &Learning, sight: &Sight, by: &SightChange) -> f64 {
    let Known { bandwidth, inertia, .. } = sight.known;
    bandwidth * bandwidth * (inertia * error_change(sight, by) + by.inertia * learning.error)
}

/// Change of tanh(ẽ/ϵ), ϵ = F_max/(J ω).
fn sign_change(learning: &Learning, sight: &Sight, by: &SightChange) -> f64 {
    let Known { bandwidth, inertia, limit, .. } = sight.known;
    let argument = (error_change(sight, by) * inertia + learning.error * by.inertia) * bandwidth / limit;
    (1.0 - learning.sign * learning.sign) * argument
}

/// Directions of hub 1, hub 2 and object: weights, robust terms.
pub(in crate::laws::root_strain) struct NetworkDirection<'a> {
    pub weights: [&'a [f64]; 3],
    pub bounds: [f64; 3],
}

impl Networks {
    /// Numbers of weights of hub 1, hub 2 and object.
    pub fn nodes(&self) -> [usize; 3] {
        [self.hubs[0].network.nodes(), self.hubs[1].network.nodes(), self.object.network.nodes()]
    }

    /// Writes the weights; gives the robust terms.
    pub fn put(&self, weights: [&mut [f64]; 3]) -> [f64; 3] {
        let [u1, u2, w] = weights;
        self.hubs[0].network.put_weights(u1);
        self.hubs[1].network.put_weights(u2);
        self.object.network.put_weights(w);
        [self.hubs[0].bound, self.hubs[1].bound, self.object.bound]
    }

    /// Takes weights and robust terms.
    pub fn take(&mut self, states: &NetworkDirection<'_>) {
        let [u1, u2, w] = states.weights;
        self.hubs[0].network.take_weights(u1);
        self.hubs[1].network.take_weights(u2);
        self.object.network.take_weights(w);
        [self.hubs[0].bound, self.hubs[1].bound, self.object.bound] = states.bounds;
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

    /// Δ̂.
    pub fn outputs(&mut self, seen: &Seen<'_>, sight: &[Sight; 3]) -> [f64; 3] {
        let (z, x) = ([self.z(seen, 0), self.z(seen, 1)], self.x(seen));
        let [hub1, hub2] = &mut self.hubs;
        [
            hub1.learning(z[0], &sight[0]).output,
            hub2.learning(z[1], &sight[1]).output,
            self.object.learning(x, &sight[2]).output,
        ]
    }

    /// Change of [`outputs`](Self::outputs).
    pub fn output_changes(
        &mut self,
        (seen, sight): (&Seen<'_>, &[Sight; 3]),
        (seen_by, sight_by): (&Seen<'_>, &[SightChange; 3]),
        by: &NetworkDirection<'_>,
    ) -> [f64; 3] {
        let hub = |networks: &mut Self, i: usize| {
            let (z, dz) = (networks.z(seen, i), networks.z(seen_by, i));
            let learning = networks.hubs[i].learning(z, &sight[i]);
            networks.hubs[i].output_change(&learning, &sight[i], &change(by, i, dz, sight_by))
        };
        let hubs = [hub(self, 0), hub(self, 1)];
        let (x, dx) = (self.x(seen), self.x(seen_by));
        let learning = self.object.learning(x, &sight[2]);
        [hubs[0], hubs[1], self.object.output_change(&learning, &sight[2], &change(by, 2, dx, sight_by))]
    }

    /// Rates of the robust terms; those of the weights into `out`. `held`: balls, limits of the robust terms.
    pub fn derivatives(
        &mut self,
        gains: &NetworkGains,
        seen: &Seen<'_>,
        sight: &[Sight; 3],
        held: [[bool; 2]; 3],
        out: [&mut [f64]; 3],
    ) -> [f64; 3] {
        let (z, x) = ([self.z(seen, 0), self.z(seen, 1)], self.x(seen));
        let [u1, u2, w] = out;
        let [hub1, hub2] = &mut self.hubs;
        [
            hub1.derivatives(gains, z[0], &sight[0], held[0], u1),
            hub2.derivatives(gains, z[1], &sight[1], held[1], u2),
            self.object.derivatives(gains, x, &sight[2], held[2], w),
        ]
    }

    /// Change of [`derivatives`](Self::derivatives).
    pub fn derivative_changes(
        &mut self,
        gains: &NetworkGains,
        (seen, sight): (&Seen<'_>, &[Sight; 3]),
        (seen_by, sight_by): (&Seen<'_>, &[SightChange; 3]),
        by: &NetworkDirection<'_>,
        held: [[bool; 2]; 3],
        out: [&mut [f64]; 3],
    ) -> [f64; 3] {
        let (z, x) = ([self.z(seen, 0), self.z(seen, 1)], self.x(seen));
        let (dz, dx) = ([self.z(seen_by, 0), self.z(seen_by, 1)], self.x(seen_by));
        let [u1, u2, w] = out;
        let [hub1, hub2] = &mut self.hubs;
        let hub_by = |i: usize| change(by, i, dz[i], sight_by);
        [
            hub1.derivative_change(gains, z[0], &sight[0], held[0], &hub_by(0), u1),
            hub2.derivative_change(gains, z[1], &sight[1], held[1], &hub_by(1), u2),
            self.object.derivative_change(gains, x, &sight[2], held[2], &change(by, 2, dx, sight_by), w),
        ]
    }

    /// Of each learner: ball, robust term, clip.
    pub fn indicators(
        &mut self,
        gains: &NetworkGains,
        seen: &Seen<'_>,
        sight: &[Sight; 3],
        held: [[bool; 2]; 3],
    ) -> [[f64; 3]; 3] {
        let (z, x) = ([self.z(seen, 0), self.z(seen, 1)], self.x(seen));
        let [hub1, hub2] = &mut self.hubs;
        [
            hub1.indicators(gains, z[0], &sight[0], held[0]),
            hub2.indicators(gains, z[1], &sight[1], held[1]),
            self.object.indicators(gains, x, &sight[2], held[2]),
        ]
    }

    /// Which balls and limits of robust terms hold.
    pub fn decide(
        &mut self,
        gains: &NetworkGains,
        seen: &Seen<'_>,
        sight: &[Sight; 3],
        balls: &mut [bool; 3],
        bounds: &mut [bool; 3],
        decision: &mut Decision,
    ) {
        for i in 0..2 {
            let z = self.z(seen, i);
            self.hubs[i].decide(gains, z, &sight[i], [&mut balls[i], &mut bounds[i]], decision);
        }
        let x = self.x(seen);
        self.object.decide(gains, x, &sight[2], [&mut balls[2], &mut bounds[2]], decision);
    }

    /// Change of the norms of the weights.
    pub fn norm_changes(&self, weights: [&[f64]; 3]) -> [f64; 3] {
        [
            self.hubs[0].network.norm_change(weights[0]),
            self.hubs[1].network.norm_change(weights[1]),
            self.object.network.norm_change(weights[2]),
        ]
    }
}

fn change<'a, const D: usize>(
    by: &NetworkDirection<'a>,
    i: usize,
    x: [f64; D],
    sight: &[SightChange; 3],
) -> Change<'a, D> {
    Change { weights: by.weights[i], bound: by.bounds[i], x, sight: sight[i] }
}
