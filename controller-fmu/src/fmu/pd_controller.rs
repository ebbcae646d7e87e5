//! `PdController.fmu`.

use fmi2_export::Variables;
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::parameter::ParameterError;
use grasp_control::{Arms, Law};

use super::{Controller, FmuLaw, declare};

/// `PdController.fmu`.
pub type PdController = Controller<Pd>;

impl FmuLaw for Pd {
    type Settings = PdGains;
    type Extra = ();

    const NAME: &'static str = "PdController";
    const DESCRIPTION: &'static str = "PD control of the dual-arm grasp, eqs. (97) and (98)";

    fn create(arms: Arms, gains: &PdGains) -> Result<Self, ParameterError> {
        Self::new(arms, *gains)
    }

    fn retune(&mut self, gains: &PdGains) -> Result<(), ParameterError> {
        // The law has no state to keep.
        *self = Self::new(*self.arms(), *gains)?;
        Ok(())
    }

    fn is_like(&self, other: &Self) -> bool {
        self == other
    }

    fn declare_settings(variables: &mut Variables<PdController>) {
        declare(variables, &PdGains::PARAMETERS, true, |m| &mut m.settings);
    }
}
