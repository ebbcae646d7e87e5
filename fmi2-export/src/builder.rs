//! Saying more about variables that have been declared.

use std::marker::PhantomData;

use crate::declarations::Declarations;
use crate::exchange::{Exchange, ModelExchange};
use crate::place::Place;
use crate::unit::Unit;
use crate::variable::DependencyKind;
use crate::variables::{Evaluation, length};

/// Says more about a variable, or about all elements of an array.
pub struct VariableBuilder<'a, M> {
    pub(crate) declared: &'a mut Declarations,
    /// Where the first of the variables is in the list; the others are behind it.
    pub(crate) first: usize,
    pub(crate) model: PhantomData<fn(&mut M)>,
}

// Builder methods return the builder for chaining; ending a chain anywhere is fine. What they do is in `declarations`, compiled once
// for all models.
#[allow(clippy::return_self_not_must_use, clippy::must_use_candidate)]
impl<M: 'static> VariableBuilder<'_, M> {
    /// What the variable is, in one line. Required. For an array, `{}` stands for the element's number, counted from 1.
    pub fn description(self, text: &str) -> Self {
        self.declared.description(self.first, text);
        self
    }

    /// What each element of an array is, in one line, from its index counted from 0.
    pub fn descriptions(self, text: impl Fn(usize) -> String) -> Self {
        if !self.declared.brief {
            for (i, variable) in self.declared.list[self.first..].iter_mut().enumerate() {
                variable.description = text(i);
            }
        }
        self
    }

    /// The unit of a number, as an expression of SI units such as `N.m` or `1/(m2.s)`: see [`Unit`].
    pub fn unit(self, expression: &str) -> Self {
        self.declared.unit(self.first, expression);
        self
    }

    /// The unit of a number, if it is no expression of coherent SI units.
    pub fn other_unit(self, unit: &Unit) -> Self {
        self.declared.other_unit(self.first, unit);
        self
    }

    /// The unit in which tools should show the number to people: `factor` times as many of them, e.g. deg and 180/π for
    /// a number in rad.
    pub fn display_unit(self, name: &str, factor: f64) -> Self {
        self.declared.display_unit(self.first, name, factor);
        self
    }

    /// Has tools show an angle, or a rate of one, in degrees. Its [unit](Self::unit) is given first: rad, rad/s, rad/s2, …
    pub fn display_degrees(self) -> Self {
        self.declared.display_degrees(self.first);
        self
    }

    /// The admissible range, both ends included; an infinite end is none. Values outside it are refused.
    pub fn range(self, min: f64, max: f64) -> Self {
        self.declared.range(self.first, min, max);
        self
    }

    /// The least admissible value.
    pub fn min(self, min: f64) -> Self {
        self.declared.min(self.first, min);
        self
    }

    /// The order of magnitude of a number.
    pub fn nominal(self, nominal: f64) -> Self {
        self.declared.nominal(self.first, nominal);
        self
    }

    /// A number that changes at communication points only, such as the output of a counter or of a sampled controller.
    /// Inputs and outputs that are no numbers always are discrete.
    pub fn discrete(self) -> Self {
        self.declared.discrete(self.first);
        self
    }

    /// A parameter that the host may also change between steps.
    pub fn tunable(self) -> Self {
        self.declared.tunable(self.first);
        self
    }

    /// The inputs an output depends on *directly*: those that change it without a step in between. Without this, none.
    /// For an array, `{}` stands for the element's number, counted from 1.
    pub fn depends_on<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        self.declared.depends(self.first, &texts(inputs), DependencyKind::Dependent);
        self
    }

    /// Inputs an output depends on directly and linearly, with a factor fixed once the parameters are.
    pub fn depends_linearly_on<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        self.declared.depends(self.first, &texts(inputs), DependencyKind::Fixed);
        self
    }

    /// Inputs from which the output's *initial* value follows through the initial state: those that
    /// [`Model::initialize`](crate::Model::initialize) reads. They are listed in `InitialUnknowns`, besides all parameters
    /// and the inputs it [depends on](Self::depends_on) directly.
    pub fn starts_from<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        if !self.declared.brief {
            self.declared.starts(self.first, &texts(inputs));
        }
        self
    }

    /// The continuous states an output, or the time derivative of a state, depends on directly. Without this, all of them. For an
    /// array, `{}` stands for the element's number, counted from 1.
    pub fn depends_on_states<S: Into<String>>(self, states: impl IntoIterator<Item = S>) -> Self {
        if !self.declared.brief {
            self.declared.depends_states(self.first, &texts(states));
        }
        self
    }

    /// The field from which the model reads the slope of an input (its unit per second). The host sets it with
    /// `fmi2SetRealInputDerivatives` for the next step; after that step the input stands at the ramp's end and the slope
    /// is zero again.
    pub fn ramp(self, field: impl Fn(&mut M) -> &mut f64 + Send + Sync + 'static) -> Self {
        self.declared.ramp(self.first, Place::by(field));
        self
    }

    /// As [`ramp`](Self::ramp), for the elements of an array.
    pub fn ramp_array(self, field: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static) -> Self {
        let length = length(self.declared, &field);
        self.declared.ramps(self.first, Place::array(field), length);
        self
    }

    /// The field in which `evaluation` leaves the time derivative of an output, for `fmi2GetRealOutputDerivatives`.
    pub fn rate(self, evaluation: Evaluation, field: impl Fn(&mut M) -> &mut f64 + Send + Sync + 'static) -> Self {
        self.declared.rate(self.first, evaluation, Place::by(field));
        self
    }

    /// As [`rate`](Self::rate), for the elements of an array.
    pub fn rate_array(
        self,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
    ) -> Self {
        let length = length(self.declared, &field);
        self.declared.rates(self.first, evaluation, Place::array(field), length);
        self
    }
}

// For models that a host can integrate.
#[allow(clippy::return_self_not_must_use, clippy::must_use_candidate)]
impl<M: ModelExchange> VariableBuilder<'_, M> {
    /// Says that an output or a local variable is a continuous state: the host of a model exchange sets it, and integrates the
    /// variable that is its [time derivative](Self::derivative_of). States are in the order of their declaration.
    ///
    /// Where the state is kept in another form, the field is filled in by the variable's evaluation, and read by
    /// [`ModelExchange::states_set`].
    pub fn state(self) -> Self {
        self.declared.state(self.first, Exchange::of::<M>());
        self
    }

    /// Says of which continuous state this output or local variable is the time derivative. For an array, `{}` stands for the
    /// element's number, counted from 1.
    ///
    /// It depends on all inputs and all states, unless [`depends_on`](Self::depends_on) and
    /// [`depends_on_states`](Self::depends_on_states) say less.
    pub fn derivative_of(self, state: &str) -> Self {
        self.declared.derivative_of(self.first, state);
        self
    }
}

/// The names that a dependency was declared with.
#[inline(never)]
fn texts<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Vec<String> {
    let mut all = Vec::new();
    names.into_iter().for_each(|name| add(&mut all, name));
    all
}

#[inline(never)]
fn add<S: Into<String>>(all: &mut Vec<String>, name: S) {
    all.push(name.into());
}
