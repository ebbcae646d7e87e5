//! The declared variables, checked and indexed by value reference.

use std::collections::HashMap;
use std::sync::Arc;

use crate::access::{Access, EnumerationKind, Lens};
use crate::exchange::Exchange;
use crate::model::Model;
use crate::problems::problems;
use crate::variable::{Causality, Variability, Variable};
use crate::variables::{Indicators, Variables};

/// When the host may set a variable: one bit per phase.
pub(crate) mod settable {
    pub const INSTANTIATED: u8 = 1;
    pub const INITIALIZATION: u8 = 2;
    /// Between communication steps.
    pub const STEPPING: u8 = 4;
    /// In event mode of a model exchange.
    pub const EVENT: u8 = 8;
    /// In continuous-time mode of a model exchange.
    pub const CONTINUOUS: u8 = 16;
}

/// What is the same for a variable of any base type.
#[derive(Clone, Copy)]
pub(crate) struct Slot {
    /// Index into [`Layout::variables`].
    pub variable: u32,
    pub causality: Causality,
    /// Phases in which the host may set it.
    pub settable: u8,
    /// The evaluation to run before reading it, as a bit; 0 if none.
    pub evaluation: u64,
}

pub(crate) struct RealSlot<M> {
    pub lens: Lens<M, f64>,
    pub slot: Slot,
    /// The least value it may have, finite: [`f64::MIN`] where none is declared.
    pub min: f64,
    /// The greatest, likewise.
    pub max: f64,
    pub ramp: Option<Lens<M, f64>>,
    pub rate: Option<(Lens<M, f64>, u64)>,
}

impl<M> RealSlot<M> {
    /// Whether the variable may have this value. NaN and infinities never are between two finite numbers.
    pub fn accepts(&self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }
}

/// A variable's base type and its value reference among those of that type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reference {
    pub base: BaseType,
    pub index: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BaseType {
    Real,
    Integer,
    Boolean,
    String,
}

/// The variables of a model, by declaration order and by value reference.
pub(crate) struct Layout<M> {
    pub variables: Vec<Variable<M>>,
    /// Base type and value reference of each variable.
    pub references: Vec<Reference>,
    pub reals: Vec<RealSlot<M>>,
    /// The other base types: the access stays in `variables`.
    pub integers: Vec<Slot>,
    pub booleans: Vec<Slot>,
    pub strings: Vec<Slot>,
    pub evaluations: Vec<fn(&mut M)>,
    /// Evaluations that have to run again when an input has changed.
    pub input_dependent: u64,
    /// Value references of the inputs that can be ramps.
    pub ramps: Vec<u32>,
    pub enumerations: Vec<EnumerationKind>,
    /// What a host that integrates deals with, if the model offers it.
    pub continuous: Option<Continuous<M>>,
    /// Where the model reads the time from.
    pub time: Option<Lens<M, f64>>,
}

/// The continuous states and the event indicators of a model, and what is called for them.
pub(crate) struct Continuous<M> {
    pub exchange: Exchange<M>,
    /// In the order in which the host has them.
    pub states: Vec<StateSlot>,
    /// The evaluations that fill in the states.
    pub state_evaluations: u64,
    /// Those that fill in their time derivatives.
    pub derivative_evaluations: u64,
    /// What fills in the event indicators, as a bit, and where they are.
    pub indicators: Option<(u64, Lens<M, [f64]>)>,
    /// How many there are.
    pub indicator_count: usize,
}

impl<M> Continuous<M> {
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

/// A mistake in a model's declarations. Found when the description is generated or the model instantiated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("model {model}: {}", problems.join("; "))]
pub struct DeclarationError {
    /// The model's name.
    pub model: &'static str,
    /// Every problem found, not only the first.
    pub problems: Vec<String>,
}

impl<M: Model> Layout<M> {
    /// Checks the declarations and builds the tables.
    pub fn build() -> Result<Self, DeclarationError> {
        let declared = declared::<M>();
        let mut problems = problems(&M::INFO, &declared.list, declared.evaluations.len());
        let evaluations = declared.evaluations.len();
        if declared.indicators.as_ref().is_some_and(|indicators| indicators.evaluation.0 >= evaluations) {
            problems.push("the event indicators name an evaluation of another model".into());
        }
        if !problems.is_empty() {
            return Err(DeclarationError { model: M::INFO.name, problems });
        }
        Ok(Self::of(declared))
    }

