//! What there is to say about a model's interface, whatever the model's type: `modelDescription.xml` and the page of
//! documentation are both written from it.

use crate::access::{Access, EnumerationKind};
use crate::any_model::fresh;
use crate::info::Info;
use crate::layout::{DeclarationError, Layout, Reference};
use crate::model::Model;
use crate::unit::{DisplayUnit, Unit};
use crate::variable::{Causality, DependencyKind, Variability, Variable};
use crate::view::Value;

/// A model's interface.
#[derive(Debug)]
pub struct Interface {
    /// Name, version and the like.
    pub info: Info,
    /// In the order of their declaration.
    pub variables: Vec<VariableFacts>,
    /// All that its variables have.
    pub enumerations: Vec<EnumerationKind>,
    /// Some inputs can be ramps over a step.
    pub interpolates_inputs: bool,
    /// Some outputs have time derivatives.
    pub has_rates: bool,
    /// What it offers a host that integrates, if anything.
    pub exchange: Option<ExchangeFacts>,
}

/// What there is to say about a model that a host can integrate.
#[derive(Debug)]
pub struct ExchangeFacts {
    /// Places among the variables of the continuous states, in their order, each with that of its time derivative.
    pub states: Vec<(usize, usize)>,
    /// How many event indicators there are.
    pub event_indicators: usize,
    /// The host need not say when a step is completed.
    pub completed_step_not_needed: bool,
}

/// What there is to say about a variable.
#[derive(Debug)]
pub struct VariableFacts {
    /// Name.
    pub name: String,
    /// What it is.
    pub description: String,
    /// Who gives its value.
    pub causality: Causality,
    /// When its value changes.
    pub variability: Variability,
    /// Type.
    pub kind: Kind,
    pub(crate) reference: Reference,
    /// Unit of its values.
    pub unit: Option<Unit>,
    /// Unit in which people are shown its values.
    pub display_unit: Option<DisplayUnit>,
    /// Least value.
    pub min: Option<f64>,
    /// Greatest value.
    pub max: Option<f64>,
    /// Order of magnitude.
    pub nominal: Option<f64>,
    /// The start value as XML has it, if it is given rather than computed.
    pub start: Option<String>,
    /// Inputs it follows at once.
    pub depends_on: Vec<(String, DependencyKind)>,
    /// Inputs that its initial value follows from besides.
    pub starts_from: Vec<String>,
    /// It is a continuous state.
    pub is_state: bool,
    /// The state whose time derivative it is.
    pub derivative_of: Option<String>,
    /// States it follows at once, if they are not all of them.
    pub depends_on_states: Option<Vec<String>>,
}

/// The type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `f64`.
    Real,
    /// An integer of 32 bits.
    Integer,
    /// `bool`.
    Boolean,
    /// Text.
    String,
    /// One of a list of names.
    Enumeration(EnumerationKind),
}

impl Interface {
    pub(crate) fn of<M: Model>() -> Result<Self, DeclarationError> {
        let (layout, mut model) = (Layout::build::<M>()?, fresh::<M>());
        let place = |reference: u32| layout.reals[reference as usize].variable as usize;
        let mut defaults = layout.view(&mut *model);
        let variables = layout.variables.iter().zip(&layout.references).enumerate();
        let facts = |(i, (variable, reference)): (usize, (&Variable, &Reference))| {
            facts(variable, *reference, defaults.value(i))
        };
        Ok(Self {
            info: layout.info,
            variables: variables.map(facts).collect(),
            enumerations: layout.enumerations.clone(),
            interpolates_inputs: !layout.ramps.is_empty(),
            has_rates: layout.has_rates(),
            exchange: layout.continuous.as_ref().map(|continuous| ExchangeFacts {
                states: continuous.states.iter().map(|slot| (place(slot.state), place(slot.derivative))).collect(),
                event_indicators: continuous.indicator_count,
                completed_step_not_needed: !continuous.exchange.completes_steps,
            }),
        })
    }
}

fn facts(variable: &Variable, reference: Reference, start: Value<'_>) -> VariableFacts {
    let kind = match &variable.access {
        Access::Real(_) => Kind::Real,
        Access::Integer(..) => Kind::Integer,
        Access::Enumeration(.., kind) => Kind::Enumeration(*kind),
        Access::Boolean(_) => Kind::Boolean,
        Access::String(_) => Kind::String,
    };
    let start = match start {
        Value::Real(value) => number(value),
        Value::Integer(value) | Value::Enumeration(value) => whole(value),
        Value::Boolean(value) => value.to_string(),
        Value::String(value) => value.to_owned(),
    };
    let is_given = matches!(variable.causality, Causality::Input | Causality::Parameter);
    VariableFacts {
        name: variable.name.clone(),
        description: variable.description.clone(),
        causality: variable.causality,
        variability: variable.variability,
        kind,
        reference,
        unit: variable.unit.clone(),
        display_unit: variable.display_unit.clone(),
        min: variable.min,
        max: variable.max,
        nominal: variable.nominal,
        start: is_given.then_some(start),
        depends_on: variable.depends_on.clone(),
        starts_from: variable.starts_from.clone(),
        is_state: variable.is_state,
        derivative_of: variable.derivative_of.clone(),
        depends_on_states: variable.depends_on_states.clone(),
    }
}

/// A start value that has been checked, or the value of an output, which nobody looks at.
fn whole(value: Result<i32, String>) -> String {
    value.map_or_else(|_| String::new(), |value| value.to_string())
}

impl VariableFacts {
    /// An end of the range, or another number, as XML has it.
    #[must_use]
    pub fn number(&self, value: f64) -> String {
        if self.kind == Kind::Integer { format!("{value:.0}") } else { number(value) }
    }
}

impl Causality {
    /// As XML has it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Output => "output",
            Self::Local => "local",
            Self::Parameter => "parameter",
        }
    }
}

impl Variability {
    /// As XML has it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Tunable => "tunable",
            Self::Discrete => "discrete",
            Self::Continuous => "continuous",
        }
    }
}

/// Shortest text that reads back as the same number: `0.5`, `1e-7`.
#[must_use]
pub fn number(value: f64) -> String {
    format!("{value:?}")
}
