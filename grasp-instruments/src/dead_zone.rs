//! The inverse D⁺ of a dead zone, with which (18) comes about: D(sat(D⁺(ς))) is a clip.

use serde::{Deserialize, Serialize};

use crate::setting::{SettingError, check_range};

/// Ends and slopes of the dead zone D that an inverse believes in: `D(v) = k_r (v − m_r)` above `m_r`, `k_l (v − m_l)` below `m_l`,
/// 0 between.
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
    /// Admissible ends, right and left, and slopes.
    pub const RANGES: [(f64, f64); 3] = [(0.0, 1e6), (-1e6, 0.0), (1e-6, 1e6)];

    /// Checks the numbers of the channel of that number, 1 for torques and 2 for the force.
    ///
    /// # Errors
    /// The first that cannot be used.
    pub fn check(&self, channel: usize) -> Result<(), SettingError> {
        let [right, left, slope] = Self::RANGES;
        let Self { m_r, m_l, k_r, k_l } = *self;
        for (name, value, range) in [("m_r", m_r, right), ("m_l", m_l, left), ("k_r", k_r, slope), ("k_l", k_l, slope)]
        {
            check_range(&format!("{name}{channel}"), value, range)?;
        }
        Ok(())
    }

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

    /// Derivative of [`inverse`](Self::inverse); at its jump, where there is none, 0.
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
