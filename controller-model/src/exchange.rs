//! Model exchange for the controllers: the states of [`grasp_control::continuous`] as variables.

use fmi2_export::{EventUpdate, Experiment, Failure, Model, ModelExchange, Moment, Variables};
use grasp_control::continuous::Direction;

use super::{Controller, FmuLaw};

/// The largest number of decisions about limits in one event: one decision can change a command on which another depends.
const MOST_DECISIONS: usize = 8;

/// Variables that only a host of model exchange reads. They take no memory until it does: 5 KiB of NABFC, in co-simulation none.
#[derive(Clone)]
pub(super) struct States {
    count: usize,
    indicator_count: usize,
    values: Vec<f64>,
    rates: Vec<f64>,
    indicators: Vec<f64>,
}

impl States {
    /// Those of a law with its default settings: FMI 2.0 fixes their number.
    pub fn of<L: FmuLaw>() -> Self {
        let count = L::state_count(&L::Settings::default());
        let (values, rates, indicators) = (Vec::new(), Vec::new(), Vec::new());
        Self { count, indicator_count: L::INDICATORS, values, rates, indicators }
    }

    fn values(&mut self) -> &mut Vec<f64> {
        self.values.resize(self.count, 0.0);
        &mut self.values
    }

    fn rates(&mut self) -> &mut Vec<f64> {
        self.rates.resize(self.count, 0.0);
        &mut self.rates
    }

    fn indicators(&mut self) -> &mut Vec<f64> {
        self.indicators.resize(self.indicator_count, 1.0);
        &mut self.indicators
    }
}

impl<L: FmuLaw> Controller<L> {
    /// Whether the law has as many states as the FMU: in co-simulation the settings are free.
    fn has_states(&self) -> bool {
        L::state_count(&self.settings) == self.states.count
    }

    fn state_values(&mut self) {
        let fits = self.has_states();
        self.states.values().fill(0.0);
        if let Some(law) = self.law.as_ref().filter(|_| fits) {
            law.continuous_states(self.states.values());
        }
    }

    fn state_rates(&mut self) {
        let fits = self.has_states();
        self.states.rates().fill(0.0);
        if let Some(law) = self.law.as_mut().filter(|_| fits) {
            law.derivatives(&self.signals.inputs, &self.regimes, self.states.rates());
        }
    }

    fn indicators(&mut self) {
        self.states.indicators().fill(1.0);
        if let Some(law) = &mut self.law {
            law.event_indicators(&self.signals.inputs, &self.regimes, self.states.indicators());
        }
    }
}

/// The states, their time derivatives and the event indicators.
pub(super) fn declare<L: FmuLaw>(variables: &mut Variables<Controller<L>>) {
    let values = variables.evaluation(Controller::<L>::state_values);
    let rates = variables.evaluation(Controller::<L>::state_rates);
    let indicators = variables.evaluation(Controller::<L>::indicators);
    let rows = L::state_variables(&L::Settings::default());
    variables.states(&rows, values, |m| m.states.values(), rates, |m| m.states.rates());
    variables.event_indicators(indicators, |m| m.states.indicators());
}

impl<L: FmuLaw> ModelExchange for Controller<L> {
    fn initialize_exchange(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        let (found, expected) = (L::state_count(&self.settings), self.states.count);
        if found != expected {
            return Err(Failure::error(format!(
                "with these settings the law has {found} continuous states, but for model exchange this FMU has {expected}: their \
                 number is fixed when it is packaged. Leave {} at the start values, or use co-simulation, where they are free",
                L::COUNT_FOLLOWS_FROM
            )));
        }
        self.initialize(experiment)?;
        self.is_integrated = true;
        Ok(())
    }

    fn states_set(&mut self) -> Result<(), Failure> {
        let law = self.law.as_mut().ok_or_else(|| Failure::error("the controller has no start yet"))?;
        law.set_continuous_states(self.states.values()).map_err(Failure::discard)
    }

    fn new_discrete_states(&mut self, _: &mut Moment<'_>) -> Result<EventUpdate, Failure> {
        if let Some(law) = &mut self.law {
            for _ in 0..MOST_DECISIONS {
                let decision = law.decide(&self.signals.inputs, &mut self.regimes);
                if !(decision.regimes || decision.states) {
                    break;
                }
            }
        }
        Ok(EventUpdate::default())
    }

    fn jacobian_product(&mut self, direction: &mut Self) {
        direction.signals.compare_changes(&self.arms);
        let fits = self.has_states();
        let Some(law) = self.law.as_mut().filter(|_| fits) else { return };
        direction.states.rates();
        direction.states.values();
        let along = Direction { states: &direction.states.values, inputs: &direction.signals.inputs };
        direction.signals.outputs.commands = law.command_change(&self.signals.inputs, along);
        direction.extra = law.extra_change(&self.signals.inputs, along);
        law.derivative_change(&self.signals.inputs, &self.regimes, along, &mut direction.states.rates);
    }
}
