//! What a solver beside this crate needs of a model whose continuous states are declared, so that it can make communication steps.
//!
//! Hidden from the documentation, since only `fmi2-integrate` of the very same version uses it; it may change with any.

use std::any::TypeId;
use std::marker::PhantomData;

use crate::exchange::{EventUpdate, ModelExchange, Moment};
use crate::layout::{Continuous, Layout};
use crate::model::{Failure, Step};

/// A model as a system of differential equations.
pub struct Equations<'a, M> {
    source: Source<'a>,
    model: PhantomData<fn(&mut M)>,
}

enum Source<'a> {
    /// Of the host's instance.
    Host(&'a Layout),
    /// Made anew: in a test, outside of any host.
    Own(Box<Layout>),
}

impl<'a, M: ModelExchange> Equations<'a, M> {
    /// Those of the model that makes a step.
    ///
    /// # Errors
    /// If the model declares no states, or its declarations contradict themselves.
    pub fn of(step: &Step<'a>) -> Result<Self, Failure> {
        let source = match step.layout.filter(|layout| layout.is_of(TypeId::of::<M>())) {
            Some(layout) => Source::Host(layout),
            None => Source::Own(Box::new(Layout::build::<M>().map_err(Failure::error)?)),
        };
        let equations = Self { source, model: PhantomData };
        if equations.layout().continuous.is_none() {
            return Err(Failure::error("the model declares no continuous states: there is nothing to integrate"));
        }
        Ok(equations)
    }
}

impl<M: ModelExchange> Equations<'_, M> {
    fn layout(&self) -> &Layout {
        match &self.source {
            Source::Host(layout) => layout,
            Source::Own(layout) => layout,
        }
    }

    /// Checked when it was made.
    fn continuous(&self) -> Option<&Continuous> {
        self.layout().continuous.as_ref()
    }

    /// Nominal values of the continuous states.
    pub fn nominals(&self) -> impl Iterator<Item = f64> {
        self.layout().nominals()
    }

    /// Whether there are event indicators.
    #[must_use]
    pub fn has_indicators(&self) -> bool {
        self.continuous().is_some_and(|continuous| continuous.indicator_count > 0)
    }

    /// Puts time and states into the model; whether it can have them.
    pub fn set(&self, model: &mut M, time: f64, states: &[f64]) -> bool {
        self.layout().tell_time(model, time);
        self.layout().write_states(model, states);
        states.iter().all(|value| value.is_finite()) && model.states_set().is_ok()
    }

    /// The states of the model.
    pub fn states(&self, model: &mut M, states: &mut [f64]) {
        let Some(continuous) = self.continuous() else { return };
        self.layout().view(model).evaluate(continuous.state_evaluations);
        states.iter_mut().zip(self.layout().states(model)).for_each(|(to, state)| *to = state);
    }

    /// Their time derivatives.
    pub fn derivatives(&self, model: &mut M, derivatives: &mut [f64]) {
        let Some(continuous) = self.continuous() else { return };
        self.layout().view(model).evaluate(continuous.derivative_evaluations);
        derivatives.iter_mut().zip(self.layout().derivatives(model)).for_each(|(to, derivative)| *to = derivative);
    }

    /// The event indicators.
    pub fn indicators<'m>(&'m self, model: &'m mut M) -> &'m [f64] {
        self.layout().view(model).evaluate(self.continuous().map_or(0, Continuous::indicator_evaluations));
        self.layout().indicators(model)
    }

    /// Brings the discrete states up to date at a time.
    ///
    /// # Errors
    /// If the model cannot go on.
    pub fn update(&self, model: &mut M, time: f64, step: &mut Step<'_>) -> Result<EventUpdate, Failure> {
        self.layout().tell_time(model, time);
        model.new_discrete_states(&mut Moment::new(time, step.warn))
    }
}

/// The relative tolerance of the experiment, if the host has named one.
#[must_use]
pub fn tolerance(step: &Step<'_>) -> Option<f64> {
    step.tolerance()
}
