//! Setting variables.

use std::sync::Arc;

use super::{Slave, all, find, out_of_range};
use crate::access::Access;
use crate::layout::{Layout, Slot};
use crate::model::Model;
use crate::phase::{Call, Phase};
use crate::status::{Outcome, Refusal};
use crate::variable::{Causality, Variable};

pub(crate) trait Set {
    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Outcome;
    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Outcome;
    fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Outcome;
    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Outcome;
}

impl<M: Model> Set for Slave<M> {
    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        self.check(Call::Set, "fmi2SetReal")?;
        let mut changed = Changed::default();
        let now = self.state.phase.settable_bit();
        for (reference, value) in references.iter().zip(values) {
            match self.layout.reals.get(*reference as usize) {
                Some(real) if real.slot.settable & now != 0 && real.accepts(*value) => {
                    changed.add(real.slot.causality);
                }
                _ => return Err(self.no_real_to_set(*reference, *value)),
            }
        }
        let old = self.before_tuning(changed);
        let (reals, model) = (self.layout.reals.as_slice(), &mut self.state.model);
        for (reference, value) in references.iter().zip(values) {
            if let Some(real) = reals.get(*reference as usize) {
                let place = (real.lens)(model);
                *place = *value;
            }
        }
        self.after_set(changed, old)
    }

    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let accept = |variable: &Variable<M>, value: &i32| accept_integer(variable, *value);
        self.set_each(
            |l| &l.integers,
            "fmi2SetInteger",
            references,
            values,
            accept,
            |access, model, value| match access {
                Access::Integer { set, .. } | Access::Enumeration { set, .. } => _ = set(model, value),
                _ => {}
            },
        )
    }

    fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let accept = |_: &Variable<M>, value: &i32| match value {
            0 | 1 => Ok(()),
            _ => Err(format!("{value} is no fmi2Boolean, which is 0 or 1")),
        };
        self.set_each(
            |l| &l.booleans,
            "fmi2SetBoolean",
            references,
            values,
            accept,
            |access, model, value| {
                if let Access::Boolean(field) = access {
                    *field(model) = value != 0;
                }
            },
        )
    }

    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Outcome {
        self.set_each(
            |l| &l.strings,
            "fmi2SetString",
            references,
            values,
            |_, _| Ok(()),
            |access, model, value| {
                if let Access::String(field) = access {
                    value.clone_into(field(model));
                }
            },
        )
    }
}

impl<M: Model> Slave<M> {
    /// For variables that live in `Access`es: integers, Booleans and strings. All are checked before one is set.
    fn set_each<T: Copy>(
        &mut self,
        slots: impl Fn(&Layout<M>) -> &[Slot],
        what: &str,
        references: &[u32],
        values: &[T],
        accept: impl Fn(&Variable<M>, &T) -> Result<(), String>,
        write: impl Fn(&Access<M>, &mut M, T),
    ) -> Outcome {
        self.check(Call::SetDiscrete, what)?;
        let layout = Arc::clone(&self.layout);
        let mut changed = Changed::default();
        for (reference, value) in references.iter().zip(values) {
            let slot = find(slots(&layout), *reference)?;
            self.check_settable(slot)?;
            let variable = &layout.variables[slot.variable as usize];
            accept(variable, value).map_err(|why| Refusal::error(format!("{}: {why}", variable.name)))?;
            changed.add(slot.causality);
        }
        let old = self.before_tuning(changed);
        for (reference, value) in references.iter().zip(values) {
            let slot = find(slots(&layout), *reference)?;
            write(&layout.variables[slot.variable as usize].access, &mut self.state.model, *value);
        }
        self.after_set(changed, old)
    }

    /// What to go back to if the model does not accept new values of tunable parameters. Not on the way of a step, where
    /// only inputs are set; boxed, so that nothing is moved about there.
    fn before_tuning(&self, changed: Changed) -> Option<Box<M>> {
        (changed.parameters() && self.state.phase.is_running()).then(|| Box::new(self.state.model.clone()))
    }

    /// Concludes setting variables that have all been checked: inputs make the outputs stale that depend on them;
    /// parameters make the model initialize again, or retune.
    fn after_set(&mut self, changed: Changed, old: Option<Box<M>>) -> Outcome {
        if !self.state.phase.is_running() {
            // The initial state may depend on both.
            self.state.uninitialized |= changed.inputs() | changed.parameters();
            return Ok(());
        }
        if changed.parameters() {
            if let Err(failure) = self.state.model.retuned() {
                if let Some(old) = old {
                    self.state.model = *old;
                }
                let undone = self.state.model.retuned();
                return Err(Refusal::of(&undone.err().unwrap_or(failure)));
            }
            self.state.stale = all();
        } else if changed.inputs() {
            self.state.stale |= self.layout.input_dependent;
        }
        Ok(())
    }

    /// Checks that the host may set this variable now.
    fn check_settable(&self, slot: &Slot) -> Result<(), Refusal> {
        if slot.settable & self.state.phase.settable_bit() == 0 { Err(self.not_settable(slot)) } else { Ok(()) }
    }

    #[cold]
    fn not_settable(&self, slot: &Slot) -> Refusal {
        let what = match slot.causality {
            Causality::Output | Causality::Local => "it is computed by the model",
            Causality::Input | Causality::Parameter if self.state.phase == Phase::ContinuousTimeMode => {
                "what jumps is set in event mode"
            }
            Causality::Input => "inputs can be set before and between steps",
            Causality::Parameter => "it is fixed once initialization mode has been left",
        };
        Refusal::error(format!("{} cannot be set {}: {what}", self.name(slot), self.state.phase.name()))
    }

    /// Why a real variable cannot have a value. Apart from the loop that checks, which is on the way of every step.
    #[cold]
    fn no_real_to_set(&self, reference: u32, value: f64) -> Refusal {
        match self.real(reference) {
            Ok(real) if real.slot.settable & self.state.phase.settable_bit() == 0 => self.not_settable(&real.slot),
            Ok(real) => out_of_range(self.name(&real.slot), value, real.min, real.max),
            Err(refusal) => refusal,
        }
    }
}

/// What kinds of variables a call sets.
#[derive(Clone, Copy, Default)]
struct Changed(u8);

impl Changed {
    fn add(&mut self, causality: Causality) {
        self.0 |= 1 << causality as u8;
    }

    fn has(self, causality: Causality) -> bool {
        self.0 & (1 << causality as u8) != 0
    }

    fn inputs(self) -> bool {
        self.has(Causality::Input)
    }

    fn parameters(self) -> bool {
        self.has(Causality::Parameter)
    }
}

/// Checks the value of an integer or an enumeration.
pub(super) fn accept_integer<M>(variable: &Variable<M>, value: i32) -> Result<(), String> {
    match &variable.access {
        Access::Enumeration { kind, .. } => {
            if usize::try_from(value).is_ok_and(|v| (1..=kind.items.len()).contains(&v)) {
                Ok(())
            } else {
                Err(format!("{value} is no item of {}, they are numbered from 1 to {}", kind.name, kind.items.len()))
            }
        }
        access => {
            let (min, max) = (variable.min, variable.max);
            let number = f64::from(value);
            let fits = matches!(access, Access::Integer { fits, .. } if fits(value));
            if fits && min.is_none_or(|min| min <= number) && max.is_none_or(|max| number <= max) {
                Ok(())
            } else {
                let bound = |b: Option<f64>| b.map_or("any".to_owned(), |b| b.to_string());
                Err(format!("{value} is out of range, the least is {}, the greatest {}", bound(min), bound(max)))
            }
        }
    }
}
