//! `PdsController.fmu`.

use fmi2_export::Variables;
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::pds::{Pds, PdsGains};
use grasp_control::{Arms, InvalidParameter};
use serde::{Deserialize, Serialize};

use super::{Controller, FmuLaw, Rates};

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

/// What the user can set.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Settings {
    preset: Preset,
    rates: Rates,
    gains: PdsGains,
    actuation: Actuation,
}

impl Settings {
    fn gains(&self) -> PdsGains {
        match self.preset {
            Preset::Parameters => self.gains,
            Preset::Paper => PdsGains::default(),
            Preset::Tuned => PdsGains::tuned(),
        }
    }
}

impl FmuLaw for Encoders<Pds> {
    type Settings = Settings;
    type Extra = ();

    const NAME: &'static str = "PdsController";
    const DESCRIPTION: &'static str = "PD control with strain feedback (PDS) of the dual-arm grasp, eqs. (95) and (96)";

    fn create(arms: Arms, settings: &Settings) -> Result<Self, InvalidParameter> {
        let law = Pds::new(arms, settings.gains(), (&settings.actuation).into())?;
        Self::new(law, settings.rates.into(), settings.actuation)
    }

    fn retune(&mut self, settings: &Settings) -> Result<(), InvalidParameter> {
        settings.actuation.validate()?;
        self.law_mut().set_gains(settings.gains(), (&settings.actuation).into())?;
        self.set_actuation(settings.actuation)
    }

    fn is_like(&self, other: &Self) -> bool {
        self.has_settings_of(other) && self.law().has_settings_of(other.law())
    }

    fn declare_settings(variables: &mut Variables<PdsController>) {
        variables.parameter("preset", |m| &mut m.settings.preset).description("Where the gains come from");
        variables.parameters(PdsGains::PARAMETERS, |m| &mut m.settings.gains).tunable();
        variables
            .parameter("rate_source", |m| &mut m.settings.rates)
            .description("Where the rates of angles, position and strain come from");
        variables.parameters(Actuation::PARAMETERS, |m| &mut m.settings.actuation).tunable();
    }
}
