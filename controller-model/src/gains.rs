//! Gains in the interface; and the common parts of PD and PDS as FMUs: laws whose settings are only gains.

use fmi2_export::{Enumeration, StateVariable, Variables};
use grasp_control::continuous::{Continuous, PDS_INDICATORS, PDS_STATES, pds_state_variables};
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::pds::Limits;
use grasp_control::laws::{Changes, GainSet, Tables};
use grasp_control::{Arms, InvalidParameter, Parameter};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::{Controller, FmuLaw, Rates};

/// A law whose settings are its gains.
pub trait GainLaw: Continuous + Clone + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// The gains; the default ones are the paper's.
    type Gains: GainSet + Default + Serialize + DeserializeOwned + Send + Sync + 'static;
    /// The names of the built-in sets of them, and `parameters`.
    type Preset: Enumeration + Default + Serialize + DeserializeOwned;

    /// Name of the FMU.
    const NAME: &'static str;
    /// Its description in one line.
    const DESCRIPTION: &'static str;

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

/// The gains to use: those of the preset, or as the user has set the `parameters`.
pub fn chosen<G: GainSet, P: Enumeration>(preset: P, parameters: G) -> G {
    let item = P::VALUES.iter().position(|value| *value == preset);
    item.and_then(|item| G::preset(P::ITEMS[item].0)).unwrap_or(parameters)
}

/// Declares the gains that `gains` leads to as parameters. `learner` declares what has no table.
pub fn declare<M: 'static, G: GainSet>(
    variables: &mut Variables<M>,
    gains: impl Fn(&mut M) -> &mut G + Copy + Send + Sync + 'static,
    learner: fn(&mut Variables<M>),
) {
    G::tables(&mut Declaration { variables, gains, learner });
}

struct Declaration<'a, M, P> {
    variables: &'a mut Variables<M>,
    gains: P,
    learner: fn(&mut Variables<M>),
}

impl<M: 'static, G: GainSet, P: Fn(&mut M) -> &mut G + Copy + Send + Sync + 'static> Tables<G>
    for Declaration<'_, M, P>
{
    fn one<T: Copy + 'static>(
        &mut self,
        changes: Changes,
        table: &'static [Parameter<T>],
        owner: impl Fn(&mut G) -> &mut T + Copy + Send + Sync + 'static,
    ) {
        let gains = self.gains;
        let declared = self.variables.parameters(table, move |model| owner(gains(model)));
        if changes == Changes::Always {
            declared.tunable();
        }
    }

    fn per_arm<T: Copy + 'static>(
        &mut self,
        changes: Changes,
        table: &'static [Parameter<T>],
        owners: impl Fn(&mut G) -> &mut [T; 2] + Copy + Send + Sync + 'static,
    ) {
        let gains = self.gains;
        let declared = self.variables.parameter_family(table, move |model| owners(gains(model)));
        if changes == Changes::Always {
            declared.tunable();
        }
    }

    fn learner(&mut self) {
        (self.learner)(self.variables);
    }
}

/// The settings of the user.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub struct GainSettings<G, P> {
    preset: P,
    rates: Rates,
    gains: G,
    actuation: Actuation,
}

impl<G: GainSet, P: Enumeration> GainSettings<G, P> {
    fn gains(&self) -> G {
        chosen(self.preset, self.gains)
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
        declare(variables, |m| &mut m.settings.gains, |_| {});
        variables
            .parameter("rate_source", |m| &mut m.settings.rates)
            .description("Where the rates of angles, position and strain come from");
        variables.parameters(Actuation::PARAMETERS, |m| &mut m.settings.actuation).tunable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{nabfc_controller, pd_controller, pds_controller};
    use grasp_control::laws::nabfc::Gains;
    use grasp_control::laws::pd::PdGains;
    use grasp_control::laws::pds::PdsGains;
    use grasp_control::laws::root_strain::RootStrainGains;

    /// The names stand in the enumeration, for its descriptions, and in the law: a preset that only one of them has would be
    /// the parameters.
    fn presets_of<G: GainSet, P: Enumeration>() {
        for (name, _) in P::ITEMS {
            assert_eq!(G::preset(name).is_none(), *name == "parameters", "{name}");
        }
    }

    #[test]
    fn every_preset_has_gains() {
        presets_of::<PdGains, pd_controller::Preset>();
        presets_of::<PdsGains, pds_controller::Preset>();
        presets_of::<Gains, nabfc_controller::Preset>();
        presets_of::<RootStrainGains, nabfc_controller::Preset>();
    }
}
