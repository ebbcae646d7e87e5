//! `PdController.fmu`.

use fmi2_export::Variables;
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::{Arms, InvalidParameter};
use serde::{Deserialize, Serialize};

use super::{Controller, FmuLaw, Rates};

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

/// What the user can set.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Settings {
    preset: Preset,
    rates: Rates,
    gains: PdGains,
    actuation: Actuation,
}

impl Settings {
    fn gains(&self) -> PdGains {
        match self.preset {
            Preset::Parameters => self.gains,
            Preset::Paper => PdGains::default(),
            Preset::Tuned => PdGains::tuned(),
            Preset::Pid => PdGains::pid(),
        }
    }
}

impl FmuLaw for Encoders<Pd> {
    type Settings = Settings;
    type Extra = ();

    const NAME: &'static str = "PdController";
    const DESCRIPTION: &'static str = "PD control of the dual-arm grasp, eqs. (97) and (98)";

    fn create(arms: Arms, settings: &Settings) -> Result<Self, InvalidParameter> {
        let law = Pd::new(arms, settings.gains(), (&settings.actuation).into())?;
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

    fn declare_settings(variables: &mut Variables<PdController>) {
        variables.parameter("preset", |m| &mut m.settings.preset).description("Where the gains come from");
        variables.parameters(PdGains::PARAMETERS, |m| &mut m.settings.gains).tunable();
        variables
            .parameter("rate_source", |m| &mut m.settings.rates)
            .description("Where the rates of angles, position and strain come from");
        variables.parameters(Actuation::PARAMETERS, |m| &mut m.settings.actuation).tunable();
    }
}
