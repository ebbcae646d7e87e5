//! The update laws as differential equations.

use super::{Drive, Estimator, Laws};
use crate::blocks::rbf::NetworkChange;
use crate::continuous::{Decision, Limit};

/// A direction of the estimates, or their time derivative, without the weights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scalars {
    pub inertia: f64,
    pub bound: f64,
}

/// What changes around an estimator.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EstimatorChange<'a, const D: usize> {
    pub scalars: Scalars,
    pub weights: &'a [f64],
    pub drive: Drive,
    /// Normalised input of the network.
    pub x: [f64; D],
}

impl<const D: usize> Estimator<D> {
    #[inline]
    pub fn nodes(&self) -> usize {
        self.network.nodes()
    }

    #[inline]
    pub fn put(&self, weights: &mut [f64]) -> Scalars {
        self.network.put_weights(weights);
        Scalars { inertia: self.inertia, bound: self.bound }
    }

    #[inline]
    pub fn take(&mut self, scalars: Scalars, weights: &[f64]) {
        Scalars { inertia: self.inertia, bound: self.bound } = scalars;
        self.network.take_weights(weights);
    }

    /// Time derivatives; those of the weights into `weights`.
    #[inline]
    pub fn derivatives(&self, drive: &Drive, held: bool, weights: &mut [f64]) -> Scalars {
        let Laws { weights: law, bound, inertia, .. } = &self.laws;
        if self.has_network {
            self.network.put_rates(law, drive.s, held, weights);
        } else {
            weights.fill(0.0);
        }
        Scalars { inertia: inertia.rate(self.inertia, drive.inertia), bound: bound.rate(self.bound, drive.bound) }
    }

    /// Exact change of [`derivatives`](Self::derivatives).
    #[inline]
    pub fn derivative_change(
        &self,
        drive: &Drive,
        held: bool,
        by: &EstimatorChange<'_, D>,
        weights: &mut [f64],
    ) -> Scalars {
        let Laws { weights: law, bound, inertia, .. } = &self.laws;
        if self.has_network {
            let change = NetworkChange { weights: by.weights, x: by.x, forcing: by.drive.s };
            self.network.put_rate_changes(law, drive.s, held, &change, weights);
        } else {
            weights.fill(0.0);
        }
        Scalars {
            inertia: inertia.rate(by.scalars.inertia, by.drive.inertia),
            bound: bound.rate(by.scalars.bound, by.drive.bound),
        }
    }

    /// Change of the network's output by that of its weights and of its normalised input.
    #[inline]
    pub fn output_change(&self, weights: &[f64], x: [f64; D]) -> f64 {
        if self.has_network { self.network.output_change(weights, x) } else { 0.0 }
    }

    /// The weights' ball, if there is one.
    #[inline]
    fn ball(&self, drive: &Drive) -> Option<Limit> {
        let Laws { weights, radius, .. } = &self.laws;
        (self.has_network && *radius > 0.0).then(|| self.network.limit(weights, drive.s, *radius))
    }

    /// Positive until the ball takes hold of the weights or lets them go.
    #[inline]
    pub fn indicator(&self, drive: &Drive, held: bool) -> f64 {
        self.ball(drive).map_or(1.0, |ball| ball.indicator(held))
    }

    /// Whether the ball holds the weights, which are put back if they are beyond.
    #[inline]
    pub fn decide(&mut self, drive: &Drive, held: &mut bool, decision: &mut Decision) {
        let Laws { weights, radius, .. } = self.laws;
        if self.has_network && radius > 0.0 {
            self.network.decide(&weights, drive.s, radius, held, decision);
        } else {
            decision.regimes |= std::mem::take(held);
        }
    }
}
