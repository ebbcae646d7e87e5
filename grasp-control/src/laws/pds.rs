//! PD plus strain feedback, eqs. (95) and (96).

use super::GAIN;
use crate::law::{CommandJacobian, Law, StepError};
use crate::signals::{Commands, INPUTS, Inputs, column};
use crate::target::Arms;
use grasp_parameter::{InvalidParameter, Parameter, check, parameter};
use serde::{Deserialize, Serialize};

/// Gains of the PDS law; index 0 of an array is arm 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PdsGains {
    /// Object position gain `k̄ₚ` \[N/m\].
    pub kp: f64,
    /// Object velocity gain `k̄ᵥ` \[N·s/m\].
    pub kv: f64,
    /// Hub angle gains `k̄ₚᵢ` \[N·m/rad\].
    pub kp_arm: [f64; 2],
    /// Hub velocity gains `k̄ᵥᵢ` \[N·m·s/rad\].
    pub kv_arm: [f64; 2],
    /// Strain gains `k̄ₛᵢ` \[1\].
    pub ks_arm: [f64; 2],
}

impl Default for PdsGains {
    /// The values of Section IV, scenario II.
    fn default() -> Self {
        Self { kp: 40.0, kv: 35.0, kp_arm: [35.0; 2], kv_arm: [15.0; 2], ks_arm: [10.0; 2] }
    }
}

impl PdsGains {
    /// The parameters by their names in the interface.
    pub const PARAMETERS: [Parameter<Self>; 8] = [
        parameter!("kp", "N/m", GAIN, "Object position gain", kp),
        parameter!("kv", "N.s/m", GAIN, "Object velocity gain", kv),
        parameter!("kp1", "N.m/rad", GAIN, "Hub angle gain of arm 1", kp_arm[0]),
        parameter!("kv1", "N.m.s/rad", GAIN, "Hub velocity gain of arm 1", kv_arm[0]),
        parameter!("ks1", "1", GAIN, "Strain gain of arm 1", ks_arm[0]),
        parameter!("kp2", "N.m/rad", GAIN, "Hub angle gain of arm 2", kp_arm[1]),
        parameter!("kv2", "N.m.s/rad", GAIN, "Hub velocity gain of arm 2", kv_arm[1]),
        parameter!("ks2", "1", GAIN, "Strain gain of arm 2", ks_arm[1]),
    ];

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is not finite or not in its range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check(&Self::PARAMETERS, self)
    }
}

/// The PDS law. It has no state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pds {
    arms: Arms,
    gains: PdsGains,
}

impl Pds {
    /// A controller for these arms.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    pub fn new(arms: Arms, gains: PdsGains) -> Result<Self, InvalidParameter> {
        arms.validate()?;
        gains.validate()?;
        Ok(Self { arms, gains })
    }

    /// The gains.
    #[must_use]
    pub const fn gains(&self) -> &PdsGains {
        &self.gains
    }
}

impl Law for Pds {
    fn arms(&self) -> &Arms {
        &self.arms
    }

    fn initialize(&mut self, _inputs: &Inputs) {}

    /// Eqs. (95) and (96), with `EIᵢ` qᵢ''(0) = Mᵢ(0) + λᵢᵈ l.
    fn commands(&mut self, inputs: &Inputs) -> Commands {
        let PdsGains { kp, kv, kp_arm, kv_arm, ks_arm } = self.gains;
        let measured = &inputs.measured;
        let targets = self.arms.targets(&inputs.reference);
        let errors = targets.errors(inputs);
        Commands {
            tau: std::array::from_fn(|i| {
                let moment_error = measured.root_moment[i] + targets.lambda[i] * self.arms.length;
                -kp_arm[i] * errors.e[i] - kv_arm[i] * measured.theta_dot[i] - ks_arm[i] * moment_error
                    + measured.root_moment[i]
            }),
            u: -kp * errors.p - kv * measured.y_object_dot + measured.tip_shear.iter().sum::<f64>(),
        }
    }

    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        StepError::check(h, inputs, rates)
    }

    fn jacobian(&mut self, _inputs: &Inputs) -> CommandJacobian {
        let PdsGains { kp, kv, kp_arm, kv_arm, ks_arm } = self.gains;
        let targets = self.arms.target_jacobian();
        let errors = self.arms.error_jacobian();
        let tau = std::array::from_fn(|i| {
            let mut row: [f64; INPUTS] = std::array::from_fn(|input| {
                -kp_arm[i] * errors.e[i][input] - ks_arm[i] * self.arms.length * targets.lambda[i][input]
            });
            row[column::THETA_DOT + i] -= kv_arm[i];
            row[column::ROOT_MOMENT + i] += 1.0 - ks_arm[i];
            row
        });
        let mut u = errors.p.map(|value| -kp * value);
        u[column::Y_OBJECT_DOT] -= kv;
        u[column::TIP_SHEAR] += 1.0;
        u[column::TIP_SHEAR + 1] += 1.0;
        CommandJacobian { tau, u }
    }

    fn command_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Commands {
        self.jacobian(inputs).apply(rates)
    }
}