    /// Builds the tables of declarations that were checked when the model was packaged.
    pub fn of_packaged() -> Self {
        Self::of(declared())
    }

    fn of(declared: Variables<M>) -> Self {
        let Variables { list, evaluations, exchange, indicators, time } = declared;
        let mut layout = Self {
            references: Vec::with_capacity(list.len()),
            variables: Vec::new(),
            reals: Vec::new(),
            integers: Vec::new(),
            booleans: Vec::new(),
            strings: Vec::new(),
            input_dependent: 0,
            ramps: Vec::new(),
            enumerations: Vec::new(),
            evaluations,
            continuous: None,
            time,
        };
        for (index, variable) in (0..).zip(&list) {
            layout.add(index, variable);
        }
        layout.variables = list;
        // Grown by doubling, and kept as long as there are instances.
        layout.variables.shrink_to_fit();
        layout.reals.shrink_to_fit();
        if let Some(exchange) = exchange {
            layout.add_continuous(exchange, indicators);
        }
        layout
    }

    fn add_continuous(&mut self, exchange: Exchange<M>, indicators: Option<Indicators<M>>) {
        let indicators = indicators.map(|indicators| (1 << indicators.evaluation.0, indicators.lens));
        let count = |(_, lens): &(u64, Lens<M, [f64]>)| lens(&mut M::default()).len();
        let mut continuous = Continuous {
            exchange,
            states: Vec::new(),
            state_evaluations: 0,
            derivative_evaluations: 0,
            indicator_count: indicators.as_ref().map_or(0, count),
            indicators,
        };
        let derivatives: HashMap<&str, u32> = self
            .variables
            .iter()
            .zip(&self.references)
            .filter_map(|(variable, reference)| Some((variable.derivative_of.as_deref()?, reference.index)))
            .collect();
        for (variable, reference) in self.variables.iter().zip(&self.references).filter(|(v, _)| v.is_state) {
            // Each has one: see `problems`.
            let Some(derivative) = derivatives.get(variable.name.as_str()) else { continue };
            let state = reference.index;
            continuous.states.push(StateSlot {
                state,
                derivative: *derivative,
                nominal: variable.nominal.map_or(1.0, f64::abs),
            });
            continuous.state_evaluations |= self.reals[state as usize].slot.evaluation;
            continuous.derivative_evaluations |= self.reals[*derivative as usize].slot.evaluation;
        }
        // Whatever an input is to them, it is not said for each.
        self.input_dependent |= continuous.derivative_evaluations;
        self.input_dependent |= continuous.indicator_evaluations();
        self.continuous = Some(continuous);
    }

    fn add(&mut self, index: u32, variable: &Variable<M>) {
        let evaluation = variable.evaluation.map_or(0, |e| 1 << e.0);
        if !variable.depends_on.is_empty() {
            self.input_dependent |= evaluation;
        }
        // The time derivative of a state depends on the inputs even where the state itself does not.
        self.input_dependent |= variable.rate.as_ref().map_or(0, |(_, e)| 1 << e.0);
        let slot =
            Slot { variable: index, causality: variable.causality, settable: when_settable(variable), evaluation };
        let (base, count) = match &variable.access {
            Access::Real(lens) => {
                let reference = length(&self.reals);
                if variable.ramp.is_some() {
                    self.ramps.push(reference);
                }
                self.reals.push(RealSlot {
                    lens: Arc::clone(lens),
                    slot,
                    min: variable.min.unwrap_or(f64::MIN).max(f64::MIN),
                    max: variable.max.unwrap_or(f64::MAX).min(f64::MAX),
                    ramp: variable.ramp.clone(),
                    rate: variable.rate.as_ref().map(|(lens, e)| (Arc::clone(lens), 1 << e.0)),
                });
                (BaseType::Real, reference)
            }
            access @ (Access::Integer { .. } | Access::Enumeration { .. }) => {
                if let Access::Enumeration { kind, .. } = access
                    && !self.enumerations.contains(kind)
                {
                    self.enumerations.push(*kind);
                }
                self.integers.push(slot);
                (BaseType::Integer, length(&self.integers) - 1)
            }
            Access::Boolean(_) => {
                self.booleans.push(slot);
                (BaseType::Boolean, length(&self.booleans) - 1)
            }
            Access::String(_) => {
                self.strings.push(slot);
                (BaseType::String, length(&self.strings) - 1)
            }
        };
        self.references.push(Reference { base, index: count });
    }

