//! PD plus strain feedback, eqs. (95) and (96).

mod continuous;

use super::encoders::Actuation;
use super::{Changes, GAIN, GainSet, Tables};
use crate::law::{CommandJacobian, Law, StepError};
use crate::signals::{Commands, INPUTS, Inputs, column};
use crate::target::Arms;
use parameter_table::{InvalidParameter, Parameter, parameter};
use serde::{Deserialize, Serialize};

/// Gains of the PDS law; index 0 of an array is arm 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PdsGains {
    /// Object position gain `k̄ₚ` \[N/m\].
    pub kp: f64,
    /// Object velocity gain `k̄ᵥ` \[N·s/m\].
    pub kv: f64,
    /// Object integral gain \[N/(m·s)\]; 0 is the paper's law.
    pub ki: f64,
    /// Hub angle gains `k̄ₚᵢ` \[N·m/rad\].
    pub kp_arm: [f64; 2],
    /// Hub velocity gains `k̄ᵥᵢ` \[N·m·s/rad\].
    pub kv_arm: [f64; 2],
    /// Strain gains `k̄ₛᵢ` \[1\].
    pub ks_arm: [f64; 2],
    /// Hub integral gains \[N·m/(rad·s)\]; 0 is the paper's law.
    pub ki_arm: [f64; 2],
}

impl Default for PdsGains {
    /// The values of Section IV, scenario II.
    fn default() -> Self {
        Self { kp: 40.0, kv: 35.0, ki: 0.0, kp_arm: [35.0; 2], kv_arm: [15.0; 2], ks_arm: [10.0; 2], ki_arm: [0.0; 2] }
    }
}

impl PdsGains {
    /// The parameters by their names in the interface.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<PdsGains>; 11] = [
            parameter!("kp", "N/m", GAIN, "Object position gain", kp),
            parameter!("kv", "N.s/m", GAIN, "Object velocity gain", kv),
            parameter!("ki", "N/(m.s)", GAIN, "Object integral gain; 0 = the paper's law", ki),
            parameter!("kp1", "N.m/rad", GAIN, "Hub angle gain of arm 1", kp_arm[0]),
            parameter!("kv1", "N.m.s/rad", GAIN, "Hub velocity gain of arm 1", kv_arm[0]),
            parameter!("ks1", "1", GAIN, "Strain gain of arm 1", ks_arm[0]),
            parameter!("ki1", "N.m/(rad.s)", GAIN, "Hub integral gain of arm 1; 0 = the paper's law", ki_arm[0]),
            parameter!("kp2", "N.m/rad", GAIN, "Hub angle gain of arm 2", kp_arm[1]),
            parameter!("kv2", "N.m.s/rad", GAIN, "Hub velocity gain of arm 2", kv_arm[1]),
            parameter!("ks2", "1", GAIN, "Strain gain of arm 2", ks_arm[1]),
            parameter!("ki2", "N.m/(rad.s)", GAIN, "Hub integral gain of arm 2; 0 = the paper's law", ki_arm[1]),
        ];
        &ROWS
    };

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is not finite or not in its range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        self.check()
    }

    /// The preset *tuned*: what `dualarm tune` found, with the objective and the budget of NABFC's gains
    /// (`scenarios/tuned/pds.toml`).
    #[must_use]
    pub fn tuned() -> Self {
        Self {
            kp: 945.7,
            kv: 39.62,
            ki: 0.0,
            kp_arm: [26.85; 2],
            kv_arm: [2.466; 2],
            ks_arm: [45.05; 2],
            ki_arm: [0.0; 2],
        }
    }
}

impl GainSet for PdsGains {
    fn tables(to: &mut impl Tables<Self>) {
        to.one(Changes::Always, Self::PARAMETERS, |gains| gains);
    }

    fn preset(name: &str) -> Option<Self> {
        Some(match name {
            "paper" => Self::default(),
            "tuned" => Self::tuned(),
            _ => return None,
        })
    }
}

/// The PDS law, with an integral of the errors where its gains ask for one.
///
/// The integrals stand still while their command is beyond its limit and they would push it further (conditional
/// integration), so nothing winds up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pds {
    arms: Arms,
    gains: PdsGains,
    limits: Limits,
    /// ∫ kᵢ e dt: hub 1 and hub 2 \[N·m\], object \[N\].
    integrals: [f64; 3],
}

