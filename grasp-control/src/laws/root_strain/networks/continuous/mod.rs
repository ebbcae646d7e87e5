//! Networks and robust terms as differential equations.
//!
//! The learnt force Δ̂ = Ŵᵀ Y(X) + ε̂ tanh(ẽ/ϵ), clipped to the limit, follows states and inputs at once. Its learning stops where
//! it is beyond the limit and would be pushed further; forgetting brings it back, so it slides along the limit, as that of an
//! integral does.

mod learner;

pub(in crate::laws::root_strain) use learner::{Sight, SightChange};

use super::{NetworkGains, Networks, Seen};
use crate::continuous::Decision;
use learner::Change;

/// Directions of hub 1, hub 2 and object: weights, robust terms.
pub(in crate::laws::root_strain) struct NetworkDirection<'a> {
    pub weights: [&'a [f64]; 3],
    pub bounds: [f64; 3],
}

impl Networks {
    /// Numbers of weights of hub 1, hub 2 and object.
    #[inline]
    pub fn nodes(&self) -> [usize; 3] {
        [self.hubs[0].network.nodes(), self.hubs[1].network.nodes(), self.object.network.nodes()]
    }

    /// Writes the weights; gives the robust terms.
    #[inline]
    pub fn put(&self, weights: [&mut [f64]; 3]) -> [f64; 3] {
        let [u1, u2, w] = weights;
        self.hubs[0].network.put_weights(u1);
        self.hubs[1].network.put_weights(u2);
        self.object.network.put_weights(w);
        [self.hubs[0].bound, self.hubs[1].bound, self.object.bound]
    }

    /// Takes weights and robust terms.
    #[inline]
    pub fn take(&mut self, states: &NetworkDirection<'_>) {
        let [u1, u2, w] = states.weights;
        self.hubs[0].network.take_weights(u1);
        self.hubs[1].network.take_weights(u2);
        self.object.network.take_weights(w);
        [self.hubs[0].bound, self.hubs[1].bound, self.object.bound] = states.bounds;
    }

    /// Δ̂.
    #[inline]
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
    #[inline]
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
    #[inline]
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
    #[inline]
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
    #[inline]
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
    #[inline]
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
    #[inline]
    pub fn norm_changes(&self, weights: [&[f64]; 3]) -> [f64; 3] {
        [
            self.hubs[0].network.norm_change(weights[0]),
            self.hubs[1].network.norm_change(weights[1]),
            self.object.network.norm_change(weights[2]),
        ]
    }
}

#[inline]
fn change<'a, const D: usize>(
    by: &NetworkDirection<'a>,
    i: usize,
    x: [f64; D],
    sight: &[SightChange; 3],
) -> Change<'a, D> {
    Change { weights: by.weights[i], bound: by.bounds[i], x, sight: sight[i] }
}
