//! The common parts of PD and PDS as FMUs: laws whose settings are only gains.

use fmi2_export::{Enumeration, StateVariable, Variables};
use grasp_control::continuous::{Continuous, PDS_INDICATORS, PDS_STATES, pds_state_variables};
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::pds::Limits;
use grasp_control::{Arms, InvalidParameter, Parameter};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::{Controller, FmuLaw, Rates};

/// A law whose settings are its gains.
pub trait GainLaw: Continuous + Clone + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// The gains; the default ones are the paper's.
    type Gains: Copy + Default + Serialize + DeserializeOwned + Send + Sync + 'static;
    /// Built-in sets of them.
    type Preset: GainSource<Self::Gains>;

    /// Name of the FMU.
    const NAME: &'static str;
    /// Its description in one line.
    const DESCRIPTION: &'static str;
    /// The gains by their names in the interface.
    const GAINS: &'static [Parameter<Self::Gains>];

    /// The law in its initial state.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    fn new(arms: Arms, gains: Self::Gains, limits: Limits) -> Result<Self, InvalidParameter>;

    /// Changes gains and limits while the law runs; its state stays.
    ///
    /// # Errors
    /// The first parameter that is not in its range; the law is then unchanged.
    fn set_gains(&mut self, gains: Self::Gains, limits: Limits) -> Result<(), InvalidParameter>;

    /// Whether this law has the arms and the settings of another one, whatever its state.
    fn has_settings_of(&self, other: &Self) -> bool;
}

/// Where the gains of a law come from.
pub trait GainSource<G>: Enumeration + Default + Serialize + DeserializeOwned {
    /// The gains to use; `parameters` are those the user has set.
    fn gains(self, parameters: G) -> G;
}

/// The settings of the user.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub struct GainSettings<G, P> {
    preset: P,
    rates: Rates,
    gains: G,
    actuation: Actuation,
}

impl<G: Copy, P: GainSource<G>> GainSettings<G, P> {
    fn gains(&self) -> G {
        self.preset.gains(self.gains)
    }

    fn limits(&self) -> Limits {
        (&self.actuation).into()
    }
}

impl<L: GainLaw> FmuLaw for Encoders<L> {
    type Settings = GainSettings<L::Gains, L::Preset>;
    type Extra = ();

    const NAME: &'static str = L::NAME;
    const DESCRIPTION: &'static str = L::DESCRIPTION;
    const INDICATORS: usize = PDS_INDICATORS;

    fn state_variables(_: &Self::Settings) -> Vec<StateVariable> {
        pds_state_variables()
    }

    fn state_count(_: &Self::Settings) -> usize {
        PDS_STATES
    }

    fn create(arms: Arms, settings: &Self::Settings) -> Result<Self, InvalidParameter> {
        let law = L::new(arms, settings.gains(), settings.limits())?;
        Self::new(law, settings.rates.into(), settings.actuation)
    }

    fn retune(&mut self, settings: &Self::Settings) -> Result<(), InvalidParameter> {
        settings.actuation.validate()?;
        self.law_mut().set_gains(settings.gains(), settings.limits())?;
        self.set_actuation(settings.actuation)
    }

    fn is_like(&self, other: &Self) -> bool {
        self.has_settings_of(other) && self.law().has_settings_of(other.law())
    }

    fn declare_settings(variables: &mut Variables<Controller<Self>>) {
        variables.parameter("preset", |m| &mut m.settings.preset).description("Where the gains come from");
        variables.parameters(L::GAINS, |m| &mut m.settings.gains).tunable();
        variables
            .parameter("rate_source", |m| &mut m.settings.rates)
            .description("Where the rates of angles, position and strain come from");
        variables.parameters(Actuation::PARAMETERS, |m| &mut m.settings.actuation).tunable();
    }
}
