//! The declared variables, checked and indexed by value reference.

use std::any::TypeId;
use std::sync::Arc;

use crate::access::{Access, EnumerationKind};
use crate::any_model::AnyModel;
use crate::declarations::{Declarations, Indicators};
use crate::exchange::Exchange;
use crate::info::Info;
use crate::model::Model;
use crate::place::Place;
use crate::problems::problems;
use crate::variable::{Causality, Variability, Variable};
use crate::view::{Declared, Evaluate, NumbersOf, View};

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

/// What setting and reading a variable of another base type takes.
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

/// What setting and reading a real variable takes.
#[derive(Clone, Copy)]
pub(crate) struct RealSlot {
    /// The least value it may have, finite: [`f64::MIN`] where none is declared.
    pub min: f64,
    /// The greatest, likewise.
    pub max: f64,
    /// How many bytes behind the model's beginning it always is, or [`ELSEWHERE`](Self::ELSEWHERE).
    pub offset: u32,
    /// Index into [`Layout::variables`].
    pub variable: u32,
    /// Phases in which the host may set it.
    pub settable: u8,
    /// What it is, as far as setting and reading it go: a bit each.
    pub kind: u8,
}

impl RealSlot {
    /// No offset: the declared function leads to the variable.
    pub const ELSEWHERE: u32 = u32::MAX;
    /// Of [`kind`](Self::kind): it has no offset. The bits of the causalities are below.
    pub const IS_ELSEWHERE: u8 = 1 << 7;

    pub fn has(&self, causality: Causality) -> bool {
        self.kind & causality.bit() != 0
    }

    /// Whether the variable may have this value. NaN and infinities never are between two finite numbers.
    #[inline]
    pub fn accepts(&self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }
}

/// What reading a real variable takes, if it is where the offset says: as short as possible.
#[derive(Clone, Copy)]
pub(crate) struct Reading {
    /// The evaluation to run before, as a bit, 0 if none; or [`NO_SHORT_WAY`](Self::NO_SHORT_WAY).
    pub needs: u32,
    /// As in [`RealSlot`].
    pub offset: u32,
}

impl Reading {
    /// Of [`needs`](Self::needs): the variable is elsewhere, or its evaluation has no bit here.
    pub const NO_SHORT_WAY: u32 = 1 << 31;

