//! The declared variables, checked and indexed by value reference.

mod continuous;
mod slots;

pub(crate) use continuous::Continuous;
pub(crate) use slots::{BaseType, RealSlot, Reference, Slot, settable};

use std::any::TypeId;

use crate::access::{Access, EnumerationKind};
use crate::any_model::AnyModel;
use crate::declarations::Declarations;
use crate::info::Info;
use crate::model::Model;
use crate::place::Place;
use crate::problems::problems;
use crate::variable::Variable;
use crate::view::{Declared, Evaluate, View};
use slots::when_settable;

/// The variables of a model, by declaration order and by value reference.
pub(crate) struct Layout {
    pub info: Info,
    /// The model's type.
    model: TypeId,
    pub variables: Vec<Variable>,
    /// Base type and value reference of each variable.
    pub references: Vec<Reference>,
    pub reals: Vec<RealSlot>,
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
        layout.find_runs();
        // Grown by doubling, and kept as long as there are instances.
        layout.variables.shrink_to_fit();
        layout.reals.shrink_to_fit();
        if let Some(exchange) = exchange {
            layout.add_continuous(exchange, indicators);
        }
        layout
    }

    /// Finds the real variables that stand side by side, from the last on.
    fn find_runs(&mut self) {
        let mut next: Option<RealSlot> = None;
        for real in self.reals.iter_mut().rev() {
            let has_evaluation = (real.needs.trailing_zeros() as usize) < self.evaluations.len() || real.needs == 0;
            if real.needs & RealSlot::NO_SHORT_WAY == 0 && has_evaluation {
                real.run = next.filter(|next| real.is_like(next)).map_or(1, |next| next.run.saturating_add(1));
            }
            next = (real.run > 0).then_some(*real);
        }
    }

    /// What is known of so many real variables from this reference on, if they stand side by side and have a short way.
    #[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
    #[inline(always)]
    pub fn run(&self, first: u32, count: usize) -> Option<&RealSlot> {
        self.reals.get(first as usize).filter(|real| count <= usize::from(real.run))
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
                self.reals.push(RealSlot {
                    min: variable.min.unwrap_or(f64::MIN).max(f64::MIN),
                    max: variable.max.unwrap_or(f64::MAX).min(f64::MAX),
                    offset,
                    variable: index,
                    settable,
                    kind: causality.bit(),
                    run: 0,
                    needs: RealSlot::needs(evaluation, offset),
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
