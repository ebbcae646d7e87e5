//! `PdsController.fmu`.

use fmi2_export::Variables;

use super::{Controller, FmuLaw, declare};
use crate::parameter::ParameterError;
use crate::pds::{Pds, PdsGains};
use crate::target::Arms;

/// `PdsController.fmu`.
pub type PdsController = Controller<Pds>;

impl FmuLaw for Pds {
    type Settings = PdsGains;
    type Extra = ();

    const NAME: &'static str = "PdsController";
    const DESCRIPTION: &'static str = "PD control with strain feedback (PDS) of the dual-arm grasp, eqs. (95) and (96)";

    fn create(arms: Arms, gains: &PdsGains) -> Result<Self, ParameterError> {
        Self::new(arms, *gains)
    }

    fn retune(&mut self, gains: &PdsGains) -> Result<(), ParameterError> {
        // The law has no state to keep.
        *self = Self::new(*crate::law::Law::arms(self), *gains)?;
        Ok(())
    }

    fn is_like(&self, other: &Self) -> bool {
        self == other
    }

    fn declare_settings(variables: &mut Variables<PdsController>) {
        declare(variables, &PdsGains::PARAMETERS, true, |m| &mut m.settings);
    }
}