/// Limits of the commands, for the integrals' anti-windup.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Largest hub torque \[N·m\].
    pub torque: f64,
    /// Largest force on the object \[N\].
    pub force: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self::from(&Actuation::default())
    }
}

impl From<&Actuation> for Limits {
    fn from(actuation: &Actuation) -> Self {
        Self { torque: actuation.torque_limit, force: actuation.force_limit }
    }
}

impl Pds {
    /// A controller for these arms.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    pub fn new(arms: Arms, gains: PdsGains, limits: Limits) -> Result<Self, InvalidParameter> {
        arms.validate()?;
        gains.validate()?;
        Ok(Self { arms, gains, limits, integrals: [0.0; 3] })
    }

    /// The gains.
    #[must_use]
    pub const fn gains(&self) -> &PdsGains {
        &self.gains
    }

    /// Changes gains and limits while the law runs; the integrals stay.
    ///
    /// # Errors
    /// The first parameter that is not in its range; the law is then as before.
    pub fn set_gains(&mut self, gains: PdsGains, limits: Limits) -> Result<(), InvalidParameter> {
        gains.validate()?;
        (self.gains, self.limits) = (gains, limits);
        Ok(())
    }

    /// Whether this law has the arms and settings of another one, whatever its state.
    #[must_use]
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.arms == other.arms && self.gains == other.gains && self.limits == other.limits
    }

    /// Whether anything is integrated.
    fn integrates(&self) -> bool {
        self.gains.ki > 0.0 || self.gains.ki_arm.iter().any(|ki| *ki > 0.0)
    }

    /// Time derivatives of the integrals.
    fn integral_rates(&mut self, inputs: &Inputs) -> [f64; 3] {
        if !self.integrates() {
            return [0.0; 3];
        }
        let errors = self.arms.errors(inputs);
        let PdsGains { ki, ki_arm, .. } = self.gains;
        let wanted = [ki_arm[0] * errors.e[0], ki_arm[1] * errors.e[1], ki * errors.p];
        let commands = self.commands(inputs).to_array();
        let Limits { torque, force } = self.limits;
        let limits = [torque, torque, force];
        // An integral acts with the opposite sign on its command.
        std::array::from_fn(|i| {
            if commands[i].abs() >= limits[i] && commands[i] * wanted[i] < 0.0 { 0.0 } else { wanted[i] }
        })
    }
}

impl Law for Pds {
    fn arms(&self) -> &Arms {
        &self.arms
    }

    fn initialize(&mut self, _inputs: &Inputs) {
        self.integrals = [0.0; 3];
    }

    /// Eqs. (95) and (96), with `EIᵢ` qᵢ''(0) = Mᵢ(0) + λᵢᵈ l, less the integrals.
    fn commands(&mut self, inputs: &Inputs) -> Commands {
        let PdsGains { kp, kv, kp_arm, kv_arm, ks_arm, .. } = self.gains;
        let measured = &inputs.measured;
        let targets = self.arms.targets(&inputs.reference);
        let errors = targets.errors(inputs);
        Commands {
            tau: std::array::from_fn(|i| {
                let moment_error = measured.root_moment[i] + targets.lambda[i] * self.arms.length;
                -kp_arm[i] * errors.e[i] - kv_arm[i] * measured.theta_dot[i] - ks_arm[i] * moment_error
                    + measured.root_moment[i]
                    - self.integrals[i]
            }),
            u: -kp * errors.p - kv * measured.y_object_dot + measured.tip_shear.iter().sum::<f64>() - self.integrals[2],
        }
    }

    /// Exact for inputs that are held or ramp, as long as no integral is stopped or let go within the step.
    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        StepError::check(h, inputs, rates)?;
        if self.integrates() {
            let integral_rates = self.integral_rates(&inputs.after(0.5 * h, rates));
            for (integral, rate) in self.integrals.iter_mut().zip(integral_rates) {
                *integral += h * rate;
            }
        }
        Ok(())
    }

    fn jacobian(&mut self, _inputs: &Inputs) -> CommandJacobian {
        let PdsGains { kp, kv, kp_arm, kv_arm, ks_arm, .. } = self.gains;
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
        let mut commands = self.jacobian(inputs).apply(rates);
        let [hub1, hub2, object] = self.integral_rates(inputs);
        commands.tau[0] -= hub1;
        commands.tau[1] -= hub2;
        commands.u -= object;
        commands
    }
}
