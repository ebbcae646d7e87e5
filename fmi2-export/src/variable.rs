//! Declaring variables: each once, by name and by the field of the model's struct it lives in.

use std::sync::Arc;

use crate::access::{Access, Lens, Scalar};
use crate::unit::{DisplayUnit, Unit, UnitError};

/// The variables of a model, as [`Model::variables`](crate::Model::variables) declares them.
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
pub struct Variables<M> {
    pub(crate) list: Vec<Variable<M>>,
    pub(crate) evaluations: Vec<fn(&mut M)>,
}

/// A function of the model that fills in some of its outputs: see [`Variables::evaluation`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Evaluation(pub(crate) usize);

/// What a variable is to the outside (FMI 2.0.4, section 2.2.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Set by the host, constant (or a ramp) over a step.
    Input,
    /// Computed by the model, wired to others.
    Output,
    /// Computed by the model, for looking at only.
    Local,
    /// Set by the host before the simulation starts and, if tunable, between steps.
    Parameter,
}

/// When a variable may change (FMI 2.0.4, section 2.2.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Not after initialization.
    Fixed,
    /// Between steps.
    Tunable,
    /// At communication points only.
    Discrete,
    /// At any time.
    Continuous,
}

/// How an output depends on an input (`dependenciesKind`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DependencyKind {
    /// In any way.
    Dependent,
    /// Linearly, with a factor that is fixed once the parameters are.
    Fixed,
}

pub(crate) struct Variable<M> {
    pub name: String,
    pub description: String,
    pub causality: Causality,
    pub variability: Variability,
    pub access: Access<M>,
    pub unit: Option<Unit>,
    pub unit_error: Option<UnitError>,
    pub display_unit: Option<DisplayUnit>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub nominal: Option<f64>,
    pub depends_on: Vec<(String, DependencyKind)>,
    /// Further inputs it depends on in initialization mode, through the initial state.
    pub starts_from: Vec<String>,
    pub evaluation: Option<Evaluation>,
    /// Where the model reads the slope of an input from.
    pub ramp: Option<Lens<M, f64>>,
    /// Where the model writes the time derivative of an output, and what computes it.
    pub rate: Option<(Lens<M, f64>, Evaluation)>,
}

impl<M: 'static> Variables<M> {
    pub(crate) fn new() -> Self {
        Self { list: Vec::new(), evaluations: Vec::new() }
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

    /// Declares an input. A number is continuous, anything else discrete.
    pub fn input<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.add(name, Causality::Input, T::access(field), None)
    }

    /// Declares an output that `evaluation` computes.
    pub fn output<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.add(name, Causality::Output, T::access(field), Some(evaluation))
    }

    /// Declares a local variable that `evaluation` computes: visible, but not meant to be wired.
    pub fn local<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.add(name, Causality::Local, T::access(field), Some(evaluation))
    }

    /// Declares the elements of an array as outputs `name[1]`, `name[2]`, …; the start value's length counts.
    pub fn output_array(
        &mut self,
        name: &str,
        evaluation: Evaluation,
        field: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M>
    where
        M: Default,
    {
        let first = self.list.len();
        let length = field(&mut M::default()).len();
        let field = Arc::new(field);
        for i in 0..length {
            let field = Arc::clone(&field);
            let access = Access::Real(Arc::new(move |model| &mut field(model)[i]));
            self.add(format!("{name}[{}]", i + 1), Causality::Output, access, Some(evaluation));
        }
        VariableBuilder { variables: &mut self.list[first..] }
    }

    /// Declares a parameter that is fixed once initialization mode has been left.
    pub fn parameter<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        self.add(name, Causality::Parameter, T::access(field), None)
    }

    /// Declares a parameter that the host may also change between steps.
    pub fn tunable<T: Scalar>(
        &mut self,
        name: impl Into<String>,
        field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static,
    ) -> VariableBuilder<'_, M> {
        let builder = self.add(name, Causality::Parameter, T::access(field), None);
        for variable in &mut *builder.variables {
            variable.variability = Variability::Tunable;
        }
        builder
    }

    fn add(
        &mut self,
        name: impl Into<String>,
        causality: Causality,
        access: Access<M>,
        evaluation: Option<Evaluation>,
    ) -> VariableBuilder<'_, M> {
        let variability = match (causality, &access) {
            (Causality::Parameter, _) => Variability::Fixed,
            (_, Access::Real(_)) => Variability::Continuous,
            _ => Variability::Discrete,
        };
        self.list.push(Variable {
            name: name.into(),
            description: String::new(),
            causality,
            variability,
            access,
            unit: None,
            unit_error: None,
            display_unit: None,
            min: None,
            max: None,
            nominal: None,
            depends_on: Vec::new(),
            starts_from: Vec::new(),
            evaluation,
            ramp: None,
            rate: None,
        });
        let last = self.list.len() - 1;
        VariableBuilder { variables: &mut self.list[last..] }
    }
}

