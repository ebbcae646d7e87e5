//! Everything that defines a plant, with the paper's values (Section IV) as defaults.

mod table;

use serde::{Deserialize, Serialize};

/// Smallest and largest admissible polynomial degree of the moment field.
pub const ORDER_RANGE: std::ops::RangeInclusive<usize> = 4..=24;

/// One arm: a uniform Euler–Bernoulli beam clamped to a motor hub, with a point mass at its tip. Names, units and ranges:
/// [`Arm::PARAMETERS`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arm {
    /// Flexural rigidity EI \[N·m²\].
    pub ei: f64,
    /// Mass per length ρ \[kg/m\].
    pub rho: f64,
    /// Hub inertia J \[kg·m²\].
    pub hub_inertia: f64,
    /// Tip mass m \[kg\].
    pub tip_mass: f64,
}

impl Default for Arm {
    fn default() -> Self {
        Self { ei: 0.115, rho: 0.054, hub_inertia: 0.0073, tip_mass: 0.1 }
    }
}

/// Saturation and dead zone of one kind of actuator, the constants of (18): levels and dead zone in the unit of the
/// command, dimensionless slopes. Names and ranges: [`Channel::TORQUE_PARAMETERS`], [`Channel::FORCE_PARAMETERS`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Upper saturation level `k_M`, above `m_r`.
    pub k_max: f64,
    /// Lower saturation level `k_m`, below `m_l`.
    pub k_min: f64,
    /// Right end of the dead zone `m_r`.
    pub m_r: f64,
    /// Left end of the dead zone `m_l`.
    pub m_l: f64,
    /// Slope `k_r` right of the dead zone.
    pub k_r: f64,
    /// Slope `k_l` left of the dead zone. (The paper once calls a slope negative; it must be positive.)
    pub k_l: f64,
}

impl Channel {
    /// The hub motors of Section IV: |τ| ≤ 2 N·m behind a dead zone of ±0.1 N·m.
    pub const TORQUE: Self = Self { k_max: 2.1, k_min: -2.1, m_r: 0.1, m_l: -0.1, k_r: 1.0, k_l: 1.0 };
    /// The object's actuator of Section IV: |u| ≤ 0.3 N behind a dead zone of ±0.01 N.
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

/// How the tips and the object interact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactModel {
    /// The constraint (12), whatever the sign of the contact force: the paper's grasp.
    #[default]
    Bilateral,
    /// Rigid faces that push and do not pull: a tip leaves the object when the force on it would become tensile, and every
    /// new contact is an impact.
    Unilateral,
    /// Kelvin–Voigt faces that push and do not pull: a soft or fragile object.
    Compliant,
}

/// One face of a compliant object: a spring and a damper side by side, without mass. Names, units and ranges:
/// [`Face::PARAMETERS`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Face {
    /// Stiffness k \[N/m\].
    pub stiffness: f64,
    /// Damping c \[N·s/m\].
    pub damping: f64,
}

impl Default for Face {
    fn default() -> Self {
        Self { stiffness: 1000.0, damping: 10.0 }
    }
}

/// Start values. Every choice is consistent: the deflections start as the static cubics of (16) scaled to satisfy (12), and
/// their rates as the same cubics scaled to satisfy its time derivative. If the grasp can open, an arm that does not reach
/// the object starts straight, with a gap. Names: [`Start::ANGLES`], [`Start::OBJECT`].
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

/// All parameters of the plant. [`Default`] gives the paper's grasp (Section IV). Names, units and ranges:
/// [`Parameters::COMMON`] and the tables of the parts.
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
    /// Length l of both arms \[m\].
    pub length: f64,
    /// Width L of the object \[m\].
    pub object_width: f64,
    /// Mass M of the object \[kg\].
    pub object_mass: f64,
    /// `c_f` \[s\] of the built-in uncertainty Δf_i = −`c_f` d/dt(EI_i w_i''(0)).
    pub root_uncertainty: f64,
    /// `c_F` \[s\] of ΔF = −`c_F` (EI_1+EI_2)(ẇ_1'''(l)+ẇ_2'''(l)).
    pub tip_uncertainty: f64,
    /// Kelvin–Voigt coefficient κ \[s\]: the beams transmit the moment EI(w'' + κẇ'').
    pub kelvin_voigt: f64,
    /// Channel of both hub motors.
    pub torque_channel: Channel,
    /// Channel of the object's actuator.
    pub force_channel: Channel,
    /// Which actuator model turns commands into forces.
    pub actuator_model: ActuatorModel,
    /// How the tips and the object interact.
    pub contact_model: ContactModel,
    /// The object's faces, if compliant.
    pub faces: [Face; 2],
    /// Newton's coefficient of restitution e of impacts on rigid faces: the gap opens with e times its closing speed.
    pub restitution: f64,
    /// Impacts slower than this are plastic whatever the restitution \[m/s\], so that accumulating bounces end in contact.
    pub plastic_speed: f64,
    /// Polynomial degree k of the moment field, in [`ORDER_RANGE`].
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
            contact_model: ContactModel::default(),
            faces: [Face::default(); 2],
            restitution: 0.0,
            plastic_speed: 1e-6,
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
}
