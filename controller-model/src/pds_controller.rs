//! `PdsController.fmu`.

use grasp_control::laws::encoders::Encoders;
use grasp_control::laws::pds::{Limits, Pds, PdsGains};
use grasp_control::{Arms, InvalidParameter};

use super::Controller;
use super::gains::GainLaw;

/// `PdsController.fmu`.
pub type PdsController = Controller<Encoders<Pds>>;

fmi2_export::enumeration! {
    /// Where the gains of the law come from
    pub enum Preset {
        #[default]
        Parameters = "parameters": "As the gain parameters say; their start values are the paper's",
        Paper = "paper": "The paper's; the gain parameters are not used",
        Tuned = "tuned": "A built-in set found by the search that found the gains of NABFC; the gain parameters are not used",
    }
}

impl GainLaw for Pds {
    type Gains = PdsGains;
    type Preset = Preset;

    const NAME: &'static str = "PdsController";
    const DESCRIPTION: &'static str = "PD control with strain feedback (PDS) of the dual-arm grasp, eqs. (95) and (96)";

    fn new(arms: Arms, gains: PdsGains, limits: Limits) -> Result<Self, InvalidParameter> {
        Self::new(arms, gains, limits)
    }

    fn set_gains(&mut self, gains: PdsGains, limits: Limits) -> Result<(), InvalidParameter> {
        self.set_gains(gains, limits)
    }

    fn has_settings_of(&self, other: &Self) -> bool {
        self.has_settings_of(other)
    }
}
