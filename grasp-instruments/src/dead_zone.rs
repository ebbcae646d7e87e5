//! The inverse D⁺ of a dead zone, with which (18) comes about: D(sat(D⁺(ς))) is a clip.

use parameter_table::{Owner, Parameter, Range, parameter};
use serde::{Deserialize, Serialize};

const SLOPE: Range = Range::new(1e-6, 1e6);

/// Ends and slopes of the dead zone D that an inverse assumes: `D(v) = k_r (v − m_r)` above `m_r`, `k_l (v − m_l)` below
/// `m_l`, 0 between.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeadZone {
    /// Right end `m_r` \[unit of the command\], ≥ 0.
    pub m_r: f64,
    /// Left end `m_l` \[unit of the command\], ≤ 0.
    pub m_l: f64,
    /// Slope `k_r` at the right, > 0.
    pub k_r: f64,
    /// Slope `k_l` at the left, > 0.
    pub k_l: f64,
}

impl DeadZone {
    /// The torque channel of Section IV.
    pub const TORQUE: Self = Self { m_r: 0.1, m_l: -0.1, k_r: 1.0, k_l: 1.0 };
    /// The force channel of Section IV.
    pub const FORCE: Self = Self { m_r: 0.01, m_l: -0.01, k_r: 1.0, k_l: 1.0 };
    /// The channels that have one, with the numbers that the plant's have: torques and the force.
    pub const CHANNELS: [Owner<'static>; 2] =
        [Owner { name: "1", unit: "N.m", called: "torques" }, Owner { name: "2", unit: "N", called: "the force" }];
    /// Ends and slopes of a channel's.
    pub const PARAMETERS: [Parameter<Self>; 4] = [
        parameter!(
            "m_r{}",
            "{}",
            Range::new(0.0, 1e6),
            "Right end of the dead zone that the inverse for {} assumes",
            m_r
        ),
        parameter!(
            "m_l{}",
            "{}",
            Range::new(-1e6, 0.0),
            "Left end of the dead zone that the inverse for {} assumes",
            m_l
        ),
        parameter!("k_r{}", "1", SLOPE, "Slope at the right of the dead zone that the inverse for {} assumes", k_r),
        parameter!("k_l{}", "1", SLOPE, "Slope at the left of the dead zone that the inverse for {} assumes", k_l),
    ];

    /// D⁺: the command for which D puts out `wanted`.
    #[must_use]
    pub fn inverse(&self, wanted: f64) -> f64 {
        if wanted > 0.0 {
            wanted / self.k_r + self.m_r
        } else if wanted < 0.0 {
            wanted / self.k_l + self.m_l
        } else {
            0.0
        }
    }

    /// Derivative of [`inverse`](Self::inverse); 0 at its jump, where no derivative exists.
    #[must_use]
    pub fn inverse_slope(&self, wanted: f64) -> f64 {
        if wanted > 0.0 {
            1.0 / self.k_r
        } else if wanted < 0.0 {
            1.0 / self.k_l
        } else {
            0.0
        }
    }

    /// Limit of [`inverse`](Self::inverse) at 0, from above or below.
    pub(crate) fn beside_zero(&self, above: bool) -> f64 {
        if above { self.m_r } else { self.m_l }
    }
}
