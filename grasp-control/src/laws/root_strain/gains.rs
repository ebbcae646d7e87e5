//! Gains of the root-strain law, and what they achieve with the paper's arms.

use super::mass::MassGains;
use super::networks::{Learner, NetworkGains};
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
    /// What learns the disturbances.
    pub learner: Learner,
    /// Gains of the networks, where they learn.
    pub networks: NetworkGains,
    /// Bandwidth of the low-pass on the measured rates of moments and shears \[rad/s\]; 0 = off.
    pub strain_rate_bandwidth: f64,
}

impl RootStrainGains {
    /// The preset *fast*: forces, angles and position within 2 % after 0.11 s, undisturbed or not. `dualarm tune` found it over the
    /// cases with the paper's arms and object (`scenarios/tuned/nabfc-r-fast.toml`). Heavy objects and long arms overshoot.
    #[must_use]
    pub fn fast() -> Self {
        let hub = HubGains { slope: 147.0, reach: 22.78, strain: 7.109, feedforward: 0.4524, observer: 125.4 };
        Self {
            object: ObjectGains {
                slope: 117.5,
                reach: 29.01,
                strain: 5.201,
                feedforward: 0.2193,
                brake: 50.04,
                observer: 53.87,
            },
            hub: [hub; 2],
            strain_rate_bandwidth: 482.4,
            ..Self::default()
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
            ..default
        }
    }
}

impl Default for RootStrainGains {
    /// What `dualarm tune` found over all cases (`scenarios/tuned/nabfc-r.toml`): heavy and light objects, long and short, stiff
    /// and soft arms, lasting disturbances, noise, encoders and delays at 1 kHz.
    ///
    /// The slope is steep and `brake` large: in the whole range of a grasp the object's surface is the curve
    /// ṗ = −√(2 q `u_limit` |p|/m̂) on which a constant force brings it to rest at the target, the shares of damping that
    /// the arms have included.
    fn default() -> Self {
        let hub = HubGains { slope: 14.79, reach: 10.03, strain: 127.9, feedforward: 0.3829, observer: 153.0 };
        Self {
            object: ObjectGains {
                slope: 416.3,
                reach: 8.508,
                strain: 24.42,
                feedforward: 0.1573,
                brake: 34.78,
                observer: 56.85,
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
            learner: Learner::Observer,
            networks: NetworkGains { leakage: 0.02, robust: 0.1 },
            strain_rate_bandwidth: 125.5,
        }
    }
}
