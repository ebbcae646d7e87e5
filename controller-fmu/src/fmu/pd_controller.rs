//! `PdController.fmu`.

use fmi2_export::Variables;
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::{Arms, InvalidParameter, Law};

use super::{Controller, FmuLaw};

/// `PdController.fmu`.
pub type PdController = Controller<Pd>;

impl FmuLaw for Pd {
    type Settings = PdGains;
    type Extra = ();

    const NAME: &'static str = "PdController";
    const DESCRIPTION: &'static str = "PD control of the dual-arm grasp, eqs. (97) and (98)";

    fn create(arms: Arms, gains: &PdGains) -> Result<Self, InvalidParameter> {
        Self::new(arms, *gains)
    }

    fn retune(&mut self, gains: &PdGains) -> Result<(), InvalidParameter> {
        // The law has no state to keep.
        *self = Self::new(*self.arms(), *gains)?;
        Ok(())
    }

    fn is_like(&self, other: &Self) -> bool {
        self == other
    }

    fn declare_settings(variables: &mut Variables<PdController>) {
        variables.tunables(PdGains::PARAMETERS.map(Into::into), |m| &mut m.settings);
    }
}
