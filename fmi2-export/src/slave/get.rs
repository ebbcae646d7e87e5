//! Reading variables.

use std::ffi::CString;

use super::{Slave, find};
use crate::layout::{Layout, RealSlot, Slot};
use crate::out::Out;
use crate::pairs::follow_each_other;
use crate::phase::Call;
use crate::status::{Outcome, Refusal};
use crate::view::{Value, View};

impl Slave {
    /// Reads variables of an instance that is ready, if their references follow each other and they stand side by side; whether it has.
    ///
    /// # Safety
    /// So many references must be there, and so many places for values, if there are any.
    #[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
    #[inline(always)]
    pub unsafe fn get_shortly(&mut self, references: *const u32, values: *mut f64, count: usize) -> bool {
        if count == 0 {
            return false;
        }
        // SAFETY: the caller's promise.
        let first = unsafe { *references };
        let Some(real) = self.subject.layout().run(first, count) else { return false };
        // SAFETY: the caller's promise.
        if !follow_each_other(unsafe { std::slice::from_raw_parts(references, count) }, first) {
            return false;
        }
        let offset = real.offset;
        // Alike as they are, one evaluation does for all.
        let todo = u64::from(real.needs) & self.frame.stale;
        if todo != 0 {
            self.frame.stale ^= todo;
            // SAFETY: a variable has one evaluation, and what is in a run has none that is not declared.
            unsafe { self.subject.view().1.evaluate_one(todo) };
        }
        // SAFETY: so many stand side by side; the rest is the caller's promise.
        unsafe { self.subject.view().1.get_run(offset, values, count) };
        true
    }

    /// Reads variables of an instance that is ready, if none is elsewhere; whether it has.
    #[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
    #[inline(always)]
    pub fn get_near(&mut self, references: &[u32], values: Out<'_, f64>) -> bool {
        let (layout, mut view) = self.subject.view();
        let mut needs = 0;
        for reference in references {
            let Some(real) = layout.reals.get(*reference as usize) else { return false };
            needs |= real.needs;
        }
        if needs & RealSlot::NO_SHORT_WAY != 0 {
            return false;
        }
        let todo = u64::from(needs) & self.frame.stale;
        self.frame.stale &= !todo;
        view.evaluate(todo);
        // SAFETY: all are there, and none is elsewhere.
        values.write(references.iter().map(|reference| unsafe { view.near(*reference) }));
        true
    }

    pub fn get_real(&mut self, references: &[u32], values: Out<'_, f64>) -> Outcome {
        self.check(Call::Get, "fmi2GetReal")?;
        let mut wanted = 0;
        for reference in references {
            wanted |= self.layout().evaluation(self.real(*reference)?);
        }
        self.evaluate(wanted)?;
        let (_, mut view) = self.subject.view();
        values.write(references.iter().map(|reference| view.real(*reference)));
        Ok(())
    }

    pub fn get_integer(&mut self, references: &[u32], values: Out<'_, i32>) -> Outcome {
        self.prepare(|l| &l.integers, "fmi2GetInteger", references)?;
        let mut wrong = None;
        let (layout, mut view) = self.subject.view();
        let read = references.iter().map(|reference| match value(&mut view, &layout.integers, *reference) {
            Value::Integer(value) | Value::Enumeration(value) => value,
            _ => Ok(0),
        });
        values.write(read.zip(0..).map_while(|(value, i)| value.map_err(|why| wrong = Some((i, why))).ok()));
        let Some((i, why)) = wrong else { return Ok(()) };
        let slot = find(&layout.integers, references[i])?;
        Err(Refusal::error(format!("{}: {why}", layout.name(slot.variable))))
    }

    pub fn get_boolean(&mut self, references: &[u32], values: Out<'_, i32>) -> Outcome {
        self.prepare(|l| &l.booleans, "fmi2GetBoolean", references)?;
        let (layout, mut view) = self.subject.view();
        values.write(references.iter().map(|reference| {
            i32::from(matches!(value(&mut view, &layout.booleans, *reference), Value::Boolean(true)))
        }));
        Ok(())
    }

    /// The strings stay valid until the next call.
    pub fn get_string(&mut self, references: &[u32]) -> Result<&[CString], Refusal> {
        self.prepare(|l| &l.strings, "fmi2GetString", references)?;
        let mut strings = Vec::new();
        strings
            .try_reserve_exact(references.len())
            .map_err(|_| Refusal::error(format!("fmi2GetString: no memory for {} strings", references.len())))?;
        let (layout, mut view) = self.subject.view();
        strings.extend(references.iter().map(|reference| match value(&mut view, &layout.strings, *reference) {
            Value::String(text) => {
                CString::new(text.bytes().filter(|byte| *byte != 0).collect::<Vec<_>>()).unwrap_or_default()
            }
            _ => CString::default(),
        }));
        self.strings = strings;
        Ok(&self.strings)
    }

    /// Checks the references of variables that are no numbers, and runs what they need.
    fn prepare(&mut self, slots: fn(&Layout) -> &[Slot], what: &str, references: &[u32]) -> Outcome {
        self.check(Call::Get, what)?;
        let (mut wanted, slots) = (0, slots(self.layout()));
        for reference in references {
            wanted |= find(slots, *reference)?.evaluation;
        }
        self.evaluate(wanted)
    }
}

/// The value of a variable whose reference has been checked.
fn value<'v>(view: &'v mut View<'_>, slots: &[Slot], reference: u32) -> Value<'v> {
    view.value(slots[reference as usize].variable as usize)
}
