//! Gains of the root-strain law, and what they achieve with the paper's arms.

use super::inertia::{FilterGains, InertiaGains, MassGains, Prior};
use super::natural::Compliance;
use super::networks::{Learner, NetworkGains};
use crate::laws::encoders::Actuation;
use crate::target::Arms;
use serde::{Deserialize, Serialize};

/// Gains of the object's loop. Slope, reach and strain are in units of the natural rate of the object between the arms
/// ([`Scaled`](super::Scaled)), so the gains carry over to other arms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObjectGains {
    /// Slope G of the surface near the target.
    pub slope: f64,
    /// Rate k at which the surface is reached.
    pub reach: f64,
    /// Share κ of the tip shears in the surface.
    pub strain: f64,
    /// Share of m̂ that is fed forward, 0 to 1. At 1 a shear's rate is fed back with the gain that no sampled loop bears.
    pub feedforward: f64,
    /// Where the surface bends: share q of `u_limit` with which the object is braked; 0 = straight.
    pub brake: f64,
    /// Poles of the observer \[rad/s\].
    pub observer: f64,
}

/// Gains of one hub's loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HubGains {
    /// Slope Gᵢ of the surface in units of the natural rate of the object between the arms.
    pub slope: f64,
    /// Rate kᵢ at which the surface is reached in units of the natural rate of the hub on its arm.
    pub reach: f64,
    /// Time cᵢ by which M̃ᵢ/Ĵᵢ, the acceleration that the arm's bending gives the hub, becomes a rate in the surface, times the
    /// hub's natural rate.
    pub strain: f64,
    /// Share of the hub's inertia that is fed forward, 0 to 1.
    pub feedforward: f64,
    /// Poles of the observer \[rad/s\].
    pub observer: f64,
}

/// All gains of the root-strain law; index 0 of an array is arm 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RootStrainGains {
    /// Object's loop.
    pub object: ObjectGains,
    /// Hubs' loops.
    pub hub: [HubGains; 2],
    /// Estimate of the mass.
    pub mass: MassGains,
    /// Estimates of the hubs' inertias.
    pub inertia: InertiaGains,
    /// Filters of all estimates.
    pub filter: FilterGains,
    /// What learns the disturbances.
    pub learner: Learner,
    /// Gains of the networks, where they learn.
    pub networks: NetworkGains,
    /// Bandwidth of the low-pass on the root moments in the surfaces \[rad/s\]; 0 = off.
    pub strain_bandwidth: f64,
    /// Bandwidth of the low-pass on the rates of moments and shears in units of the hubs' natural rate; 0 = off.
    /// With it they come from moments and shears themselves, without it they are the measured ones.
    pub strain_rate_bandwidth: f64,
}

impl RootStrainGains {
    /// What the estimators of hub 1, hub 2 and object are told.
    pub(super) fn priors(&self, arms: &Arms, actuation: &Actuation) -> [Prior; 3] {
        let hub = |i: usize| {
            let (g, initial) = (&self.inertia, actuation.hub_inertia[i]);
            let (smallest, largest) = (g.smallest * initial, g.largest * initial);
            let InertiaGains { threshold, prior: weight, memory, .. } = *g;
            let stiffness = 3.0 * arms.ei[i] / arms.length;
            Prior { initial, smallest, largest, threshold, weight, memory, stiffness }
        };
        let MassGains { initial, smallest, largest, threshold, prior: weight, memory } = self.mass;
        let stiffness = Compliance::of(arms).tip.recip();
        [hub(0), hub(1), Prior { initial, smallest, largest, threshold, weight, memory, stiffness }]
    }

    /// The preset *fast*: forces, angles and position within 2 % after 0.11 s, undisturbed or not. `dualarm tune` found it over the
    /// cases with the paper's arms and object (`scenarios/tuned/nabfc-r-fast.toml`). Heavy objects and long arms overshoot.
    #[must_use]
    pub fn fast() -> Self {
        let hub = HubGains { slope: 15.98, reach: 0.7341, strain: 0.3869, feedforward: 0.2013, observer: 181.5 };
        let default = Self::default();
        Self {
            object: ObjectGains {
                slope: 8.679,
                reach: 2.04,
                strain: 0.3544,
                feedforward: 0.2297,
                brake: 18.31,
                observer: 88.36,
            },
            hub: [hub; 2],
            strain_bandwidth: 0.0,
            strain_rate_bandwidth: 18.62,
            ..default
        }
    }

    /// The preset *certified*: everything that the law does with it, but for limits and sampling, is inside a proof of
    /// exponential decay (`docs/certificates.md`). So loads' rates are not filtered, the object's surface is straight, and
    /// m̂ stays where it is.
    #[must_use]
    pub fn certified() -> Self {
        // Natural rates of the paper's hubs and object: √(3·0.115/(0.2·0.0073)) and √(6·0.115/0.2³/0.5).
        let (hub, object) = (15.372_097_119_879_697, 13.133_925_536_563_698);
        // The share in the surface was 95 1/s of the angle that a moment bends the arm by, l/3EI.
        let strain = 95.0 * 0.2 / 0.345 * 0.0073 * hub;
        let hub = HubGains { slope: 20.0 / object, reach: 20.0 / hub, strain, feedforward: 0.4, observer: 60.0 };
        let default = Self::default();
        Self {
            object: ObjectGains {
                slope: 25.0 / object,
                reach: 25.0 / object,
                strain: 20.0 / object,
                feedforward: 0.2,
                brake: 0.0,
                observer: 40.0,
            },
            hub: [hub; 2],
            mass: MassGains { initial: 0.5, smallest: 0.5, largest: 0.5, ..default.mass },
            inertia: InertiaGains { smallest: 1.0, largest: 1.0, ..default.inertia },
            strain_bandwidth: 0.0,
            strain_rate_bandwidth: 0.0,
            ..default
        }
    }
}

impl Default for RootStrainGains {
    /// What a search over all cases and a little work by hand found (`scenarios/tuned/nabfc-r.toml`): heavy and light objects, long and short, stiff
    /// and soft arms, lasting disturbances, noise, encoders and delays at 1 kHz.
    ///
    /// The slope is steep: but for the last millimetre the object follows the curve ṗ = −√(2 q `u_limit` |p|/m̂) on which a constant force
    /// brings it to rest at the target.
    fn default() -> Self {
        let hub = HubGains { slope: 0.615, reach: 1.546, strain: 3.382, feedforward: 0.6493, observer: 100.8 };
        Self {
            object: ObjectGains {
                slope: 25.62,
                reach: 0.4409,
                strain: 1.323,
                feedforward: 0.1606,
                brake: 0.62,
                observer: 88.08,
            },
            hub: [hub; 2],
            mass: MassGains { initial: 0.5, smallest: 0.25, largest: 20.0, threshold: 0.02, prior: 2e-4, memory: 0.05 },
            inertia: InertiaGains { smallest: 0.5, largest: 20.0, threshold: 0.2, prior: 3e-4, memory: 0.1 },
            filter: FilterGains { bandwidth: 150.0, high_pass: 3.0 },
            learner: Learner::Observer,
            networks: NetworkGains { leakage: 0.02, robust: 0.1 },
            strain_bandwidth: 302.5,
            strain_rate_bandwidth: 3.877,
        }
    }
}