/// Says more about a variable, or about all elements of an array.
pub struct VariableBuilder<'a, M> {
    variables: &'a mut [Variable<M>],
}

// Builder methods return the builder for chaining; ending a chain anywhere is fine.
#[allow(clippy::return_self_not_must_use, clippy::must_use_candidate)]
impl<M: 'static> VariableBuilder<'_, M> {
    fn each(self, mut change: impl FnMut(&mut Variable<M>)) -> Self {
        self.variables.iter_mut().for_each(&mut change);
        self
    }

    /// What the variable is, in one line. Required.
    pub fn description(self, text: &str) -> Self {
        self.descriptions(|_| text.to_owned())
    }

    /// What each element of an array is, in one line, from its index counted from 0.
    pub fn descriptions(self, text: impl Fn(usize) -> String) -> Self {
        for (i, variable) in self.variables.iter_mut().enumerate() {
            variable.description = text(i);
        }
        self
    }

    /// The unit of a number, as an expression of SI units such as `N.m` or `1/(m2.s)`: see [`Unit`].
    pub fn unit(self, expression: &str) -> Self {
        self.each(|v| match expression.parse() {
            Ok(unit) => v.unit = Some(unit),
            Err(error) => v.unit_error = Some(error),
        })
    }

    /// The unit of a number, if it is no expression of coherent SI units.
    pub fn other_unit(self, unit: &Unit) -> Self {
        self.each(|v| v.unit = Some(unit.clone()))
    }

    /// The unit in which tools should show the number to people: `factor` times as many of them, e.g. deg and 180/π for
    /// a number in rad.
    pub fn display_unit(self, name: &str, factor: f64) -> Self {
        self.each(|v| v.display_unit = Some(DisplayUnit { name: name.to_owned(), factor }))
    }

    /// The admissible range, both ends included; an infinite end is none. Values outside it are refused.
    pub fn range(self, min: f64, max: f64) -> Self {
        let (min, max) = (Some(min).filter(|v| *v != f64::NEG_INFINITY), Some(max).filter(|v| *v != f64::INFINITY));
        self.each(|v| (v.min, v.max) = (min, max))
    }

    /// The least admissible value.
    pub fn min(self, min: f64) -> Self {
        self.each(|v| v.min = Some(min).filter(|v| *v != f64::NEG_INFINITY))
    }

    /// The order of magnitude of a number.
    pub fn nominal(self, nominal: f64) -> Self {
        self.each(|v| v.nominal = Some(nominal))
    }

    /// The inputs an output depends on *directly*: those that change it without a step in between. Without this, none.
    pub fn depends_on<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        self.depends(inputs, DependencyKind::Dependent)
    }

    /// Inputs an output depends on directly and linearly, with a factor fixed once the parameters are.
    pub fn depends_linearly_on<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        self.depends(inputs, DependencyKind::Fixed)
    }

    fn depends<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>, kind: DependencyKind) -> Self {
        let inputs: Vec<(String, DependencyKind)> = inputs.into_iter().map(|name| (name.into(), kind)).collect();
        self.each(|v| v.depends_on.extend(inputs.iter().cloned()))
    }

    /// Inputs from which the output's *initial* value follows through the initial state: those that
    /// [`Model::initialize`](crate::Model::initialize) reads. They are listed in `InitialUnknowns`, besides all parameters
    /// and the inputs it [depends on](Self::depends_on) directly.
    pub fn starts_from<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        let inputs: Vec<String> = inputs.into_iter().map(Into::into).collect();
        self.each(|v| v.starts_from.extend(inputs.iter().cloned()))
    }

    /// The field from which the model reads the slope of an input (its unit per second). The host sets it with
    /// `fmi2SetRealInputDerivatives` for the next step; after that step the input stands at the ramp's end and the slope
    /// is zero again.
    pub fn ramp(self, field: impl Fn(&mut M) -> &mut f64 + Send + Sync + 'static) -> Self {
        let field: Lens<M, f64> = Arc::new(field);
        self.each(|v| v.ramp = Some(Arc::clone(&field)))
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
    ) -> Self {
        let field = Arc::new(field);
        for (i, variable) in self.variables.iter_mut().enumerate() {
            let field = Arc::clone(&field);
            variable.rate = Some((Arc::new(move |model| &mut field(model)[i]), evaluation));
        }
        self
    }
}
