//! Declaring variables: each once, by name and by the field of the model's struct it lives in.

use std::sync::Arc;

use parameter_table::{Owner, Parameter};

use crate::access::{Access, Lens, Scalar};
use crate::builder::VariableBuilder;
use crate::exchange::{Exchange, ModelExchange};
use crate::variable::{Causality, Variability, Variable};

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
pub struct Variables<M> {
    pub(crate) list: Vec<Variable<M>>,
    pub(crate) evaluations: Vec<fn(&mut M)>,
    /// What a host that integrates calls, once anything of it has been declared.
    pub(crate) exchange: Option<Exchange<M>>,
    pub(crate) indicators: Option<Indicators<M>>,
    pub(crate) time: Option<Lens<M, f64>>,
}

/// What fills in the event indicators, and where they are.
pub(crate) struct Indicators<M> {
    pub evaluation: Evaluation,
    pub lens: Lens<M, [f64]>,
}

/// A function of the model that fills in some of its outputs: see [`Variables::evaluation`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Evaluation(pub(crate) usize);

/// What a variable is to the host, and what computes it.
#[derive(Clone, Copy)]
struct Role {
    causality: Causality,
    /// Of numbers; whatever is no number can only jump.
    variability: Variability,
    evaluation: Option<Evaluation>,
}

impl Role {
    const INPUT: Self = Self { causality: Causality::Input, variability: Variability::Continuous, evaluation: None };
    const PARAMETER: Self = Self { causality: Causality::Parameter, variability: Variability::Fixed, evaluation: None };

    const fn computed(causality: Causality, evaluation: Evaluation) -> Self {
        Self { causality, variability: Variability::Continuous, evaluation: Some(evaluation) }
    }
}