    fn new(evaluation: u64, offset: u32) -> Self {
        let short = u32::try_from(evaluation).ok().filter(|needs| needs & Self::NO_SHORT_WAY == 0);
        let needs = short.filter(|_| offset != RealSlot::ELSEWHERE).unwrap_or(Self::NO_SHORT_WAY);
        Self { needs, offset }
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
pub(crate) struct Layout {
    pub info: Info,
    /// The model's type.
    model: TypeId,
    pub variables: Vec<Variable>,
    /// Base type and value reference of each variable.
    pub references: Vec<Reference>,
    pub reals: Vec<RealSlot>,
    /// Of the same variables.
    pub readings: Vec<Reading>,
    /// The other base types.
    pub integers: Vec<Slot>,
    pub booleans: Vec<Slot>,
    pub strings: Vec<Slot>,
    evaluations: Vec<Evaluate>,
    /// Evaluations that have to run again when an input has changed.
    pub input_dependent: u64,
    /// Value references of the inputs that can be ramps.
    pub ramps: Vec<u32>,
    pub enumerations: Vec<EnumerationKind>,
    /// What a host that integrates deals with, if the model offers it.
    pub continuous: Option<Continuous>,
    /// Where the model reads the time from.
    time: Option<Place>,
}

/// The continuous states and the event indicators of a model, and what is called for them.
pub(crate) struct Continuous {
    pub exchange: &'static Exchange,
    /// In the order in which the host has them.
    pub states: Vec<StateSlot>,
    /// The evaluations that fill in the states.
    pub state_evaluations: u64,
    /// Those that fill in their time derivatives.
    pub derivative_evaluations: u64,
    /// What fills in the event indicators, as a bit, and where they are.
    indicators: Option<(u64, Arc<NumbersOf>)>,
    /// How many there are.
    pub indicator_count: usize,
}

impl Continuous {
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

impl Layout {
    /// Checks the declarations of a model and builds the tables.
    pub fn build<M: Model>() -> Result<Self, DeclarationError> {
        Self::checked(Declarations::of::<M>())
    }

    fn checked(mut declared: Declarations) -> Result<Self, DeclarationError> {
        let problems = problems(&mut declared);
        if problems.is_empty() {
            Ok(Self::of(declared))
        } else {
            Err(DeclarationError { model: declared.info.name, problems })
        }
    }

    /// Builds the tables of declarations that have been checked.
    pub fn of(declared: Declarations) -> Self {
        let Declarations { info, model, list, evaluations, exchange, indicators, time, sample, .. } = declared;
        drop(sample);
        let mut layout = Self {
            info,
            model,
            references: Vec::with_capacity(list.len()),
            variables: Vec::new(),
            reals: Vec::new(),
            readings: Vec::new(),
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
        layout.readings.shrink_to_fit();
        if let Some(exchange) = exchange {
            layout.add_continuous(exchange, indicators);
        }
        layout
    }

    fn add_continuous(&mut self, exchange: &'static Exchange, indicators: Option<Indicators>) {
        let mut continuous = Continuous {
            exchange,
            states: Vec::new(),
            state_evaluations: 0,
            derivative_evaluations: 0,
            indicator_count: indicators.as_ref().map_or(0, |indicators| indicators.count),
            indicators: indicators.map(|indicators| (1 << indicators.evaluation.0, indicators.array)),
        };
        let derivatives: Vec<(&str, u32)> = self
            .variables
            .iter()
            .zip(&self.references)
            .filter_map(|(variable, reference)| Some((variable.derivative_of.as_deref()?, reference.index)))
            .collect();
        // They are in the order of the states as a rule, so each is looked for behind the one before. That is shorter than a hash table.
        let mut last = 0;
        for (variable, reference) in self.variables.iter().zip(&self.references).filter(|(v, _)| v.is_state) {
            let (before, behind) = derivatives.split_at(last);
            // Each has one: see `problems`.
            let Some(past) = behind.iter().chain(before).position(|(of, _)| *of == variable.name) else { continue };
            last = (last + past) % derivatives.len();
            let derivative = &derivatives[last].1;
            let state = reference.index;
            continuous.states.push(StateSlot {
                state,
                derivative: *derivative,
                nominal: variable.nominal.map_or(1.0, f64::abs),
            });
            continuous.state_evaluations |= self.evaluation(&self.reals[state as usize]);
            continuous.derivative_evaluations |= self.evaluation(&self.reals[*derivative as usize]);
        }
        // Whatever an input is to them, it is not said for each.
        self.input_dependent |= continuous.derivative_evaluations;
        self.input_dependent |= continuous.indicator_evaluations();
        self.continuous = Some(continuous);
    }

    /// The evaluation to run before reading a real variable, as a bit; 0 if none.
    pub fn evaluation(&self, real: &RealSlot) -> u64 {
        bit(&self.variables[real.variable as usize])
    }

    fn add(&mut self, index: u32, variable: &Variable) {
        let evaluation = bit(variable);
        if !variable.depends_on.is_empty() {
            self.input_dependent |= evaluation;
        }
        // The time derivative of a state depends on the inputs even where the state itself does not.
        self.input_dependent |= variable.rate.as_ref().map_or(0, |(_, e)| 1 << e.0);
        let (causality, settable) = (variable.causality, when_settable(variable));
        let slot = Slot { variable: index, causality, settable, evaluation };
        let (base, count) = match &variable.access {
            Access::Real(place) => {
                let reference = length(&self.reals);
                if variable.ramp.is_some() {
                    self.ramps.push(reference);
                }
                let offset = place.offset().and_then(|offset| offset.try_into().ok()).unwrap_or(RealSlot::ELSEWHERE);
                let elsewhere = if offset == RealSlot::ELSEWHERE { RealSlot::IS_ELSEWHERE } else { 0 };
                self.readings.push(Reading::new(evaluation, offset));
                self.reals.push(RealSlot {
                    min: variable.min.unwrap_or(f64::MIN).max(f64::MIN),
                    max: variable.max.unwrap_or(f64::MAX).min(f64::MAX),
                    offset,
                    variable: index,
                    settable,
                    kind: causality.bit() | elsewhere,
                });
                (BaseType::Real, reference)
            }
            access @ (Access::Integer(..) | Access::Enumeration(..)) => {
                if let Access::Enumeration(.., kind) = access
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

    /// Whether it is that of models of this type.
    pub fn is_of(&self, model: TypeId) -> bool {
        self.model == model
    }

    #[inline]
    fn declared(&self) -> Declared<'_> {
        Declared { model: self.model, variables: &self.variables, evaluations: &self.evaluations, reals: &self.reals }
    }

    /// The variables of a model, which must be of this type.
    pub fn view<'a>(&'a self, model: &'a mut dyn AnyModel) -> View<'a> {
        View::of(self.declared(), model)
    }

    /// As [`view`](Self::view), for what is called at every step.
    ///
    /// # Safety
    /// The model must be of the type that this layout is of.
    #[inline]
    pub unsafe fn view_unchecked<'a>(&'a self, model: &'a mut dyn AnyModel) -> View<'a> {
        // SAFETY: the caller's promise.
        unsafe { View::unchecked(self.declared(), model) }
    }

    /// Name of a variable, for messages.
    pub fn name(&self, variable: u32) -> &str {
        &self.variables[variable as usize].name
    }

    fn state_slots(&self) -> impl Iterator<Item = &StateSlot> {
        self.continuous.iter().flat_map(|continuous| &continuous.states)
    }

    /// The continuous states, as their fields have them.
    pub fn states<'a>(&'a self, model: &'a mut dyn AnyModel) -> impl Iterator<Item = f64> + 'a {
        let mut view = self.view(model);
        self.state_slots().map(move |slot| view.real(slot.state))
    }

    /// Writes the fields of the continuous states.
    pub fn write_states(&self, model: &mut dyn AnyModel, values: &[f64]) {
        let mut view = self.view(model);
        for (slot, value) in self.state_slots().zip(values) {
            view.set_real(slot.state, *value);
        }
    }

    /// The states' time derivatives, as their fields have them.
    pub fn derivatives<'a>(&'a self, model: &'a mut dyn AnyModel) -> impl Iterator<Item = f64> + 'a {
        let mut view = self.view(model);
        self.state_slots().map(move |slot| view.real(slot.derivative))
    }

    /// The states' nominal values.
    pub fn nominals(&self) -> impl Iterator<Item = f64> {
        self.state_slots().map(|slot| slot.nominal)
    }

    /// The event indicators, as their field has them.
    pub fn indicators<'m>(&'m self, model: &'m mut dyn AnyModel) -> &'m [f64] {
        match self.continuous.as_ref().and_then(|continuous| continuous.indicators.as_ref()) {
            // SAFETY: declared with these variables.
            Some((_, array)) => unsafe { self.view(model).numbers(&**array) },
            None => &[],
        }
    }

    /// Tells the model the time, if it wants to know it; whether it does.
    pub fn tell_time(&self, model: &mut dyn AnyModel, time: f64) -> bool {
        if let Some(place) = &self.time {
            let mut view = self.view(model);
            // SAFETY: declared with these variables.
            *unsafe { view.number(place) } = time;
        }
        self.time.is_some()
    }

    /// Whether any output's time derivative can be asked for.
    pub fn has_rates(&self) -> bool {
        self.variables.iter().any(|variable| variable.rate.is_some())
    }
}

/// The evaluation that fills in a variable, as a bit; 0 if none.
fn bit(variable: &Variable) -> u64 {
    variable.evaluation.map_or(0, |evaluation| 1 << evaluation.0)
}

fn length<T>(list: &[T]) -> u32 {
    u32::try_from(list.len()).unwrap_or(u32::MAX)
}

/// Condition columns 1, 3 and 6 of the table in FMI 2.0.4, section 4.2.4, but inputs may also be set before
/// initialization: the standard's own example sets "all variable start values" there, and hosts do.
///
/// In model exchange columns 1, 3, 4 and 5 of the table in section 3.2.3: in continuous-time mode nothing may jump.
fn when_settable(variable: &Variable) -> u8 {
    let before_stepping = settable::INSTANTIATED | settable::INITIALIZATION;
    let running = before_stepping | settable::STEPPING | settable::EVENT;
    match (variable.causality, variable.variability) {
        (Causality::Input, Variability::Continuous) => running | settable::CONTINUOUS,
        (Causality::Input, _) | (Causality::Parameter, Variability::Tunable) => running,
        (Causality::Parameter, _) => before_stepping,
        (Causality::Output | Causality::Local, _) => 0,
    }
}