    /// Runs evaluations, a bit each.
    #[inline]
    pub fn evaluate(&self, mut todo: u64, model: &mut M) {
        while todo != 0 {
            let index = todo.trailing_zeros() as usize;
            if let Some(evaluation) = self.evaluations.get(index) {
                evaluation(model);
            }
            todo &= todo - 1;
        }
    }

    fn state_slots(&self) -> impl Iterator<Item = &StateSlot> {
        self.continuous.iter().flat_map(|continuous| &continuous.states)
    }

    /// The continuous states, as their fields have them.
    pub fn states(&self, model: &mut M) -> impl Iterator<Item = f64> {
        self.state_slots().map(|slot| *(self.reals[slot.state as usize].lens)(model))
    }

    /// Writes the fields of the continuous states.
    pub fn write_states(&self, model: &mut M, values: &[f64]) {
        for (slot, value) in self.state_slots().zip(values) {
            *(self.reals[slot.state as usize].lens)(model) = *value;
        }
    }

    /// The states' time derivatives, as their fields have them.
    pub fn derivatives(&self, model: &mut M) -> impl Iterator<Item = f64> {
        self.state_slots().map(|slot| *(self.reals[slot.derivative as usize].lens)(model))
    }

    /// The states' nominal values.
    pub fn nominals(&self) -> impl Iterator<Item = f64> {
        self.state_slots().map(|slot| slot.nominal)
    }

    /// The event indicators, as their field has them.
    pub fn indicators<'m>(&self, model: &'m mut M) -> &'m [f64] {
        match self.continuous.as_ref().and_then(|continuous| continuous.indicators.as_ref()) {
            Some((_, lens)) => lens(model),
            None => &[],
        }
    }

    /// Tells the model the time, if it wants to know it; whether it does.
    pub fn tell_time(&self, model: &mut M, time: f64) -> bool {
        if let Some(lens) = &self.time {
            *lens(model) = time;
        }
        self.time.is_some()
    }

    /// Whether any output's time derivative can be asked for.
    pub fn has_rates(&self) -> bool {
        self.reals.iter().any(|real| real.rate.is_some())
    }
}

fn declared<M: Model>() -> Variables<M> {
    let mut variables = Variables::new();
    M::variables(&mut variables);
    variables
}

fn length<T>(list: &[T]) -> u32 {
    u32::try_from(list.len()).unwrap_or(u32::MAX)
}

/// Condition columns 1, 3 and 6 of the table in FMI 2.0.4, section 4.2.4, but inputs may also be set before
/// initialization: the standard's own example sets "all variable start values" there, and hosts do.
///
/// In model exchange columns 1, 3, 4 and 5 of the table in section 3.2.3: in continuous-time mode nothing may jump.
fn when_settable<M>(variable: &Variable<M>) -> u8 {
    let before_stepping = settable::INSTANTIATED | settable::INITIALIZATION;
    let running = before_stepping | settable::STEPPING | settable::EVENT;
    match (variable.causality, variable.variability) {
        (Causality::Input, Variability::Continuous) => running | settable::CONTINUOUS,
        (Causality::Input, _) | (Causality::Parameter, Variability::Tunable) => running,
        (Causality::Parameter, _) => before_stepping,
        (Causality::Output | Causality::Local, _) => 0,
    }
}
