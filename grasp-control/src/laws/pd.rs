//! PD, eqs. (97) and (98).

mod continuous;

use super::{Changes, GAIN, GainSet, Tables};
use crate::law::{CommandJacobian, Law, StepError};
use crate::laws::pds::{Pds, PdsGains};
use crate::signals::{Commands, Inputs};
use crate::target::Arms;
use parameter_table::{InvalidParameter, Parameter, parameter};
use serde::{Deserialize, Serialize};

pub use crate::laws::pds::Limits;

/// Gains of the PD law; index 0 of an array is arm 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PdGains {
    /// Object position gain kₚ \[N/m\].
    pub kp: f64,
    /// Object velocity gain kᵥ \[N·s/m\].
    pub kv: f64,
    /// Object integral gain \[N/(m·s)\]; 0 is the paper's law.
    pub ki: f64,
    /// Hub angle gains kₚᵢ \[N·m/rad\].
    pub kp_arm: [f64; 2],
    /// Hub velocity gains kᵥᵢ \[N·m·s/rad\]. A sampled loop is stable only for steps below 2J/kᵥᵢ.
    pub kv_arm: [f64; 2],
    /// Hub integral gains \[N·m/(rad·s)\]; 0 is the paper's law.
    pub ki_arm: [f64; 2],
}

impl Default for PdGains {
    /// The values of Section IV, scenario III.
    fn default() -> Self {
        Self { kp: 10.0, kv: 9.0, ki: 0.0, kp_arm: [60.0; 2], kv_arm: [55.0; 2], ki_arm: [0.0; 2] }
    }
}

impl PdGains {
    /// The parameters by their names in the interface.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<PdGains>; 9] = [
            parameter!("kp", "N/m", GAIN, "Object position gain", kp),
            parameter!("kv", "N.s/m", GAIN, "Object velocity gain", kv),
            parameter!("ki", "N/(m.s)", GAIN, "Object integral gain; 0 = the paper's law", ki),
            parameter!("kp1", "N.m/rad", GAIN, "Hub angle gain of arm 1", kp_arm[0]),
            parameter!("kv1", "N.m.s/rad", GAIN, "Hub velocity gain of arm 1", kv_arm[0]),
            parameter!("ki1", "N.m/(rad.s)", GAIN, "Hub integral gain of arm 1; 0 = the paper's law", ki_arm[0]),
            parameter!("kp2", "N.m/rad", GAIN, "Hub angle gain of arm 2", kp_arm[1]),
            parameter!("kv2", "N.m.s/rad", GAIN, "Hub velocity gain of arm 2", kv_arm[1]),
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

    /// The preset *tuned*: what `dualarm tune` found, with the objective and the budget of NABFC's gains (`scenarios/tuned/pd.toml`).
    #[must_use]
    pub fn tuned() -> Self {
        Self { kp: 566.6, kv: 23.32, ki: 0.0, kp_arm: [64.28; 2], kv_arm: [1.806; 2], ki_arm: [0.0; 2] }
    }

    /// The preset *pid*: found like *tuned*, with integrals (`scenarios/tuned/pid.toml`).
    #[must_use]
    pub fn pid() -> Self {
        Self { kp: 1566.0, kv: 30.78, ki: 14_980.0, kp_arm: [63.57; 2], kv_arm: [2.19; 2], ki_arm: [17.09; 2] }
    }

    fn with_strain(self) -> PdsGains {
        let Self { kp, kv, ki, kp_arm, kv_arm, ki_arm } = self;
        PdsGains { kp, kv, ki, kp_arm, kv_arm, ks_arm: [0.0; 2], ki_arm }
    }
}

impl GainSet for PdGains {
    fn tables(to: &mut impl Tables<Self>) {
        to.one(Changes::Always, Self::PARAMETERS, |gains| gains);
    }

    fn preset(name: &str) -> Option<Self> {
        Some(match name {
            "paper" => Self::default(),
            "tuned" => Self::tuned(),
            "pid" => Self::pid(),
            _ => return None,
        })
    }
}

/// The PD law: (97) and (98) are (95) and (96) without the strain term. With integral gains it is a PID law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pd {
    gains: PdGains,
    law: Pds,
}

impl Pd {
    /// A controller for these arms.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    pub fn new(arms: Arms, gains: PdGains, limits: Limits) -> Result<Self, InvalidParameter> {
        gains.validate()?;
        Ok(Self { gains, law: Pds::new(arms, gains.with_strain(), limits)? })
    }

    /// The gains.
    #[must_use]
    pub const fn gains(&self) -> &PdGains {
        &self.gains
    }

    /// Changes gains and limits while the law runs; the integrals stay.
    ///
    /// # Errors
    /// The first parameter that is not in its range; the law is then as before.
    pub fn set_gains(&mut self, gains: PdGains, limits: Limits) -> Result<(), InvalidParameter> {
        gains.validate()?;
        self.law.set_gains(gains.with_strain(), limits)?;
        self.gains = gains;
        Ok(())
    }

    /// Whether this law has the arms and settings of another one, whatever its state.
    #[must_use]
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.gains == other.gains && self.law.has_settings_of(&other.law)
    }
}

impl Law for Pd {
    fn arms(&self) -> &Arms {
        self.law.arms()
    }

    fn initialize(&mut self, inputs: &Inputs) {
        self.law.initialize(inputs);
    }

    fn commands(&mut self, inputs: &Inputs) -> Commands {
        self.law.commands(inputs)
    }

    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        self.law.step(h, inputs, rates)
    }

    fn jacobian(&mut self, inputs: &Inputs) -> CommandJacobian {
        self.law.jacobian(inputs)
    }

    fn command_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Commands {
        self.law.command_rates(inputs, rates)
    }
}
