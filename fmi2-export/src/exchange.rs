//! What the author of a model writes besides, if a host shall integrate it: model exchange (FMI 2.0.4, section 3).

use std::fmt;
use std::marker::PhantomData;

use crate::any_model::{AnyModel, typed};
use crate::model::{Experiment, Failure, Model};

/// A model that can also be exported for model exchange: the host has the solver, the model gives time derivatives.
///
/// Continuous states are variables like others: an output or a local variable that is said to be a
/// [`state`](crate::VariableBuilder::state), and another one that is its time derivative
/// ([`derivative_of`](crate::VariableBuilder::derivative_of)). What computes the derivatives is the evaluation of that variable;
/// [event indicators](crate::Variables::event_indicators) likewise have an evaluation that fills them in. An evaluation that
/// cannot compute something leaves NaN, and the host gets `fmi2Discard`: its solver tries a smaller step.
///
/// ```
/// # use fmi2_export::{Declare, Failure, Info, Model, ModelExchange, Step, Variables};
/// # use serde::{Deserialize, Serialize};
/// /// A mass on a spring, ẍ = −x + u.
/// #[derive(Clone, Default, Serialize, Deserialize)]
/// struct Oscillator { u: f64, x: [f64; 2], x_dot: [f64; 2] }
///
/// impl Declare for Oscillator {
///     const INFO: Info = Info { name: "Oscillator", ..Info::new() };
///
///     fn variables(variables: &mut Variables<Self>) {
///         let state = variables.evaluation(|_| {});
///         let rates = variables.evaluation(|m| m.x_dot = [m.x[1], m.u - m.x[0]]);
///         variables.input("u", |m| &mut m.u).description("Force");
///         variables.output_array("x", state, |m| &mut m.x).state().description("Position and velocity");
///         variables
///             .local_array("der(x[{}])", rates, |m| &mut m.x_dot)
///             .derivative_of("x[{}]")
///             .description("Time derivative of x[{}]");
///     }
/// }
///
/// impl Model for Oscillator {
/// #    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
/// #        // A stand-in for what `fmi2-integrate` offers.
/// #        let _ = step;
/// #        Ok(())
/// #    }
/// # }
/// # #[cfg(any())]
/// # impl Model for Oscillator {
///     fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
///         step.integrate(self) // of the crate `fmi2-integrate`
///     }
/// }
///
/// impl ModelExchange for Oscillator {}
///
/// let xml = fmi2_export::describe::<Oscillator>().unwrap().xml;
/// assert!(xml.contains("<ModelExchange modelIdentifier=\"Oscillator\""));
/// ```
///
/// A model for model exchange always has co-simulation, too. If it has no step of its own, the crate `fmi2-integrate` makes it.
pub trait ModelExchange: Model {
    /// Whether [`step_completed`](Self::step_completed) does anything: otherwise hosts are told not to call it.
    const COMPLETES_STEPS: bool = false;

    /// Computes the initial state, as [`Model::initialize`], in an instance for model exchange: for models that offer less then,
    /// since the number of states is fixed.
    ///
    /// # Errors
    /// If the parameters admit no initial state.
    fn initialize_exchange(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        self.initialize(experiment)
    }

