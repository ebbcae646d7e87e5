//! Everything that defines a plant, with the paper's values (Section IV) as defaults.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Smallest and largest admissible polynomial degree of the moment field.
pub const ORDER_RANGE: std::ops::RangeInclusive<usize> = 4..=24;

/// Smallest admissible value of a parameter that must be positive (in its SI unit).
pub const SMALLEST: f64 = 1e-9;

/// Largest admissible magnitude of any parameter (in its SI unit).
pub const LARGEST: f64 = 1e9;

/// One arm: a uniform Euler–Bernoulli beam clamped to a motor hub, with a point mass at its tip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arm {
    /// Flexural rigidity EI \[N·m²\], in `SMALLEST ..= LARGEST`. FMI name `EI1`/`EI2`.
    pub ei: f64,
    /// Mass per length ρ \[kg/m\], in `SMALLEST ..= LARGEST`. FMI name `rho1`/`rho2`.
    pub rho: f64,
    /// Hub inertia J \[kg·m²\], in `SMALLEST ..= LARGEST`. FMI name `J1`/`J2`.
    pub hub_inertia: f64,
    /// Tip mass m \[kg\], in `SMALLEST ..= LARGEST`. FMI name `m1`/`m2`.
    pub tip_mass: f64,
}

impl Default for Arm {
    fn default() -> Self {
        Self { ei: 0.115, rho: 0.054, hub_inertia: 0.0073, tip_mass: 0.1 }
    }
}

/// Saturation and dead zone of one kind of actuator, the constants of (18).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Upper saturation level `k_M`, above `m_r`.
    pub k_max: f64,
    /// Lower saturation level `k_m`, below `m_l`.
    pub k_min: f64,
    /// Right end of the dead zone `m_r` ≥ 0.
    pub m_r: f64,
    /// Left end of the dead zone `m_l` ≤ 0.
    pub m_l: f64,
    /// Slope `k_r` > 0 right of the dead zone.
    pub k_r: f64,
    /// Slope `k_l` > 0 left of the dead zone. (The paper once calls a slope negative; it must be positive.)
    pub k_l: f64,
}

impl Channel {
    /// The hub motors of Section IV: |τ| ≤ 2 N·m behind a dead zone of ±0.1 N·m. FMI names end in `1`.
    pub const TORQUE: Self = Self { k_max: 2.1, k_min: -2.1, m_r: 0.1, m_l: -0.1, k_r: 1.0, k_l: 1.0 };
    /// The object's actuator of Section IV: |u| ≤ 0.3 N behind a dead zone of ±0.01 N. FMI names end in `2`.
    pub const FORCE: Self = Self { k_max: 0.31, k_min: -0.31, m_r: 0.01, m_l: -0.01, k_r: 1.0, k_l: 1.0 };
}

/// How a command becomes an actuator output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ActuatorModel {
    /// The output equals the command, without limits.
    Ideal,
    /// Eq. (18): the dead zone is compensated by its inverse, so only a clip to
    /// `[k_l (k_m − m_l), k_r (k_M − m_r)]` remains.
    #[default]
    Compensated,
    /// The bare actuator D(sat(·)): saturation to `[k_m, k_M]`, then the dead zone with its slopes.
    Raw,
}

/// Start values. Any are consistent: the deflections start as the static cubics of (16) scaled to satisfy (12), and their
/// rates as the same cubics scaled to satisfy its time derivative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Hub angles θ_i(0) \[rad\].
    pub theta: [f64; 2],
    /// Hub angular velocities θ̇_i(0) \[rad/s\].
    pub theta_dot: [f64; 2],
    /// Object position `y_M(0)` \[m\].
    pub y_object: f64,
    /// Object velocity `ẏ_M(0)` \[m/s\].
    pub y_object_dot: f64,
}

impl Default for Start {
    fn default() -> Self {
        Self { theta: [0.0; 2], theta_dot: [0.0; 2], y_object: 0.05, y_object_dot: 0.0 }
    }
}

