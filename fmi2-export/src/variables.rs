//! Declaring variables: each once, by name and by the field of the model's struct it lives in.

use std::any::TypeId;
use std::marker::PhantomData;
use std::ptr;
use std::sync::Arc;

use parameter_table::{Owner, Parameter};

use crate::access::{Access, Scalar, Shape};
use crate::builder::VariableBuilder;
use crate::declarations::{Declarations, Indicators, Role};
use crate::exchange::{Exchange, ModelExchange};
use crate::place::{Field, Place};
use crate::variable::Causality;

/// The variables of a model, as [`Declare::variables`](crate::Declare::variables) declares them.
///
/// ```
/// # use fmi2_export::Variables;
/// # #[derive(Default)] struct Lag { u: f64, y: f64, time_constant: f64, x: f64 }
/// # impl Lag { fn outputs(&mut self) { self.y = self.x } }
/// # fn variables(variables: &mut Variables<Lag>) {
/// let outputs = variables.evaluation(Lag::outputs);
/// variables.input("u", |m| &mut m.u).description("Input");
/// variables.output("y", outputs, |m| &mut m.y).description("Output");
/// variables.parameter("T", |m| &mut m.time_constant).description("Time constant").unit("s").range(1e-6, 1e6);
/// # }
/// ```
///
/// # Arrays
/// A slice of fields becomes as many variables as it has elements in the model's default value. In their name and
/// description, and in the names of inputs they depend on, `{}` stands for the element's number, counted from 1; a name
/// without it gets the number in brackets: `w` gives `w[1]`, `w[2]`, …
///
/// ```
/// # use fmi2_export::Variables;
/// # #[derive(Default)] struct Arms { command: [f64; 2], torque: [f64; 2] }
/// # impl Arms { fn outputs(&mut self) { self.torque = self.command } }
/// # fn variables(variables: &mut Variables<Arms>) {
/// let outputs = variables.evaluation(Arms::outputs);
/// variables.input_array("tau{}_cmd", |m| &mut m.command).unit("N.m").description("Commanded torque on hub {}");
/// variables
///     .output_array("tau{}", outputs, |m| &mut m.torque)
///     .unit("N.m")
///     .depends_on(["tau{}_cmd"])
///     .description("Torque that actuator {} delivers");
/// # }
/// ```
///
/// # Fields
/// A variable that always is at the same place in the struct, as most are, can also be declared by
/// [`field!`](crate::field) instead of a function. It then is read and written without a call, which matters for what is exchanged at
/// every step; the description of the model is the same. [`derive(Declare)`](macro@crate::Declare) does so.
///
/// # Parts
/// What several models have alike can be a struct of its own, whose variables are declared by one function, compiled once: see
/// [`part`](Self::part).
#[repr(transparent)]
pub struct Variables<M> {
    pub(crate) declared: Declarations,
    model: PhantomData<fn(&mut M)>,
}

/// A function of the model that fills in some of its outputs: see [`Variables::evaluation`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Evaluation(pub(crate) usize);

