//! `PdsController.fmu`.

use fmi2_export::Variables;
use grasp_control::laws::pds::{Pds, PdsGains};
use grasp_control::{Arms, InvalidParameter, Law};

use super::{Controller, FmuLaw};

/// `PdsController.fmu`.
pub type PdsController = Controller<Pds>;

impl FmuLaw for Pds {
    type Settings = PdsGains;
    type Extra = ();

    const NAME: &'static str = "PdsController";
    const DESCRIPTION: &'static str = "PD control with strain feedback (PDS) of the dual-arm grasp, eqs. (95) and (96)";

    fn create(arms: Arms, gains: &PdsGains) -> Result<Self, InvalidParameter> {
        Self::new(arms, *gains)
    }

    fn retune(&mut self, gains: &PdsGains) -> Result<(), InvalidParameter> {
        // The law has no state to keep.
        *self = Self::new(*self.arms(), *gains)?;
        Ok(())
    }

    fn is_like(&self, other: &Self) -> bool {
        self == other
    }

    fn declare_settings(variables: &mut Variables<PdsController>) {
        variables.tunables(PdsGains::PARAMETERS.map(Into::into), |m| &mut m.settings);
    }
}
