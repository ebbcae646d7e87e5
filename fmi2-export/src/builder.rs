//! Saying more about variables that have been declared.

use std::sync::Arc;

use crate::access::Lens;
use crate::exchange::{Exchange, ModelExchange};
use crate::unit::{DisplayUnit, Unit};
use crate::variable::{Causality, DependencyKind, Variability, Variable};
use crate::variables::{Evaluation, numbered};

/// Says more about a variable, or about all elements of an array.
pub struct VariableBuilder<'a, M> {
    pub(crate) variables: &'a mut [Variable<M>],
    /// Of the whole model.
    pub(crate) exchange: &'a mut Option<Exchange<M>>,
}

// Builder methods return the builder for chaining; ending a chain anywhere is fine. They are not inlined: declarations are long
// lists of such calls, run once for a library, and would become a third of its code.
#[allow(clippy::return_self_not_must_use, clippy::must_use_candidate)]
impl<M: 'static> VariableBuilder<'_, M> {
    fn each(self, mut change: impl FnMut(&mut Variable<M>)) -> Self {
        self.variables.iter_mut().for_each(&mut change);
        self
    }

    /// What the variable is, in one line. Required. For an array, `{}` stands for the element's number, counted from 1.
    #[inline(never)]
    pub fn description(self, text: &str) -> Self {
        self.each(|v| v.description = v.numbered(text))
    }

    /// What each element of an array is, in one line, from its index counted from 0.
    pub fn descriptions(self, text: impl Fn(usize) -> String) -> Self {
        for (i, variable) in self.variables.iter_mut().enumerate() {
            variable.description = text(i);
        }
        self
    }

    /// The unit of a number, as an expression of SI units such as `N.m` or `1/(m2.s)`: see [`Unit`].
    #[inline(never)]
    pub fn unit(self, expression: &str) -> Self {
        self.each(|v| match expression.parse() {
            Ok(unit) => v.unit = Some(unit),
            Err(error) => v.mistakes.push(error.to_string()),
        })
    }

    /// The unit of a number, if it is no expression of coherent SI units.
    #[inline(never)]
    pub fn other_unit(self, unit: &Unit) -> Self {
        self.each(|v| v.unit = Some(unit.clone()))
    }

    /// The unit in which tools should show the number to people: `factor` times as many of them, e.g. deg and 180/π for
    /// a number in rad.
    #[inline(never)]
    pub fn display_unit(self, name: &str, factor: f64) -> Self {
        self.each(|v| v.display_unit = Some(DisplayUnit { name: name.to_owned(), factor }))
    }

    /// Has tools show an angle, or a rate of one, in degrees. Its [unit](Self::unit) is given first: rad, rad/s, rad/s2, …
    #[inline(never)]
    pub fn display_degrees(self) -> Self {
        self.each(|v| match v.unit.as_ref().and_then(DisplayUnit::degrees) {
            Some(degrees) => v.display_unit = Some(degrees),
            None => v
                .mistakes
                .push("degrees are shown of angles and their rates, so say a unit such as rad/s before".into()),
        })
    }

    /// The admissible range, both ends included; an infinite end is none. Values outside it are refused.
    #[inline(never)]
    pub fn range(self, min: f64, max: f64) -> Self {
        let (min, max) = (Some(min).filter(|v| *v != f64::NEG_INFINITY), Some(max).filter(|v| *v != f64::INFINITY));
        self.each(|v| (v.min, v.max) = (min, max))
    }

    /// The least admissible value.
    #[inline(never)]
    pub fn min(self, min: f64) -> Self {
        self.each(|v| v.min = Some(min).filter(|v| *v != f64::NEG_INFINITY))
    }

    /// The order of magnitude of a number.
    #[inline(never)]
    pub fn nominal(self, nominal: f64) -> Self {
        self.each(|v| v.nominal = Some(nominal))
    }

    /// A number that changes at communication points only, such as the output of a counter or of a sampled controller.
    /// Inputs and outputs that are no numbers always are discrete.
    #[inline(never)]
    pub fn discrete(self) -> Self {
        self.each(|v| match v.causality {
            Causality::Parameter => v.mistakes.push("a parameter is fixed or tunable, not discrete".into()),
            Causality::Input | Causality::Output | Causality::Local => v.variability = Variability::Discrete,
        })
    }

    /// A parameter that the host may also change between steps.
    pub fn tunable(self) -> Self {
        self.each(|v| match v.causality {
            Causality::Parameter => v.variability = Variability::Tunable,
            Causality::Input | Causality::Output | Causality::Local => {
                v.mistakes.push("only a parameter is tunable".into());
            }
        })
    }

