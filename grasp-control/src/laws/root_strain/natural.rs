//! What the plant's own scales are, and the gains in them.
//!
//! A hub on its arm swings with Ω_i = √(3EI_i/(l J₀)), the object between the arms with Ω = √(Σ 3EI_i/l³ / m₀): the rates of the
//! plant, from what is known of it at the start. Slopes G and reaching rates k are pure numbers in these, and so is the share
//! c_i of root strain, a time. So one set of gains serves long and short, stiff and soft arms. G_i is a number of times Ω, not
//! Ω_i: on its way to the target the object takes the tips along, and a hub that lags behind it bends its arm.
//! An arm's bending adds c_i (3EI_i/l)/Ĵ_i to the slope, 52 1/s for the paper's hubs and the default gains and a seventh of it for hubs seven times as heavy. Held
//! by the same G_i, 8 1/s, these would take 0.3 s. So G_i = G_i0 + 0.4 c_i Ω_i² (1 − 2J₀/Ĵ_i) for Ĵ_i > 2J₀. The answer to strain itself must
//! not grow (beam modes). More of what is missing, or from J₀ on, lets hubs drag the object with short or stiff arms.
//!
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

/// A hub counts as heavy from this multiple of its inertia at the start on. Estimates of light hubs whose torque goes into losses are up
/// to that much too high.
const HEAVY: f64 = 2.0;

/// How much of the slope that strain no longer gives to a heavy hub the surface's own makes up for: enough to be as fast as other laws, and
/// not so much that heavy hubs drag the object with them when arms are short or stiff.
const MADE_UP: f64 = 0.4;

/// A share of less than this does not bend the object's surface: it would take minutes.
const STRAIGHT: f64 = 1e-3;

/// A low-pass of less is off \[rad/s\]: it would never move, and one over it be too large a number.
const SLOWEST: f64 = 1e-9;

/// The gains with their units, for a plant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scaled {
    /// Gᵢ of hubs that are not heavy \[1/s\].
    pub hub_slope: [f64; 2],
    /// By how much more the slope of very heavy hubs is \[1/s\].
    pub hub_rise: [f64; 2],
    /// What of that the inertia divides: a hub is heavy where it is less \[kg·m²/s\].
    pub hub_fall: [f64; 2],
    /// kᵢ of the hubs \[1/s\].
    pub hub_reach: [f64; 2],
    /// cᵢ \[s\] of the hubs.
    pub hub_strain: [f64; 2],
    /// kᵢ Gᵢ of hubs that are not heavy \[1/s²\].
    pub hub_pull: [f64; 2],
    /// kᵢ + fᵢ Gᵢ + 1/cᵢ, what damps these \[1/s\].
    pub hub_damping: [f64; 2],
    /// G of the object \[1/s\].
    pub slope: f64,
    /// k of the object \[1/s\].
    pub reach: f64,
    /// k + f G, what damps the object beside its strain \[1/s\].
    pub damping: f64,
    /// B = (k G)²/(2 q u_max) \[1/(N·s⁴)\], which bends the object's surface: far from the target k G(p) p = D √(2 q u_max |p|/m̂). 0 where it
    /// is straight.
    pub bend: f64,
    /// Bandwidth of the low-pass on the rates of moments and shears \[rad/s\]; 0 where it would need longer than thirty years.
    pub strain_rate_bandwidth: f64,
    /// κ √b \[(m/N)^½\]: the object's surface has the share κ √(b/m̂) of the tip shears.
    pub strain: f64,
    /// 1/(κ √b), of which 1/(m̂ C) is the share 1/√m̂.
    pub inverse_strain: f64,
}

impl Scaled {
    /// The gains for these arms, and the inertias and mass that are known at the start.
    #[must_use]
    pub fn new(gains: &RootStrainGains, arms: &Arms, actuation: &Actuation) -> Self {
        let rate = |i: usize| (3.0 * arms.ei[i] / (arms.length * actuation.hub_inertia[i])).sqrt();
        let tip = Compliance::of(arms).tip;
        let object = (tip * gains.mass.initial).sqrt().recip();
        let bandwidth = gains.strain_rate_bandwidth * (rate(0) * rate(1)).sqrt();
        let (slope, reach) = (gains.object.slope * object, gains.object.reach * object);
        let share = gains.object.brake;
        // cᵢ Ωᵢ² is what strain adds to the slope of a hub of the inertia at the start, cᵢ (3EIᵢ/l)/Ĵᵢ.
        let hub_rise = [0, 1].map(|i| MADE_UP * gains.hub[i].strain * rate(i));
        let bend = (reach * slope).powi(2) / (2.0 * share * actuation.force_limit);
        Self {
            hub_slope: [0, 1].map(|i| gains.hub[i].slope * object),
            hub_rise,
            hub_fall: [0, 1].map(|i| hub_rise[i] * HEAVY * actuation.hub_inertia[i]),
            hub_reach: [0, 1].map(|i| gains.hub[i].reach * rate(i)),
            hub_strain: [0, 1].map(|i| gains.hub[i].strain / rate(i)),
            hub_pull: [0, 1].map(|i| gains.hub[i].reach * rate(i) * gains.hub[i].slope * object),
            hub_damping: [0, 1].map(|i| {
                let hub = &gains.hub[i];
                (hub.reach + hub.strain.recip()) * rate(i) + hub.feedforward * hub.slope * object
            }),
            slope,
            reach,
            damping: reach + gains.object.feedforward * slope,
            bend: if share < STRAIGHT { 0.0 } else { bend },
            strain_rate_bandwidth: if bandwidth < SLOWEST { 0.0 } else { bandwidth },
            strain: gains.object.strain * tip.sqrt(),
            inverse_strain: (gains.object.strain * tip.sqrt()).recip(),
        }
    }
}
