//! Input constraints: the memoryless, piecewise linear maps from commands to forces.

use crate::parameters::{ActuatorModel, Channel};

/// One actuator: a continuous, non-decreasing, piecewise linear function of its command.
///
/// ```
/// use grasp_plant::{Actuator, ActuatorModel, Channel};
/// let motor = Actuator::new(ActuatorModel::Compensated, &Channel::TORQUE);
/// assert_eq!(motor.output(0.05), 0.05); // the dead zone is compensated
/// assert_eq!(motor.output(9.0), 2.0); // k_r (k_M − m_r)
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    model: ActuatorModel,
    channel: Channel,
    /// Commands at which the slope changes, ascending; only the first `kink_count` count.
    kinks: [f64; Self::MAX_KINKS],
    kink_count: usize,
    /// The outermost kinks, where the limits begin; an ideal actuator has none.
    limits: [f64; 2],
}

impl Actuator {
    /// The largest number of kinks an actuator has.
    pub const MAX_KINKS: usize = 4;

    /// The actuator of a model and a channel.
    #[must_use]
    pub fn new(model: ActuatorModel, channel: &Channel) -> Self {
        let c = channel;
        let mut kinks = [0.0; Self::MAX_KINKS];
        let kink_count = match model {
            ActuatorModel::Ideal => 0,
            ActuatorModel::Compensated => {
                kinks[..2].copy_from_slice(&[c.k_l * (c.k_min - c.m_l), c.k_r * (c.k_max - c.m_r)]);
                2
            }
            ActuatorModel::Raw => {
                kinks = [c.k_min, c.m_l, c.m_r, c.k_max];
                4
            }
        };
        let limits = match &kinks[..kink_count] {
            [low, .., high] => [*low, *high],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        };
        Self { model, channel: *channel, kinks, kink_count, limits }
    }

    /// The commands at which the slope changes, ascending.
    #[must_use]
    pub fn kinks(&self) -> &[f64] {
        &self.kinks[..self.kink_count]
    }

    /// Actuator output for a command: (18) for [`ActuatorModel::Compensated`], D(sat(·)) for [`ActuatorModel::Raw`].
    #[must_use]
    #[inline]
    pub fn output(&self, command: f64) -> f64 {
        let [low, high] = self.limits;
        let limited = limited(command, low, high);
        if self.model == ActuatorModel::Raw { self.behind_dead_zone(limited) } else { limited }
    }

    /// D(·) of a limited command.
    fn behind_dead_zone(&self, limited: f64) -> f64 {
        let c = &self.channel;
        if limited > c.m_r {
            c.k_r * (limited - c.m_r)
        } else if limited < c.m_l {
            c.k_l * (limited - c.m_l)
        } else {
            0.0
        }
    }

    /// Commands at which the limits begin; infinite if there are none.
    pub(crate) fn limits(&self) -> [f64; 2] {
        self.limits
    }

    /// Whether the output is at one of its limits, where it does not answer the command.
    #[must_use]
    #[inline]
    pub fn is_limited(&self, command: f64) -> bool {
        command <= self.limits[0] || command >= self.limits[1]
    }

    /// Derivative of the output with respect to the command. At a kink it is that of the flat side, because of the "≥" and
    /// "≤" in (18).
    #[must_use]
    pub fn slope(&self, command: f64) -> f64 {
        let c = &self.channel;
        match self.model {
            ActuatorModel::Ideal => 1.0,
            ActuatorModel::Compensated => f64::from(u8::from(command > self.kinks[0] && command < self.kinks[1])),
            ActuatorModel::Raw => {
                if command > c.m_r && command < c.k_max {
                    c.k_r
                } else if command < c.m_l && command > c.k_min {
                    c.k_l
                } else {
                    0.0
                }
            }
        }
    }
}

/// A command within limits. Not `clamp`, which would look at the limits too.
#[inline]
pub(crate) fn limited(command: f64, low: f64, high: f64) -> f64 {
    let limited = if command < low { low } else { command };
    if limited > high { high } else { limited }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn channel() -> impl Strategy<Value = Channel> {
        (0.0..1.0f64, 0.0..1.0f64, 0.01..3.0f64, 0.01..3.0f64, 0.1..5.0f64, 0.1..5.0f64).prop_map(
            |(m_r, m_l, up, down, k_r, k_l)| Channel { k_max: m_r + up, k_min: -m_l - down, m_r, m_l: -m_l, k_r, k_l },
        )
    }

    /// D⁺ of the paper's [27]: the command that makes a dead zone put out `wanted`.
    fn dead_zone_inverse(c: &Channel, wanted: f64) -> f64 {
        match wanted {
            w if w > 0.0 => w / c.k_r + c.m_r,
            w if w < 0.0 => w / c.k_l + c.m_l,
            _ => 0.0,
        }
    }

    proptest! {
        /// Lemma 5: Σ = D(sat(D⁺(ς))) is the clip (18).
        #[test]
        fn the_raw_actuator_behind_the_inverse_dead_zone_is_the_compensated_one(c in channel(), command in -20.0..20.0f64) {
            let raw = Actuator::new(ActuatorModel::Raw, &c);
            let compensated = Actuator::new(ActuatorModel::Compensated, &c);
            let output = raw.output(dead_zone_inverse(&c, command));
            prop_assert!((output - compensated.output(command)).abs() < 1e-13);
        }

        #[test]
        fn slopes_and_kinks_agree_with_the_output(
            c in channel(),
            model in prop_oneof![Just(ActuatorModel::Ideal), Just(ActuatorModel::Compensated), Just(ActuatorModel::Raw)],
            command in -20.0..20.0f64,
        ) {
            let actuator = Actuator::new(model, &c);
            prop_assert!(actuator.kinks().is_sorted());
            let delta = 1e-4;
            prop_assume!(actuator.kinks().iter().all(|kink| (kink - command).abs() > delta));
            let difference = (actuator.output(command + delta) - actuator.output(command - delta)) / (2.0 * delta);
            prop_assert!((difference - actuator.slope(command)).abs() < 1e-9);
        }
    }

    #[test]
    fn an_ideal_actuator_has_no_limits() {
        assert!(!Actuator::new(ActuatorModel::Ideal, &Channel::TORQUE).is_limited(1e9));
    }

    #[test]
    fn the_papers_channels_give_2_newton_metres_and_0_3_newtons() {
        for (channel, limit) in [(Channel::TORQUE, 2.0), (Channel::FORCE, 0.3)] {
            for model in [ActuatorModel::Compensated, ActuatorModel::Raw] {
                let actuator = Actuator::new(model, &channel);
                assert!((actuator.output(99.0) - limit).abs() < 1e-15);
                assert!((actuator.output(-99.0) + limit).abs() < 1e-15);
                assert!(actuator.is_limited(99.0) && actuator.is_limited(-99.0) && !actuator.is_limited(0.2));
            }
        }
    }
}
