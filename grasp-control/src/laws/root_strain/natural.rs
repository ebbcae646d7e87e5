//! What the plant's own scales are, and the gains in them.
//!
//! A hub on its arm swings with Ω_i = √(3EI_i/(l J₀)), the object between the arms with Ω = √(Σ 3EI_i/l³ / m₀): the rates of the
//! plant, from what is known of it at the start. Slopes G and reaching rates k are pure numbers in these, and so is the share
//! c_i of root strain, a time. So one set of gains serves long and short, stiff and soft arms. G_i is a number of times Ω, not
//! Ω_i: on its way to the target the object takes the tips along, and a hub that lags behind it bends its arm.
//! The low-pass on the rates of moments and shears has a number times the hubs' rate, so what a hub answers to its arm's beam
//! modes, about c_i f_i ω, is the same for all arms. Observers and the low-pass on the moments are no part of this: sampling, delay and
//! noise bound them, and these do not scale with the arms.

// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]

use super::RootStrainGains;
use crate::laws::encoders::Actuation;
use crate::target::Arms;
use serde::{Deserialize, Serialize};

/// Compliances of the arms, which turn strain into motion.
#[derive(Debug, Clone, Copy)]
pub struct Compliance {
    /// 3EIᵢ/l³ \[N/m\].
    pub tip_stiffness: [f64; 2],
    /// b = 1/Σ(3EIᵢ/l³) \[m/N\].
    pub tip: f64,
}

impl Compliance {
    /// Of these arms.
    #[must_use]
    pub fn of(arms: &Arms) -> Self {
        let l = arms.length;
        let tip_stiffness = arms.ei.map(|ei| 3.0 * ei / (l * l * l));
        Self { tip_stiffness, tip: 1.0 / (tip_stiffness[0] + tip_stiffness[1]) }
    }
}

/// A low-pass of less is off \[rad/s\]: it would never move, and one over it be too large a number.
const SLOWEST: f64 = 1e-9;

/// The gains with their units, for a plant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scaled {
    /// Gᵢ of the hubs \[1/s\].
    pub hub_slope: [f64; 2],
    /// kᵢ of the hubs \[1/s\].
    pub hub_reach: [f64; 2],
    /// cᵢ \[s\] of the hubs.
    pub hub_strain: [f64; 2],
    /// G of the object \[1/s\].
    pub slope: f64,
    /// k of the object \[1/s\].
    pub reach: f64,
    /// Bandwidth of the low-pass on the rates of moments and shears \[rad/s\]; 0 where it would need longer than thirty years.
    pub strain_rate_bandwidth: f64,
    /// κ √b \[(m/N)^½\]: the object's surface has the share κ √(b/m̂) of the tip shears.
    pub strain: f64,
}

impl Scaled {
    /// The gains for these arms, and the inertias and mass that are known at the start.
    #[must_use]
    pub fn new(gains: &RootStrainGains, arms: &Arms, actuation: &Actuation) -> Self {
        let rate = |i: usize| (3.0 * arms.ei[i] / (arms.length * actuation.hub_inertia[i])).sqrt();
        let tip = Compliance::of(arms).tip;
        let object = (tip * gains.mass.initial).sqrt().recip();
        let bandwidth = gains.strain_rate_bandwidth * (rate(0) * rate(1)).sqrt();
        Self {
            hub_slope: [0, 1].map(|i| gains.hub[i].slope * object),
            hub_reach: [0, 1].map(|i| gains.hub[i].reach * rate(i)),
            hub_strain: [0, 1].map(|i| gains.hub[i].strain / rate(i)),
            slope: gains.object.slope * object,
            reach: gains.object.reach * object,
            strain_rate_bandwidth: if bandwidth < SLOWEST { 0.0 } else { bandwidth },
            strain: gains.object.strain * tip.sqrt(),
        }
    }
}
