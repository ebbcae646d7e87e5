//! Reading variables.

use std::ffi::CString;
use std::sync::Arc;

use super::{Slave, find, no_such};
use crate::access::Access;
use crate::layout::{Layout, Slot};
use crate::model::Model;
use crate::out::Out;
use crate::phase::Call;
use crate::status::{Outcome, Refusal};

pub(crate) trait Get {
    fn get_real(&mut self, references: &[u32], values: Out<'_, f64>) -> Outcome;
    fn get_integer(&mut self, references: &[u32], values: Out<'_, i32>) -> Outcome;
    fn get_boolean(&mut self, references: &[u32], values: Out<'_, i32>) -> Outcome;
    /// The strings stay valid until the next call.
    fn get_string(&mut self, references: &[u32]) -> Result<&[CString], Refusal>;
}

impl<M: Model> Get for Slave<M> {
    fn get_real(&mut self, references: &[u32], values: Out<'_, f64>) -> Outcome {
        self.check(Call::Get, "fmi2GetReal")?;
        let mut wanted = 0;
        for reference in references {
            match self.layout.reals.get(*reference as usize) {
                Some(real) => wanted |= real.slot.evaluation,
                None => return Err(no_such(*reference)),
            }
        }
        self.evaluate(wanted)?;
        let (reals, model) = (self.layout.reals.as_slice(), &mut self.state.model);
        values.write(references.iter().map(|reference| match reals.get(*reference as usize) {
            Some(real) => *(real.lens)(model),
            // All are there: this only spares the loop a branch that panics.
            None => 0.0,
        }));
        Ok(())
    }

    fn get_integer(&mut self, references: &[u32], values: Out<'_, i32>) -> Outcome {
        let layout = self.prepare(|l| &l.integers, "fmi2GetInteger", references)?;
        let mut wrong = None;
        let read = self.each(&layout, &layout.integers, references, |access, model| match access {
            Access::Integer { get, .. } | Access::Enumeration { get, .. } => get(model),
            _ => Ok(0),
        });
        values.write(read.zip(0..).map_while(|(value, i)| value.map_err(|why| wrong = Some((i, why))).ok()));
        let Some((i, why)) = wrong else { return Ok(()) };
        let slot = find(&layout.integers, references[i])?;
        Err(Refusal::error(format!("{}: {why}", self.name(slot))))
    }

    fn get_boolean(&mut self, references: &[u32], values: Out<'_, i32>) -> Outcome {
        let layout = self.prepare(|l| &l.booleans, "fmi2GetBoolean", references)?;
        values.write(self.each(&layout, &layout.booleans, references, |access, model| match access {
            Access::Boolean(field) => i32::from(*field(model)),
            _ => 0,
        }));
        Ok(())
    }

    fn get_string(&mut self, references: &[u32]) -> Result<&[CString], Refusal> {
        let layout = self.prepare(|l| &l.strings, "fmi2GetString", references)?;
        let mut strings = Vec::new();
        strings
            .try_reserve_exact(references.len())
            .map_err(|_| Refusal::error(format!("fmi2GetString: no memory for {} strings", references.len())))?;
        strings.extend(self.each(&layout, &layout.strings, references, |access, model| match access {
            Access::String(field) => CString::new(field(model).replace('\0', "")).unwrap_or_default(),
            _ => CString::default(),
        }));
        self.strings = strings;
        Ok(&self.strings)
    }
}

impl<M: Model> Slave<M> {
    /// Checks the references of variables that live in `Access`es, and runs what they need.
    fn prepare(
        &mut self,
        slots: impl Fn(&Layout<M>) -> &[Slot],
        what: &str,
        references: &[u32],
    ) -> Result<Arc<Layout<M>>, Refusal> {
        self.check(Call::Get, what)?;
        let layout = Arc::clone(&self.layout);
        let mut wanted = 0;
        for reference in references {
            wanted |= find(slots(&layout), *reference)?.evaluation;
        }
        self.evaluate(wanted)?;
        Ok(layout)
    }

    /// The values of variables whose references have been checked.
    fn each<T>(
        &mut self,
        layout: &Layout<M>,
        slots: &[Slot],
        references: &[u32],
        read: impl Fn(&Access<M>, &mut M) -> T,
    ) -> impl Iterator<Item = T> {
        let model = &mut self.state.model;
        references.iter().map(move |reference| {
            let slot = &slots[*reference as usize];
            read(&layout.variables[slot.variable as usize].access, model)
        })
    }
}
