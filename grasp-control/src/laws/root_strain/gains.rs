//! Gains of the root-strain law, and what they achieve with the paper's arms.

use super::mass::MassGains;
use serde::{Deserialize, Serialize};

/// Gains of the object's loop. Everything is a rate or a pure number, so the gains carry over to other arms and objects.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObjectGains {
    /// Slope G of the surface near the target \[1/s\].
    pub slope: f64,
    /// Rate k at which the surface is reached \[1/s\].
    pub reach: f64,
    /// Share κ of the tip shears in the surface \[1/s\].
    pub strain: f64,
    /// Share of m̂ that is fed forward, 0 to 1. At 1 a shear's rate is fed back with the gain that no sampled loop bears.
    pub feedforward: f64,
    /// Where the surface bends: share q of the acceleration that `u_limit` gives.
    pub brake: f64,
    /// Poles of the observer \[rad/s\].
    pub observer: f64,
}

/// Gains of one hub's loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HubGains {
    /// Slope Gᵢ of the surface \[1/s\].
    pub slope: f64,
    /// Rate kᵢ at which the surface is reached \[1/s\].
    pub reach: f64,
    /// Share σᵢ of the root strain in the surface \[1/s\].
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
    /// Bandwidth of the low-pass on the measured rates of moments and shears \[rad/s\]; 0 = off.
    pub strain_rate_bandwidth: f64,
}

impl RootStrainGains {
    /// The preset *fast*: forces, angles and position within 2 % after 0.11 s, found like the default but for the paper's
    /// plant alone, with disturbances, noise and delay. Heavy objects and long arms overshoot.
    #[must_use]
    pub fn fast() -> Self {
        let hub = HubGains { slope: 49.6, reach: 72.7, strain: 5.0, feedforward: 0.52, observer: 117.0 };
        let default = Self::default();
        Self {
            object: ObjectGains {
                slope: 90.6,
                reach: 27.0,
                strain: 9.8,
                feedforward: 0.29,
                brake: 16.6,
                observer: 48.8,
            },
            hub: [hub; 2],
            mass: MassGains { prior: 3e-4, ..default.mass },
            strain_rate_bandwidth: 510.0,
        }
    }

    /// The preset *certified*: everything that the law does with it, but for limits and sampling, is inside a proof of
    /// exponential decay (`docs/certificates.md`). So loads' rates are not filtered, the object's surface is straight, and
    /// m̂ stays where it is.
    #[must_use]
    pub fn certified() -> Self {
        let hub = HubGains { slope: 20.0, reach: 20.0, strain: 95.0, feedforward: 0.4, observer: 60.0 };
        let default = Self::default();
        Self {
            object: ObjectGains {
                slope: 25.0,
                reach: 25.0,
                strain: 20.0,
                feedforward: 0.2,
                brake: 1e6,
                observer: 40.0,
            },
            hub: [hub; 2],
            mass: MassGains { initial: 0.5, smallest: 0.5, largest: 0.5, ..default.mass },
            strain_rate_bandwidth: 0.0,
        }
    }
}

impl Default for RootStrainGains {
    /// Found by CMA-ES over heavy and light objects, long and short, stiff and soft arms, lasting disturbances, noise and
    /// delays at 1 kHz, and rounded.
    ///
    /// The slope is steep and `brake` large: in the whole range of a grasp the object's surface is the curve
    /// ṗ = −√(2 q `u_limit` |p|/m̂) on which a constant force brings it to rest at the target, the shares of damping that
    /// the arms have included.
    fn default() -> Self {
        let hub = HubGains { slope: 12.4, reach: 9.0, strain: 95.0, feedforward: 0.39, observer: 240.0 };
        Self {
            object: ObjectGains {
                slope: 260.0,
                reach: 10.7,
                strain: 20.0,
                feedforward: 0.19,
                brake: 15.0,
                observer: 135.0,
            },
            hub: [hub; 2],
            mass: MassGains {
                initial: 0.5,
                smallest: 0.15,
                largest: 20.0,
                filter: 150.0,
                high_pass: 3.0,
                prior: 2e-4,
                memory: 0.05,
            },
            strain_rate_bandwidth: 160.0,
        }
    }
}
