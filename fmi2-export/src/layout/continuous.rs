//! What a host that integrates deals with: continuous states, their time derivatives, event indicators.

use std::sync::Arc;

use super::Layout;
use crate::any_model::AnyModel;
use crate::declarations::Indicators;
use crate::exchange::Exchange;
use crate::view::NumbersOf;

/// The continuous states and the event indicators of a model, and what is called for them.
pub(crate) struct Continuous {
    pub exchange: &'static Exchange,
    /// In the order in which the host has them.
    pub states: Vec<StateSlot>,
    /// The evaluations that fill in the states.
    pub state_evaluations: u64,
    /// Those that fill in their time derivatives.
    pub derivative_evaluations: u64,
    /// What fills in the event indicators, as a bit, and where they are.
    indicators: Option<(u64, Arc<NumbersOf>)>,
    /// How many there are.
    pub indicator_count: usize,
}

impl Continuous {
    /// What fills in the event indicators.
    pub fn indicator_evaluations(&self) -> u64 {
        self.indicators.as_ref().map_or(0, |(evaluation, _)| *evaluation)
    }
}

/// Value references of a continuous state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StateSlot {
    pub state: u32,
    pub derivative: u32,
    /// Its order of magnitude, positive.
    pub nominal: f64,
}

impl Layout {
    pub(super) fn add_continuous(&mut self, exchange: &'static Exchange, indicators: Option<Indicators>) {
        let mut continuous = Continuous {
            exchange,
            states: Vec::new(),
            state_evaluations: 0,
            derivative_evaluations: 0,
            indicator_count: indicators.as_ref().map_or(0, |indicators| indicators.count),
            indicators: indicators.map(|indicators| (1 << indicators.evaluation.0, indicators.array)),
        };
        let derivatives: Vec<(&str, u32)> = self
            .variables
            .iter()
            .zip(&self.references)
            .filter_map(|(variable, reference)| Some((variable.derivative_of.as_deref()?, reference.index)))
            .collect();
        // They are in the order of the states as a rule, so each is looked for behind the one before. That is shorter than a hash table.
        let mut last = 0;
        for (variable, reference) in self.variables.iter().zip(&self.references).filter(|(v, _)| v.is_state) {
            let (before, behind) = derivatives.split_at(last);
            // Each has one: see `problems`.
            let Some(past) = behind.iter().chain(before).position(|(of, _)| *of == variable.name) else { continue };
            last = (last + past) % derivatives.len();
            let derivative = &derivatives[last].1;
            let state = reference.index;
            continuous.states.push(StateSlot {
                state,
                derivative: *derivative,
                nominal: variable.nominal.map_or(1.0, f64::abs),
            });
            continuous.state_evaluations |= self.evaluation(&self.reals[state as usize]);
            continuous.derivative_evaluations |= self.evaluation(&self.reals[*derivative as usize]);
        }
        // Whatever an input is to them, it is not said for each.
        self.input_dependent |= continuous.derivative_evaluations;
        self.input_dependent |= continuous.indicator_evaluations();
        self.continuous = Some(continuous);
    }

    fn state_slots(&self) -> impl Iterator<Item = &StateSlot> {
        self.continuous.iter().flat_map(|continuous| &continuous.states)
    }

    /// The continuous states, as their fields have them.
    pub fn states<'a>(&'a self, model: &'a mut dyn AnyModel) -> impl Iterator<Item = f64> + 'a {
        let mut view = self.view(model);
        self.state_slots().map(move |slot| view.real(slot.state))
    }

    /// Writes the fields of the continuous states.
    pub fn write_states(&self, model: &mut dyn AnyModel, values: &[f64]) {
        let mut view = self.view(model);
        for (slot, value) in self.state_slots().zip(values) {
            view.set_real(slot.state, *value);
        }
    }

    /// The states' time derivatives, as their fields have them.
    pub fn derivatives<'a>(&'a self, model: &'a mut dyn AnyModel) -> impl Iterator<Item = f64> + 'a {
        let mut view = self.view(model);
        self.state_slots().map(move |slot| view.real(slot.derivative))
    }

    /// The states' nominal values.
    pub fn nominals(&self) -> impl Iterator<Item = f64> {
        self.state_slots().map(|slot| slot.nominal)
    }

    /// The event indicators, as their field has them.
    pub fn indicators<'m>(&'m self, model: &'m mut dyn AnyModel) -> &'m [f64] {
        match self.continuous.as_ref().and_then(|continuous| continuous.indicators.as_ref()) {
            // SAFETY: declared with these variables.
            Some((_, array)) => unsafe { self.view(model).numbers(&**array) },
            None => &[],
        }
    }
}