    /// The fields of the continuous states have been set to finite numbers: for models that keep their state in another form.
    ///
    /// # Errors
    /// If the model cannot have these states; it must be as it was before then. The host gets `fmi2Discard`, and the fields their
    /// old values.
    fn states_set(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    /// Something may have happened: an event indicator has changed its sign, a time event has come, an input has jumped, or
    /// nothing at all. Brings the discrete states up to date, and sets the fields of continuous states that jump.
    ///
    /// Called once more with the same inputs and states, it must find nothing new, unless it asks to be called
    /// [again](EventUpdate::again).
    ///
    /// # Errors
    /// If the model cannot go on; the instance is at its end then.
    fn new_discrete_states(&mut self, moment: &mut Moment<'_>) -> Result<EventUpdate, Failure> {
        let _ = moment;
        Ok(EventUpdate::default())
    }

    /// The host's solver has accepted a step: the states that are set will not be taken back. Only called if
    /// [`COMPLETES_STEPS`](Self::COMPLETES_STEPS) says so, and by hosts that call it anyway.
    ///
    /// # Errors
    /// If the model cannot go on; the instance is at its end then.
    fn step_completed(&mut self, moment: &mut Moment<'_>) -> Result<Completed, Failure> {
        let _ = moment;
        Ok(Completed::Continue)
    }

    /// Directional derivative of the states' time derivatives and of the outputs, with respect to states and inputs: on entry the
    /// fields of `direction` that are inputs or states hold the seed and all others zero, on exit those of outputs and of time
    /// derivatives hold the results.
    ///
    /// Only called if [`Info::directional_derivatives`](crate::Info::directional_derivatives) is set, and where a state or the
    /// time derivative of one is involved: else [`Model::directional_derivative`] is.
    fn jacobian_product(&mut self, direction: &mut Self) {
        self.directional_derivative(direction);
    }
}

/// What bringing the discrete states up to date has led to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EventUpdate {
    /// The host shall call once more, after it has passed outputs on.
    pub again: bool,
    /// The simulation is at its end.
    pub terminate: bool,
    /// When the next event comes for certain (s), if one does. Infinity is as good as none; NaN is a failure.
    pub next_time: Option<f64>,
}

/// What follows from a completed step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Completed {
    /// Nothing.
    #[default]
    Continue,
    /// The host shall enter event mode.
    EnterEventMode,
    /// The simulation is at its end.
    Terminate,
}

/// A point in time at which the host tells the model something.
pub struct Moment<'a> {
    /// When it is (s).
    pub time: f64,
    pub(crate) warn: &'a mut dyn FnMut(fmt::Arguments<'_>),
}

impl<'a> Moment<'a> {
    /// One outside of any host, for tests; warnings go to `warn`.
    pub fn new(time: f64, warn: &'a mut dyn FnMut(fmt::Arguments<'_>)) -> Self {
        Self { time, warn }
    }

    /// Tells the host's user something, as [`Step::warn`](crate::Step::warn).
    pub fn warn(&mut self, message: fmt::Arguments<'_>) {
        (self.warn)(message);
    }
}

/// The functions of [`ModelExchange`], for code that does not know the model's type.
pub(crate) struct Exchange {
    pub initialize: fn(&mut dyn AnyModel, &Experiment) -> Result<(), Failure>,
    pub states_set: fn(&mut dyn AnyModel) -> Result<(), Failure>,
    pub new_discrete_states: fn(&mut dyn AnyModel, &mut Moment<'_>) -> Result<EventUpdate, Failure>,
    pub step_completed: fn(&mut dyn AnyModel, &mut Moment<'_>) -> Result<Completed, Failure>,
    pub jacobian_product: fn(&mut dyn AnyModel, &mut dyn AnyModel),
    pub completes_steps: bool,
}

/// The functions of a model.
struct Of<M>(PhantomData<M>);

impl<M: ModelExchange> Of<M> {
    const EXCHANGE: &'static Exchange = &Exchange {
        initialize: |model, experiment| typed::<M>(model).initialize_exchange(experiment),
        states_set: |model| typed::<M>(model).states_set(),
        new_discrete_states: |model, moment| typed::<M>(model).new_discrete_states(moment),
        step_completed: |model, moment| typed::<M>(model).step_completed(moment),
        jacobian_product: |model, direction| typed::<M>(model).jacobian_product(typed(direction)),
        completes_steps: M::COMPLETES_STEPS,
    };
}

impl Exchange {
    pub fn of<M: ModelExchange>() -> &'static Self {
        Of::<M>::EXCHANGE
    }
}
