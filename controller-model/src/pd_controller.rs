//! `PdController.fmu`.

use grasp_control::laws::encoders::Encoders;
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::laws::pds::Limits;
use grasp_control::{Arms, InvalidParameter};

use super::Controller;
use super::gains::GainLaw;

/// `PdController.fmu`.
pub type PdController = Controller<Encoders<Pd>>;

fmi2_export::enumeration! {
    /// Where the gains of the law come from
    pub enum Preset {
        #[default]
        Parameters = "parameters": "As the gain parameters say; their start values are the paper's",
        Paper = "paper": "The paper's; the gain parameters are not used",
        Tuned = "tuned": "A built-in set found by the search that found the gains of NABFC; the gain parameters are not used",
        Pid = "pid": "A built-in set with integrals, found by the search that found the gains of NABFC",
    }
}

impl GainLaw for Pd {
    type Gains = PdGains;
    type Preset = Preset;

    const NAME: &'static str = "PdController";
    const DESCRIPTION: &'static str = "PD control of the dual-arm grasp, eqs. (97) and (98)";

    fn new(arms: Arms, gains: PdGains, limits: Limits) -> Result<Self, InvalidParameter> {
        Self::new(arms, gains, limits)
    }

    fn set_gains(&mut self, gains: PdGains, limits: Limits) -> Result<(), InvalidParameter> {
        self.set_gains(gains, limits)
    }

    fn has_settings_of(&self, other: &Self) -> bool {
        self.has_settings_of(other)
    }
}