    /// The inputs an output depends on *directly*: those that change it without a step in between. Without this, none.
    /// For an array, `{}` stands for the element's number, counted from 1.
    pub fn depends_on<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        self.depends(&inputs.into_iter().map(Into::into).collect::<Vec<String>>(), DependencyKind::Dependent)
    }

    /// Inputs an output depends on directly and linearly, with a factor fixed once the parameters are.
    pub fn depends_linearly_on<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        self.depends(&inputs.into_iter().map(Into::into).collect::<Vec<String>>(), DependencyKind::Fixed)
    }

    #[inline(never)]
    fn depends(self, inputs: &[String], kind: DependencyKind) -> Self {
        self.each(|v| {
            let its: Vec<_> = inputs.iter().map(|input| (v.numbered(input), kind)).collect();
            v.depends_on.extend(its);
        })
    }

    /// Inputs from which the output's *initial* value follows through the initial state: those that
    /// [`Model::initialize`](crate::Model::initialize) reads. They are listed in `InitialUnknowns`, besides all parameters
    /// and the inputs it [depends on](Self::depends_on) directly.
    pub fn starts_from<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        self.starts(&inputs.into_iter().map(Into::into).collect::<Vec<String>>())
    }

    #[inline(never)]
    fn starts(self, inputs: &[String]) -> Self {
        self.each(|v| {
            let its: Vec<_> = inputs.iter().map(|input| v.numbered(input)).collect();
            v.starts_from.extend(its);
        })
    }

    /// The continuous states an output, or the time derivative of a state, depends on directly. Without this, all of them. For an
    /// array, `{}` stands for the element's number, counted from 1.
    pub fn depends_on_states<S: Into<String>>(self, states: impl IntoIterator<Item = S>) -> Self {
        self.depends_states(&states.into_iter().map(Into::into).collect::<Vec<String>>())
    }

    #[inline(never)]
    fn depends_states(self, states: &[String]) -> Self {
        self.each(|v| {
            let its: Vec<_> = states.iter().map(|state| v.numbered(state)).collect();
            v.depends_on_states.get_or_insert_default().extend(its);
        })
    }

    /// The field from which the model reads the slope of an input (its unit per second). The host sets it with
    /// `fmi2SetRealInputDerivatives` for the next step; after that step the input stands at the ramp's end and the slope
    /// is zero again.
    pub fn ramp(self, field: impl Fn(&mut M) -> &mut f64 + Send + Sync + 'static) -> Self {
        let field: Lens<M, f64> = Arc::new(field);
        self.each(|v| v.ramp = Some(Arc::clone(&field)))
    }

    /// As [`ramp`](Self::ramp), for the elements of an array.
    pub fn ramp_array(self, field: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static) -> Self
    where
        M: Default,
    {
        self.elements("slopes", field, |v, lens| v.ramp = Some(lens))
    }

    /// The field in which `evaluation` leaves the time derivative of an output, for `fmi2GetRealOutputDerivatives`.
    pub fn rate(self, evaluation: Evaluation, field: impl Fn(&mut M) -> &mut f64 + Send + Sync + 'static) -> Self {
        let field: Lens<M, f64> = Arc::new(field);
        self.each(|v| v.rate = Some((Arc::clone(&field), evaluation)))
    }

    /// As [`rate`](Self::rate), for the elements of an array.
    pub fn rate_array(
        self,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
    ) -> Self
    where
        M: Default,
    {
        self.elements("rates", field, |v, lens| v.rate = Some((lens, evaluation)))
    }

    /// Gives each variable its element of an array.
    fn elements(
        self,
        what: &str,
        field: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
        mut give: impl FnMut(&mut Variable<M>, Lens<M, f64>),
    ) -> Self
    where
        M: Default,
    {
        let (length, count) = (field(&mut M::default()).len(), self.variables.len());
        let field = Arc::new(field);
        for (i, variable) in self.variables.iter_mut().enumerate() {
            let field = Arc::clone(&field);
            give(variable, Arc::new(move |model| &mut field(model)[i]));
            if length != count {
                variable.mistakes.push(format!("it is one of {count}, but there are {length} {what}"));
            }
        }
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
        *self.exchange = Some(Exchange::of());
        self.each(|v| v.is_state = true)
    }

    /// Says of which continuous state this output or local variable is the time derivative. For an array, `{}` stands for the
    /// element's number, counted from 1.
    ///
    /// It depends on all inputs and all states, unless [`depends_on`](Self::depends_on) and
    /// [`depends_on_states`](Self::depends_on_states) say less.
    pub fn derivative_of(self, state: &str) -> Self {
        self.each(|v| v.derivative_of = Some(v.numbered(state)))
    }
}

impl<M> Variable<M> {
    /// A text in which `{}` stands for the variable's number, if it has one.
    fn numbered(&self, text: &str) -> String {
        self.number.map_or_else(|| text.to_owned(), |number| numbered(text, number))
    }
}