impl<M: 'static> Variables<M> {
    pub(crate) fn new(declared: Declarations) -> Self {
        Self { declared, model: PhantomData }
    }

    /// Declares a function that computes some of the outputs from the state, the parameters and the inputs.
    ///
    /// It is called when the host asks for one of those outputs and something they depend on has changed. Outputs that
    /// are cheap and wanted every step should not share an evaluation with outputs that are expensive and rarely looked
    /// at. At most 64 evaluations.
    pub fn evaluation(&mut self, evaluation: fn(&mut M)) -> Evaluation {
        self.declared.evaluation(evaluation)
    }

    /// Declares the field from which the model reads the time \[s\]: for models whose derivatives, event indicators or outputs
    /// depend on it. It is no variable. In
    /// model exchange it is always current; in co-simulation it is the start time at first, and the step moves it on, as
    /// that of `fmi2-integrate` does.
    pub fn time(&mut self, field: impl Fn(&mut M) -> &mut f64 + Send + Sync + 'static) {
        self.declared.time(Place::by(field));
    }

    /// Declares the variables of a part of the model. The function that does it need not know the model, so that several models can have
    /// it. Evaluations, states and event indicators are the whole model's; what the part's outputs need of them is declared before.
    ///
    /// ```
    /// # use fmi2_export::{Evaluation, Variables, field};
    /// # #[derive(Default)] struct Pump { signals: Signals }
    /// # impl Pump { fn outputs(&mut self) { self.signals.pressure = self.signals.speed } }
    /// #[derive(Default)]
    /// struct Signals { speed: f64, pressure: f64 }
    ///
    /// fn signals(variables: &mut Variables<Signals>, outputs: Evaluation) {
    ///     variables.input_field("speed", field!(Signals, speed)).description("Speed").unit("rad/s");
    ///     variables.output_field("pressure", outputs, field!(Signals, pressure)).description("Pressure").unit("Pa");
    /// }
    ///
    /// # fn variables(variables: &mut Variables<Pump>) {
    /// let outputs = variables.evaluation(Pump::outputs);
    /// variables.part(field!(Pump, signals), |part| signals(part, outputs));
    /// # }
    /// ```
    ///
    /// # Panics
    /// If the function declares what is the whole model's.
    pub fn part<P: 'static>(&mut self, part: Field<M, P>, mut declare: impl FnMut(&mut Variables<P>)) {
        self.declared.part(TypeId::of::<P>(), part.offset(), &mut |declared| {
            // SAFETY: transparent, whatever the type of the model.
            declare(unsafe { &mut *ptr::from_mut(declared).cast::<Variables<P>>() });
        });
    }

    /// Declares an input. A number is continuous unless it is said to be [`discrete`](VariableBuilder::discrete),
    /// anything else is discrete.
    pub fn input<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.one(Role::INPUT, text(name), Place::by(field), T::access)
    }

    /// Declares the elements of an array as inputs.
    pub fn input_array<T: Scalar>(
        &mut self,
        name: &str,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.array(Role::INPUT, name, field)
    }

    /// Declares a field as an input, or the elements of one that is an array.
    pub fn input_field<T: Shape>(&mut self, name: &str, field: Field<M, T>) -> VariableBuilder<'_, M> {
        self.field(Role::INPUT, name, field)
    }

    /// Declares an output that `evaluation` computes.
    pub fn output<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.one(Role::computed(Causality::Output, evaluation), text(name), Place::by(field), T::access)
    }

    /// Declares the elements of an array as outputs that `evaluation` computes.
    pub fn output_array<T: Scalar>(
        &mut self,
        name: &str,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.array(Role::computed(Causality::Output, evaluation), name, field)
    }

    /// Declares a field as an output that `evaluation` computes, or the elements of one that is an array.
    pub fn output_field<T: Shape>(
        &mut self,
        name: &str,
        evaluation: Evaluation,
        field: Field<M, T>,
    ) -> VariableBuilder<'_, M> {
        self.field(Role::computed(Causality::Output, evaluation), name, field)
    }

    /// Declares a local variable that `evaluation` computes: visible, but not meant to be wired.
    pub fn local<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.one(Role::computed(Causality::Local, evaluation), text(name), Place::by(field), T::access)
    }

    /// Declares the elements of an array as local variables that `evaluation` computes.
    pub fn local_array<T: Scalar>(
        &mut self,
        name: &str,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.array(Role::computed(Causality::Local, evaluation), name, field)
    }

    /// Declares a field as a local variable that `evaluation` computes, or the elements of one that is an array.
    pub fn local_field<T: Shape>(
        &mut self,
        name: &str,
        evaluation: Evaluation,
        field: Field<M, T>,
    ) -> VariableBuilder<'_, M> {
        self.field(Role::computed(Causality::Local, evaluation), name, field)
    }

    /// Declares a parameter. It is fixed once initialization mode has been left, unless it is said to be
    /// [`tunable`](VariableBuilder::tunable).
    pub fn parameter<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.one(Role::PARAMETER, text(name), Place::by(field), T::access)
    }

    /// Declares the elements of an array as parameters.
    pub fn parameter_array<T: Scalar>(
        &mut self,
        name: &str,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.array(Role::PARAMETER, name, field)
    }

    /// Declares a field as a parameter, or the elements of one that is an array.
    pub fn parameter_field<T: Shape>(&mut self, name: &str, field: Field<M, T>) -> VariableBuilder<'_, M> {
        self.field(Role::PARAMETER, name, field)
    }

    /// Declares a table of parameters of one part of the model.
    pub fn parameters<T: 'static>(
        &mut self,
        table: &[Parameter<T>],
        part: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.parameters_of(Owner::ALONE, table, part)
    }

    /// Declares a table of parameters of one part of the model, which `{}` in the table stands for.
    pub fn parameters_of<T: 'static>(
        &mut self,
        owner: Owner<'_>,
        table: &[Parameter<T>],
        part: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        let first = self.declared.list.len();
        self.declared.rows(table, owner, None, &Place::by(part));
        self.since(first)
    }

    /// Declares a table of parameters for each of several parts of the model, whose numbers, from 1, `{}` in the table stands
    /// for: all of the first part, then all of the second, and so on.
    pub fn parameter_family<T: 'static>(
        &mut self,
        table: &[Parameter<T>],
        parts: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        let first = self.declared.list.len();
        let count = length(&mut self.declared, &parts);
        self.declared.family(&Place::array(parts), count, size_of::<T>(), &mut |declared, owner, number, part| {
            declared.rows(table, owner, number, part);
        });
        self.since(first)
    }

    fn one(&mut self, role: Role, name: String, place: Place, access: fn(Place) -> Access) -> VariableBuilder<'_, M> {
        let first = self.declared.one(name, role, place, access);
        self.since(first)
    }

    fn array<T: Scalar>(
        &mut self,
        role: Role,
        name: &str,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        let length = length(&mut self.declared, &field);
        let first = self.declared.elements(name, role, Place::array(field), length, size_of::<T>(), T::access);
        self.since(first)
    }

    fn field<T: Shape>(&mut self, role: Role, name: &str, field: Field<M, T>) -> VariableBuilder<'_, M> {
        let (place, access) = (field.place(), T::Element::access);
        let first = match T::LENGTH {
            Some(length) => self.declared.elements(name, role, place, length, size_of::<T::Element>(), access),
            None => self.declared.one(name.to_owned(), role, place, access),
        };
        self.since(first)
    }

    /// What has been declared since there were `first` variables.
    fn since(&mut self, first: usize) -> VariableBuilder<'_, M> {
        VariableBuilder { declared: &mut self.declared, first, model: PhantomData }
    }
}