/// All parameters of the plant. [`Default`] gives the paper's grasp (Section IV).
///
/// ```
/// use grasp_plant::Parameters;
/// let mut parameters = Parameters::default();
/// assert!(parameters.validate().is_ok());
/// parameters.arms[1].ei = -0.1;
/// let error = parameters.validate().unwrap_err();
/// assert_eq!(error.name, "EI2");
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// The two arms.
    pub arms: [Arm; 2],
    /// Length l of both arms \[m\], in `SMALLEST ..= LARGEST`. FMI name `l`.
    pub length: f64,
    /// Width L of the object \[m\], in `SMALLEST ..= LARGEST`. FMI name `L`.
    pub object_width: f64,
    /// Mass M of the object \[kg\], in `SMALLEST ..= LARGEST`. FMI name `M`.
    pub object_mass: f64,
    /// `c_f` \[s\] ≥ 0 of the built-in uncertainty Δf_i = −`c_f` d/dt(EI_i w_i''(0)). FMI name `root_uncertainty`.
    pub root_uncertainty: f64,
    /// `c_F` \[s\] ≥ 0 of ΔF = −`c_F` (EI_1+EI_2)(ẇ_1'''(l)+ẇ_2'''(l)). FMI name `tip_uncertainty`.
    pub tip_uncertainty: f64,
    /// Kelvin–Voigt coefficient κ \[s\] ≥ 0: the beams transmit the moment EI(w'' + κẇ''). FMI name `kelvin_voigt`.
    pub kelvin_voigt: f64,
    /// Channel of both hub motors.
    pub torque_channel: Channel,
    /// Channel of the object's actuator.
    pub force_channel: Channel,
    /// Which actuator model turns commands into forces. FMI name `actuator_model`.
    pub actuator_model: ActuatorModel,
    /// Polynomial degree k of the moment field, in [`ORDER_RANGE`]. FMI name `order`.
    pub order: usize,
    /// Start values.
    pub start: Start,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            arms: [Arm::default(); 2],
            length: 0.2,
            object_width: 0.1,
            object_mass: 0.3,
            root_uncertainty: 0.1,
            tip_uncertainty: 0.05,
            kelvin_voigt: 0.0,
            torque_channel: Channel::TORQUE,
            force_channel: Channel::FORCE,
            actuator_model: ActuatorModel::default(),
            order: 8,
            start: Start::default(),
        }
    }
}

impl Parameters {
    /// Everything that moves with the object, m = m_1 + m_2 + M \[kg\].
    #[must_use]
    pub fn moving_mass(&self) -> f64 {
        self.arms[0].tip_mass + self.arms[1].tip_mass + self.object_mass
    }

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter found outside its range, by its FMI name.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        const ARM_NAMES: [[&str; 4]; 2] = [["EI1", "rho1", "J1", "m1"], ["EI2", "rho2", "J2", "m2"]];
        for (arm, names) in self.arms.iter().zip(ARM_NAMES) {
            positive(names[0], arm.ei)?;
            positive(names[1], arm.rho)?;
            positive(names[2], arm.hub_inertia)?;
            positive(names[3], arm.tip_mass)?;
        }
        positive("l", self.length)?;
        positive("L", self.object_width)?;
        positive("M", self.object_mass)?;
        non_negative("root_uncertainty", self.root_uncertainty)?;
        non_negative("tip_uncertainty", self.tip_uncertainty)?;
        non_negative("kelvin_voigt", self.kelvin_voigt)?;
        self.torque_channel.validate(["k_M1", "k_m1", "m_r1", "m_l1", "k_r1", "k_l1"])?;
        self.force_channel.validate(["k_M2", "k_m2", "m_r2", "m_l2", "k_r2", "k_l2"])?;
        if !ORDER_RANGE.contains(&self.order) {
            return Err(InvalidParameter {
                name: "order",
                value: self.order as f64,
                admissible: Admissible::Between(*ORDER_RANGE.start() as f64, *ORDER_RANGE.end() as f64),
            });
        }
        bounded("theta1_0", self.start.theta[0])?;
        bounded("theta2_0", self.start.theta[1])?;
        bounded("theta1_dot_0", self.start.theta_dot[0])?;
        bounded("theta2_dot_0", self.start.theta_dot[1])?;
        bounded("y_object_0", self.start.y_object)?;
        bounded("y_object_dot_0", self.start.y_object_dot)
    }
}

impl Channel {
    fn validate(&self, names: [&'static str; 6]) -> Result<(), InvalidParameter> {
        let [k_max, k_min, m_r, m_l, k_r, k_l] = names;
        non_negative(m_r, self.m_r)?;
        require(m_l, self.m_l, Admissible::Between(-LARGEST, 0.0))?;
        require(k_max, self.k_max, Admissible::Above(m_r, self.m_r))?;
        require(k_min, self.k_min, Admissible::Below(m_l, self.m_l))?;
        positive(k_r, self.k_r)?;
        positive(k_l, self.k_l)
    }
}

/// A parameter outside its admissible range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("parameter {name} = {value} is not admissible: it must be {admissible}")]
pub struct InvalidParameter {
    /// The parameter's name in the FMI interface.
    pub name: &'static str,
    /// The refused value.
    pub value: f64,
    /// What would have been admissible.
    pub admissible: Admissible,
}

/// The values a parameter may take. Every one must also be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Admissible {
    /// Within both bounds, which belong to the range.
    Between(f64, f64),
    /// Greater than another parameter (its name and value), up to [`LARGEST`].
    Above(&'static str, f64),
    /// Less than another parameter (its name and value), down to −[`LARGEST`].
    Below(&'static str, f64),
}

impl Admissible {
    fn contains(self, value: f64) -> bool {
        match self {
            Self::Between(low, high) => (low..=high).contains(&value),
            Self::Above(_, limit) => value > limit && value <= LARGEST,
            Self::Below(_, limit) => value < limit && value >= -LARGEST,
        }
    }
}

impl fmt::Display for Admissible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Between(low, high) => write!(f, "between {low:?} and {high:?}"),
            Self::Above(name, limit) => write!(f, "greater than {name} = {limit:?} and at most {LARGEST:?}"),
            Self::Below(name, limit) => write!(f, "less than {name} = {limit:?} and at least {:?}", -LARGEST),
        }
    }
}

