//! Observers as differential equations: directions, states, limits.

use super::{Known, Motion, Observer, RateSource};
use crate::continuous::{Decision, Limit};

/// A direction in which everything that an observer's derivatives depend on changes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ObserverChange {
    pub observer: Observer,
    pub measured: Motion,
    pub force: f64,
    pub inertia: f64,
}

impl Observer {
    /// Position, rate, disturbance.
    #[inline]
    pub(crate) fn to_array(self) -> [f64; 3] {
        [self.position, self.rate, self.disturbance]
    }

    #[inline]
    pub(crate) fn from_array([position, rate, disturbance]: [f64; 3]) -> Self {
        Self { position, rate, disturbance }
    }

    /// Time derivatives as long as the limit of the disturbance holds, or as it does not.
    #[inline]
    pub(crate) fn present_derivative(&self, known: &Known, measured: Motion, force: f64, held: bool) -> Self {
        let free = self.free_derivative(known, measured, force);
        Self { disturbance: if held { 0.0 } else { free.disturbance }, ..free }
    }

    /// Exact change of [`present_derivative`](Self::present_derivative).
    #[inline]
    pub(crate) fn derivative_change(
        &self,
        known: &Known,
        measured: Motion,
        force: f64,
        held: bool,
        by: &ObserverChange,
    ) -> Self {
        // Linear in all but the inertia.
        let linear = by.observer.free_derivative(known, by.measured, by.force);
        let Known { bandwidth: w, inertia, .. } = *known;
        let by_inertia = by.inertia / inertia;
        let learnt = inertia * w * w * self.error(known, measured);
        Self {
            position: linear.position,
            rate: linear.rate - (force + self.disturbance) / inertia * by_inertia,
            disturbance: if held { 0.0 } else { linear.disturbance + learnt * by_inertia },
        }
    }

    /// Prediction error as a rate.
    #[inline]
    pub(crate) fn error(&self, known: &Known, measured: Motion) -> f64 {
        match known.source {
            RateSource::Measured => measured.rate - self.rate,
            RateSource::Estimated => known.bandwidth * (measured.position - self.position),
        }
    }

    /// The disturbance and its limit.
    #[inline]
    pub(crate) fn limit(&self, known: &Known, measured: Motion, force: f64) -> Limit {
        let free = self.free_derivative(known, measured, force).disturbance;
        Limit { most: known.limit, magnitude: self.disturbance.abs(), outward: free * self.disturbance.signum() }
    }

    /// Whether the limit holds the disturbance, and by what it is to be multiplied: less than 1 puts back one that is beyond.
    #[inline]
    #[must_use]
    pub(crate) fn decide(
        &self,
        known: &Known,
        measured: Motion,
        force: f64,
        held: &mut bool,
        decision: &mut Decision,
    ) -> f64 {
        self.limit(known, measured, force).decide(held, decision)
    }
}
