//! `PdController.fmu`.

use fmi2_export::Variables;

use super::{Controller, FmuLaw, declare};
use crate::parameter::ParameterError;
use crate::pd::{Pd, PdGains};
use crate::target::Arms;

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
        *self = Self::new(*crate::law::Law::arms(self), *gains)?;
        Ok(())
    }

    fn is_like(&self, other: &Self) -> bool {
        self == other
    }

    fn declare_settings(variables: &mut Variables<PdController>) {
        declare(variables, &PdGains::PARAMETERS, true, |m| &mut m.settings);
    }
}
