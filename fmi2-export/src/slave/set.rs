//! Setting variables.

use super::{Slave, all, find, out_of_range};
use crate::access::Access;
use crate::any_model::AnyModel;
use crate::layout::{Layout, RealSlot, Slot};
use crate::pairs::{Range, TWO_LATER, Two, both, two};
use crate::phase::{Call, Phase};
use crate::status::{Outcome, Refusal};
use crate::variable::{Causality, Variable};
use crate::view::View;

impl Slave {
    /// Sets inputs of an instance that is ready, if their references follow each other, they stand side by side, and take these values;
    /// whether it has.
    ///
    /// # Safety
    /// So many references and values must be there, if there are any.
    #[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
    #[inline(always)]
    pub unsafe fn set_shortly(&mut self, references: *const u32, values: *const f64, count: usize) -> bool {
        if count == 0 {
            return false;
        }
        // SAFETY: the caller's promise.
        let first = unsafe { *references };
        let Some(real) = self.layout().run(first, count) else { return false };
        if !is_input(real) {
            return false;
        }
        // SAFETY: the caller's promise.
        let (references, values) =
            unsafe { (std::slice::from_raw_parts(references, count), std::slice::from_raw_parts(values, count)) };
        // An odd number of them leaves pairs behind the first.
        let mut i = count % 2;
        if i == 1 && !real.accepts(values[0]) {
            return false;
        }
        let (mut expected, mut range) = (both(first, i), Range::new(real.min, real.max));
        while i < count {
            // SAFETY: an even number of both is left.
            let (reference, value) = unsafe { (two(references, i), Two::read(values.as_ptr().add(i))) };
            if reference != expected {
                return false;
            }
            expected = expected.wrapping_add(TWO_LATER);
            range.add(value);
            i += 2;
        }
        if !range.has_all() {
            return false;
        }
        let offset = real.offset;
        // Only now, so that nothing is kept in registers meanwhile.
        let (layout, mut view) = self.subject.view();
        // SAFETY: so many stand side by side as there are references, and so values.
        unsafe { view.set_run(offset, values) };
        self.frame.stale |= layout.input_dependent;
        true
    }