impl<M: ModelExchange> Variables<M> {
    /// Offers model exchange, also of a model without continuous states: declaring a [state](VariableBuilder::state) or
    /// [event indicators](Self::event_indicators) implies it.
    pub fn model_exchange(&mut self) {
        self.declared.offer(Exchange::of::<M>());
    }

    /// Declares the field in which `evaluation` leaves the event indicators, as many as it has elements in the model's default
    /// value. Where one of them passes through zero, something in the model changes abruptly: the host finds the time and calls
    /// [`ModelExchange::new_discrete_states`].
    pub fn event_indicators(
        &mut self,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
    ) {
        self.model_exchange();
        let count = length(&mut self.declared, &field);
        // SAFETY: it is called with models of this type only: see `View`.
        let array = Arc::new(move |model: *mut ()| ptr::from_mut(field(unsafe { &mut *model.cast::<M>() })));
        self.declared.indicators = Some(Indicators { evaluation, array, count });
    }
}

/// How many elements an array has in the model's default value.
pub(crate) fn length<M: 'static, T>(declared: &mut Declarations, field: &impl Fn(&mut M) -> &mut [T]) -> usize {
    field(declared.sample::<M>()).len()
}

#[inline(never)]
fn text(text: impl Into<String>) -> String {
    text.into()
}
