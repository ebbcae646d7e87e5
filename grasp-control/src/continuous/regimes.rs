//! Which limits hold what is learnt.

use super::LAYER;
use serde::{Deserialize, Serialize};

/// Which limits hold, of hub 1, hub 2 and the object. Discrete states of a law as differential equations.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Regimes {
    /// Observed disturbances at the limits of their actuators.
    pub disturbance: [bool; 3],
    /// Weights on their balls.
    pub weights: [bool; 3],
    /// Robust terms of the root-strain law's networks at the limits of their actuators.
    pub bound: [bool; 3],
}

/// What [`decide`](super::Continuous::decide) did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Decision {
    /// Regimes have changed.
    pub regimes: bool,
    /// States have changed: one was beyond its limit.
    pub states: bool,
}

impl Decision {
    /// One decision after another.
    #[must_use]
    #[inline]
    pub fn and(self, other: Self) -> Self {
        Self { regimes: self.regimes | other.regimes, states: self.states | other.states }
    }
}

/// How far inside its limit a magnitude is put when it is held or let go, relatively: so far that the indicator of the next
/// event is positive, and no farther.
const INSIDE: f64 = 1e-12;

/// A magnitude with a limit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limit {
    /// The limit.
    pub most: f64,
    /// The magnitude.
    pub magnitude: f64,
    /// What its rate would be without the limit.
    pub outward: f64,
}

impl Limit {
    /// Positive until the regime has to change.
    #[inline]
    pub fn indicator(&self, held: bool) -> f64 {
        if held { self.outward } else { self.most - self.magnitude }
    }

    /// Whether the limit holds, and the factor that puts the magnitude where it belongs.
    #[inline]
    pub fn decide(&self, held: &mut bool, decision: &mut Decision) -> f64 {
        let holds = self.outward > 0.0 && self.magnitude >= self.most * (1.0 - 2.0 * INSIDE);
        decision.regimes |= holds != *held;
        *held = holds;
        let inside = self.most * (1.0 - INSIDE);
        if self.magnitude > inside {
            decision.states = true;
            inside / self.magnitude
        } else {
            1.0
        }
    }
}

/// The share of its rate that an integral keeps where its `command` is near or beyond `limit` and would be pushed `outwards`.
#[inline]
pub(crate) fn slides(command: f64, limit: f64, outwards: bool) -> f64 {
    if outwards { (0.5 + (limit - command.abs()) / (2.0 * LAYER * limit)).clamp(0.0, 1.0) } else { 1.0 }
}

/// Change of [`slides`] for a `change` of the command.
#[inline]
pub(crate) fn slides_change(command: f64, limit: f64, outwards: bool, change: f64) -> f64 {
    let within = (command.abs() - limit).abs() < LAYER * limit;
    if outwards && within { -change * command.signum() / (2.0 * LAYER * limit) } else { 0.0 }
}