    /// Sets inputs of an instance that is ready, if none is elsewhere and all take these values; whether it has.
    #[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
    #[inline(always)]
    pub fn set_near(&mut self, references: &[u32], values: &[f64]) -> bool {
        let (layout, mut view) = self.subject.view();
        let (mut kinds, mut needs) = (Causality::Input.bit(), 0);
        for (reference, value) in references.iter().zip(values) {
            let Some(real) = layout.reals.get(*reference as usize) else { return false };
            (kinds, needs) = (kinds | real.kind, needs | real.needs);
            if !real.accepts(*value) {
                return false;
            }
        }
        if kinds != Causality::Input.bit() || needs & RealSlot::NO_SHORT_WAY != 0 {
            return false;
        }
        // SAFETY: all are there, and none is elsewhere.
        unsafe { view.set_near(references, values) };
        self.frame.stale |= layout.input_dependent;
        true
    }

    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        self.check(Call::Set, "fmi2SetReal")?;
        let mut changed = Changed::default();
        let now = self.frame.phase.settable_bit();
        let reals = self.layout().reals.as_slice();
        for (reference, value) in references.iter().zip(values) {
            match reals.get(*reference as usize) {
                Some(real) if real.settable & now != 0 && real.accepts(*value) => changed.0 |= real.kind,
                _ => return Err(self.no_real_to_set(*reference, *value)),
            }
        }
        let old = self.before_tuning(changed);
        let (_, mut view) = self.subject.view();
        references.iter().zip(values).for_each(|(reference, value)| view.set_real(*reference, *value));
        self.after_set(changed, old)
    }

    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let accept = |variable: &Variable, i: usize| accept_integer(variable, values[i]);
        self.set_each(|l| &l.integers, "fmi2SetInteger", references, &accept, &|view, variable, i| {
            view.set_integer(variable, values[i]);
        })
    }

    pub fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let accept = |_: &Variable, i: usize| match values[i] {
            0 | 1 => Ok(()),
            value => Err(format!("{value} is no fmi2Boolean, which is 0 or 1")),
        };
        self.set_each(|l| &l.booleans, "fmi2SetBoolean", references, &accept, &|view, variable, i| {
            view.set_boolean(variable, values[i] != 0);
        })
    }

    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Outcome {
        self.set_each(|l| &l.strings, "fmi2SetString", references, &|_, _| Ok(()), &|view, variable, i| {
            view.set_string(variable, values[i]);
        })
    }

    /// For variables that are no numbers, whose values are told by their places. All are checked before one is set.
    fn set_each(
        &mut self,
        slots: fn(&Layout) -> &[Slot],
        what: &str,
        references: &[u32],
        accept: &dyn Fn(&Variable, usize) -> Result<(), String>,
        write: &dyn Fn(&mut View<'_>, usize, usize),
    ) -> Outcome {
        self.check(Call::SetDiscrete, what)?;
        let layout = self.layout();
        let mut changed = Changed::default();
        for (i, reference) in references.iter().enumerate() {
            let slot = find(slots(layout), *reference)?;
            if slot.settable & self.frame.phase.settable_bit() == 0 {
                return Err(self.not_settable(slot.variable));
            }
            let variable = &layout.variables[slot.variable as usize];
            accept(variable, i).map_err(|why| Refusal::error(format!("{}: {why}", variable.name)))?;
            changed.add(slot.causality);
        }
        let old = self.before_tuning(changed);
        let (layout, mut view) = self.subject.view();
        for (i, reference) in references.iter().enumerate() {
            let slot = find(slots(layout), *reference)?;
            write(&mut view, slot.variable as usize, i);
        }
        self.after_set(changed, old)
    }

    /// What to go back to if the model does not accept new values of tunable parameters.
    fn before_tuning(&self, changed: Changed) -> Option<Box<dyn AnyModel>> {
        if changed.parameters() { self.copy_if_running() } else { None }
    }

    #[inline(never)]
    fn copy_if_running(&self) -> Option<Box<dyn AnyModel>> {
        self.frame.phase.is_running().then(|| self.subject.model().copy())
    }

    /// Concludes setting variables that have all been checked: inputs make the outputs stale that depend on them;
    /// parameters make the model initialize again, or retune.
    fn after_set(&mut self, changed: Changed, old: Option<Box<dyn AnyModel>>) -> Outcome {
        if changed.parameters() {
            return self.after_parameters(old);
        }
        if changed.inputs() {
            self.after_inputs();
        }
        Ok(())
    }

    #[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
    #[inline(always)]
    fn after_inputs(&mut self) {
        self.frame.stale |= self.layout().input_dependent;
        // Before there is a state, it may depend on them. Afterwards, nobody asks.
        self.frame.uninitialized |= !self.frame.phase.is_running();
    }

    #[inline(never)]
    fn after_parameters(&mut self, old: Option<Box<dyn AnyModel>>) -> Outcome {
        if !self.frame.phase.is_running() {
            self.frame.uninitialized = true;
            return Ok(());
        }
        let model = self.model();
        if let Err(failure) = model.retuned() {
            if let Some(old) = old {
                model.assign(&*old);
            }
            let undone = model.retuned();
            return Err(Refusal::of(&undone.err().unwrap_or(failure)));
        }
        self.frame.stale = all();
        Ok(())
    }

    #[cold]
    #[inline(never)]
    fn not_settable(&self, variable: u32) -> Refusal {
        let what = match self.layout().variables[variable as usize].causality {
            Causality::Output | Causality::Local => "it is computed by the model",
            Causality::Input | Causality::Parameter if self.frame.phase == Phase::ContinuousTimeMode => {
                "what jumps is set in event mode"
            }
            Causality::Input => "inputs can be set before and between steps",
            Causality::Parameter => "it is fixed once initialization mode has been left",
        };
        Refusal::error(format!("{} cannot be set {}: {what}", self.layout().name(variable), self.frame.phase.name()))
    }

    /// Why a real variable cannot have a value. Apart from the loop that checks, which is on the way of every step.
    #[cold]
    #[inline(never)]
    fn no_real_to_set(&self, reference: u32, value: f64) -> Refusal {
        match self.real(reference) {
            Ok(real) if real.settable & self.frame.phase.settable_bit() == 0 => self.not_settable(real.variable),
            Ok(real) => out_of_range(self.name(real), value, real.min, real.max),
            Err(refusal) => refusal,
        }
    }
}

/// Whether it is an input, which can be set between steps: see [`settable`](crate::layout::settable).
#[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
#[inline(always)]
fn is_input(real: &RealSlot) -> bool {
    real.kind == Causality::Input.bit()
}

/// What kinds of variables a call sets.
#[derive(Clone, Copy, Default)]
struct Changed(u8);

impl Changed {
    fn add(&mut self, causality: Causality) {
        self.0 |= causality.bit();
    }

    fn has(self, causality: Causality) -> bool {
        self.0 & causality.bit() != 0
    }

    fn inputs(self) -> bool {
        self.has(Causality::Input)
    }

    fn parameters(self) -> bool {
        self.has(Causality::Parameter)
    }
}

/// Checks the value of an integer or an enumeration.
pub(super) fn accept_integer(variable: &Variable, value: i32) -> Result<(), String> {
    match &variable.access {
        Access::Enumeration(.., kind) => {
            if usize::try_from(value).is_ok_and(|v| (1..=kind.items.len()).contains(&v)) {
                Ok(())
            } else {
                Err(format!("{value} is no item of {}, they are numbered from 1 to {}", kind.name, kind.items.len()))
            }
        }
        access => {
            let (min, max) = (variable.min, variable.max);
            let number = f64::from(value);
            let fits = matches!(access, Access::Integer(_, whole) if (whole.fits)(value));
            if fits && min.is_none_or(|min| min <= number) && max.is_none_or(|max| number <= max) {
                Ok(())
            } else {
                let bound = |b: Option<f64>| b.map_or("any".to_owned(), |b| b.to_string());
                Err(format!("{value} is out of range, the least is {}, the greatest {}", bound(min), bound(max)))
            }
        }
    }
}