impl<M: 'static> Variables<M> {
    pub(crate) fn new() -> Self {
        Self { list: Vec::new(), evaluations: Vec::new(), exchange: None, indicators: None, time: None }
    }

    /// Declares a function that computes some of the outputs from the state, the parameters and the inputs.
    ///
    /// It is called when the host asks for one of those outputs and something they depend on has changed. Outputs that
    /// are cheap and wanted every step should not share an evaluation with outputs that are expensive and rarely looked
    /// at. At most 64 evaluations.
    pub fn evaluation(&mut self, evaluation: fn(&mut M)) -> Evaluation {
        self.evaluations.push(evaluation);
        Evaluation(self.evaluations.len() - 1)
    }

    /// Declares the field from which the model reads the time \[s\]: for models whose derivatives, event indicators or outputs
    /// depend on it. It is no variable. In
    /// model exchange it is always current; in co-simulation it is the start time at first, and the step moves it on, as
    /// that of `fmi2-integrate` does.
    pub fn time(&mut self, field: impl Fn(&mut M) -> &mut f64 + Send + Sync + 'static) {
        self.time = Some(Arc::new(field));
    }

    /// Declares an input. A number is continuous unless it is said to be [`discrete`](VariableBuilder::discrete),
    /// anything else is discrete.
    pub fn input<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.one(name, Role::INPUT, field)
    }

    /// Declares the elements of an array as inputs.
    pub fn input_array<T: Scalar>(
        &mut self,
        name: &str,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M>
    where
        M: Default,
    {
        self.array(name, Role::INPUT, field)
    }

    /// Declares an output that `evaluation` computes.
    pub fn output<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.one(name, Role::computed(Causality::Output, evaluation), field)
    }

    /// Declares the elements of an array as outputs that `evaluation` computes.
    pub fn output_array<T: Scalar>(
        &mut self,
        name: &str,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M>
    where
        M: Default,
    {
        self.array(name, Role::computed(Causality::Output, evaluation), field)
    }

    /// Declares a local variable that `evaluation` computes: visible, but not meant to be wired.
    pub fn local<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.one(name, Role::computed(Causality::Local, evaluation), field)
    }

    /// Declares the elements of an array as local variables that `evaluation` computes.
    pub fn local_array<T: Scalar>(
        &mut self,
        name: &str,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M>
    where
        M: Default,
    {
        self.array(name, Role::computed(Causality::Local, evaluation), field)
    }

    /// Declares a parameter. It is fixed once initialization mode has been left, unless it is said to be
    /// [`tunable`](VariableBuilder::tunable).
    pub fn parameter<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.one(name, Role::PARAMETER, field)
    }

    /// Declares the elements of an array as parameters.
    pub fn parameter_array<T: Scalar>(
        &mut self,
        name: &str,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M>
    where
        M: Default,
    {
        self.array(name, Role::PARAMETER, field)
    }

    /// Declares a table of parameters of one part of the model.
    pub fn parameters<T: 'static>(
        &mut self,
        table: impl IntoIterator<Item = Parameter<T>>,
        part: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.parameters_of(Owner::ALONE, table, part)
    }

    /// Declares a table of parameters of one part of the model, which `{}` in the table stands for.
    pub fn parameters_of<T: 'static>(
        &mut self,
        owner: Owner<'_>,
        table: impl IntoIterator<Item = Parameter<T>>,
        part: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        let first = self.list.len();
        let part = Arc::new(part);
        for row in table {
            let part = Arc::clone(&part);
            self.row(&row, owner, None, f64::access(move |model| (row.field)(part(model))));
        }
        self.since(first)
    }

    /// Declares a table of parameters for each of several parts of the model, whose numbers, from 1, `{}` in the table stands
    /// for: all of the first part, then all of the second, and so on.
    pub fn parameter_family<T: 'static>(
        &mut self,
        table: impl IntoIterator<Item = Parameter<T>>,
        parts: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M>
    where
        M: Default,
    {
        let first = self.list.len();
        let (table, parts): (Vec<_>, _) = (table.into_iter().collect(), Arc::new(parts));
        for i in 0..parts(&mut M::default()).len() {
            let number = (i + 1).to_string();
            for row in table.iter().copied() {
                let parts = Arc::clone(&parts);
                let access = f64::access(move |model| (row.field)(&mut parts(model)[i]));
                self.row(&row, Owner::named(&number), Some(i + 1), access);
            }
        }
        self.since(first)
    }

    fn one<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        role: Role,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.add(name, None, role, T::access(field))
    }

    fn array<T: Scalar>(
        &mut self,
        name: &str,
        role: Role,
        field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M>
    where
        M: Default,
    {
        let first = self.list.len();
        let length = field(&mut M::default()).len();
        let field = Arc::new(field);
        let pattern = if name.contains("{}") { name.to_owned() } else { format!("{name}[{{}}]") };
        for i in 0..length {
            let field = Arc::clone(&field);
            self.add(numbered(&pattern, i + 1), Some(i + 1), role, T::access(move |model| &mut field(model)[i]));
        }
        self.since(first)
    }

    /// One row of a table, for one part of the model. Not inlined, and without the closure that leads to the field: the
    /// declarations of a model are many such calls.
    #[inline(never)]
    fn row<T>(&mut self, row: &Parameter<T>, owner: Owner<'_>, number: Option<usize>, access: Access<M>) {
        let builder = self.add(row.name_of(owner), number, Role::PARAMETER, access);
        let builder = builder.range(row.range.min, row.range.max).description(&row.description_of(owner));
        if !row.unit.is_empty() {
            builder.unit(&row.unit_of(owner));
        }
    }

    #[inline(never)]
    fn add(
        &mut self,
        name: impl Into<String>,
        number: Option<usize>,
        role: Role,
        access: Access<M>,
    ) -> VariableBuilder<'_, M> {
        let variability = match (role.variability, &access) {
            (Variability::Continuous, Access::Real(_)) => Variability::Continuous,
            (Variability::Continuous, _) => Variability::Discrete,
            (other, _) => other,
        };
        let first = self.list.len();
        self.list.push(Variable {
            name: name.into(),
            number,
            description: String::new(),
            causality: role.causality,
            variability,
            access,
            unit: None,
            display_unit: None,
            min: None,
            max: None,
            nominal: None,
            depends_on: Vec::new(),
            starts_from: Vec::new(),
            evaluation: role.evaluation,
            ramp: None,
            rate: None,
            is_state: false,
            derivative_of: None,
            depends_on_states: None,
            mistakes: Vec::new(),
        });
        self.since(first)
    }

    /// What has been declared since there were `first` variables.
    fn since(&mut self, first: usize) -> VariableBuilder<'_, M> {
        VariableBuilder { variables: &mut self.list[first..], exchange: &mut self.exchange }
    }
}

impl<M: ModelExchange> Variables<M> {
    /// Offers model exchange, also of a model without continuous states: declaring a [state](VariableBuilder::state) or
    /// [event indicators](Self::event_indicators) implies it.
    pub fn model_exchange(&mut self) {
        self.exchange = Some(Exchange::of());
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
        self.indicators = Some(Indicators { evaluation, lens: Arc::new(field) });
    }
}

/// The text for one element of an array.
pub(crate) fn numbered(text: &str, number: usize) -> String {
    text.replace("{}", &number.to_string())
}
