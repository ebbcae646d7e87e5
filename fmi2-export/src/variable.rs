//! What there is to say of one variable.

use crate::access::Access;
use crate::place::Place;
use crate::unit::{DisplayUnit, Unit};
use crate::variables::Evaluation;

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

impl Causality {
    /// A bit of its own, below the seventh.
    pub(crate) const fn bit(self) -> u8 {
        1 << self as u8
    }
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

pub(crate) struct Variable {
    pub name: String,
    /// Which element of an array it is, counted from 1.
    pub number: Option<usize>,
    pub description: String,
    pub causality: Causality,
    pub variability: Variability,
    pub access: Access,
    pub unit: Option<Unit>,
    pub display_unit: Option<DisplayUnit>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub nominal: Option<f64>,
    pub depends_on: Vec<(String, DependencyKind)>,
    /// Further inputs it depends on in initialization mode, through the initial state.
    pub starts_from: Vec<String>,
    pub evaluation: Option<Evaluation>,
    /// Where the model reads the slope of an input from.
    pub ramp: Option<Place>,
    /// Where the model writes the time derivative of an output, and what computes it.
    pub rate: Option<(Place, Evaluation)>,
    /// It is a continuous state.
    pub is_state: bool,
    /// The state whose time derivative it is.
    pub derivative_of: Option<String>,
    /// The states it depends on directly, if they are not all of them.
    pub depends_on_states: Option<Vec<String>>,
    /// What is wrong with its declaration, as far as one call can see it.
    pub mistakes: Vec<String>,
}