fn require(name: &'static str, value: f64, admissible: Admissible) -> Result<(), InvalidParameter> {
    if admissible.contains(value) { Ok(()) } else { Err(InvalidParameter { name, value, admissible }) }
}

fn positive(name: &'static str, value: f64) -> Result<(), InvalidParameter> {
    require(name, value, Admissible::Between(SMALLEST, LARGEST))
}

fn non_negative(name: &'static str, value: f64) -> Result<(), InvalidParameter> {
    require(name, value, Admissible::Between(0.0, LARGEST))
}

fn bounded(name: &'static str, value: f64) -> Result<(), InvalidParameter> {
    require(name, value, Admissible::Between(-LARGEST, LARGEST))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each assignment of an inadmissible value, with the name the error must carry.
    #[test]
    fn every_parameter_is_checked_by_name() {
        type Spoil = fn(&mut Parameters, f64);
        let spoilers: [(&str, Spoil, &[f64]); 32] = [
            ("EI1", |p, v| p.arms[0].ei = v, &[0.0, -1.0]),
            ("EI2", |p, v| p.arms[1].ei = v, &[0.0, -1.0]),
            ("rho1", |p, v| p.arms[0].rho = v, &[0.0, -1.0]),
            ("rho2", |p, v| p.arms[1].rho = v, &[0.0, -1.0]),
            ("J1", |p, v| p.arms[0].hub_inertia = v, &[0.0, -1.0]),
            ("J2", |p, v| p.arms[1].hub_inertia = v, &[0.0, -1.0]),
            ("m1", |p, v| p.arms[0].tip_mass = v, &[0.0, -1.0]),
            ("m2", |p, v| p.arms[1].tip_mass = v, &[0.0, -1.0]),
            ("l", |p, v| p.length = v, &[0.0, -1.0]),
            ("L", |p, v| p.object_width = v, &[0.0, -1.0]),
            ("M", |p, v| p.object_mass = v, &[0.0, -1.0]),
            ("root_uncertainty", |p, v| p.root_uncertainty = v, &[-1e-3]),
            ("tip_uncertainty", |p, v| p.tip_uncertainty = v, &[-1e-3]),
            ("kelvin_voigt", |p, v| p.kelvin_voigt = v, &[-1e-3]),
            ("k_M1", |p, v| p.torque_channel.k_max = v, &[0.1, -1.0]),
            ("k_m1", |p, v| p.torque_channel.k_min = v, &[-0.1, 1.0]),
            ("m_r1", |p, v| p.torque_channel.m_r = v, &[-0.1]),
            ("m_l1", |p, v| p.torque_channel.m_l = v, &[0.1]),
            ("k_r1", |p, v| p.torque_channel.k_r = v, &[0.0, -1.0]),
            ("k_l1", |p, v| p.torque_channel.k_l = v, &[0.0, -1.0]),
            ("k_M2", |p, v| p.force_channel.k_max = v, &[0.01, -1.0]),
            ("k_m2", |p, v| p.force_channel.k_min = v, &[-0.01, 1.0]),
            ("m_r2", |p, v| p.force_channel.m_r = v, &[-0.1]),
            ("m_l2", |p, v| p.force_channel.m_l = v, &[0.1]),
            ("k_r2", |p, v| p.force_channel.k_r = v, &[0.0, -1.0]),
            ("k_l2", |p, v| p.force_channel.k_l = v, &[0.0, -1.0]),
            ("theta1_0", |p, v| p.start.theta[0] = v, &[]),
            ("theta2_0", |p, v| p.start.theta[1] = v, &[]),
            ("theta1_dot_0", |p, v| p.start.theta_dot[0] = v, &[]),
            ("theta2_dot_0", |p, v| p.start.theta_dot[1] = v, &[]),
            ("y_object_0", |p, v| p.start.y_object = v, &[]),
            ("y_object_dot_0", |p, v| p.start.y_object_dot = v, &[]),
        ];
        for (name, spoil, values) in spoilers {
            let never = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0 * LARGEST];
            for value in values.iter().chain(&never) {
                let mut parameters = Parameters::default();
                spoil(&mut parameters, *value);
                let error = parameters.validate().expect_err(name);
                assert_eq!(error.name, name);
                assert_eq!(error.value.to_bits(), value.to_bits());
            }
        }
        for order in [0, 3, 25, usize::MAX] {
            let error = Parameters { order, ..Parameters::default() }.validate().unwrap_err();
            assert_eq!(error.name, "order");
        }
    }

    #[test]
    fn the_message_says_what_is_wrong_and_what_would_be_right() {
        let mut parameters = Parameters::default();
        parameters.torque_channel.k_max = 0.05;
        assert_eq!(
            parameters.validate().unwrap_err().to_string(),
            "parameter k_M1 = 0.05 is not admissible: it must be greater than m_r1 = 0.1 and at most 1000000000.0"
        );
    }
}
