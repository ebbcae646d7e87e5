//! What a law keeps between calls. It is no state: without it everything is found again, to the bit.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::evaluation::Evaluation;
use super::shared::{Shared, shared};
use super::table::Table;
use crate::blocks::four::Four;
use crate::law::StepError;
use crate::laws::nabfc::Nabfc;
use crate::signals::{Commands, Inputs};
use std::sync::Arc;

/// Step sizes whose tables a law keeps.
const SIZES: usize = 4;

/// What is known for the inputs that the law has seen last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::laws::nabfc) enum Known {
    #[default]
    Nothing,
    /// The loops are evaluated, where their points say so.
    Loops,
    /// The commands.
    Commands,
}

/// What is kept.
#[derive(Debug, Default)]
#[repr(C, align(64))] // What a step touches is on as few lines of the cache as can be.
pub(in crate::laws::nabfc) struct Keep {
    /// Tables of step sizes, that of the last step first.
    tables: [Option<Arc<Shared>>; SIZES],
    commands: Commands,
    pub known: Known,
    /// Whether the evaluation is of the inputs that the law has seen last.
    is_evaluated: bool,
    /// The inputs that the law has seen last.
    pub seen: Inputs,
    /// The last step size that has no table.
    without: f64,
    /// What the usual step does without, unless it has the inputs of the call before.
    evaluation: Evaluation,
}

impl Clone for Keep {
    /// Without the evaluation.
    fn clone(&self) -> Self {
        let Self { tables, commands, known, is_evaluated: _, seen, without, evaluation: _ } = self;
        Self {
            tables: tables.clone(),
            commands: *commands,
            known: *known,
            is_evaluated: false,
            seen: *seen,
            without: *without,
            evaluation: Evaluation::default(),
        }
    }

    fn clone_from(&mut self, source: &Self) {
        let Self { tables, commands, known, is_evaluated: _, seen, without, evaluation: _ } = source;
        self.tables.clone_from(tables);
        (self.commands, self.known, self.is_evaluated) = (*commands, *known, false);
        (self.seen, self.without) = (*seen, *without);
    }
}

impl Keep {
    /// The table of the last step's size, if this is the same.
    #[inline(always)]
    pub(super) fn table(&self, h: f64) -> Option<&Table> {
        self.tables[0].as_ref().filter(|table| table.h == h).map(|table| &***table)
    }

    /// Whether the last step's size has a table and is this one.
    pub fn has_table(&self, h: f64) -> bool {
        self.table(h).is_some()
    }

    /// Whether these inputs are the last that the law has seen.
    #[inline(always)]
    pub(super) fn has_seen(&self, inputs: &Inputs) -> bool {
        // In motion the first one differs already.
        let [first, then] = [&self.seen, inputs].map(|inputs| inputs.measured.theta[0].to_bits());
        first == then && self.has_seen_all_of(inputs)
    }

    // Not inlined: the compiler would compare all of them in every step.
    #[inline(never)]
    fn has_seen_all_of(&self, inputs: &Inputs) -> bool {
        self.seen.has_bits_of(inputs)
    }

    /// The evaluation for these inputs, which may have been seen last, with the table of the last step's size, whatever that is: the
    /// evaluation does not depend on it.
    #[inline(always)]
    pub(super) fn evaluated<V: Four>(&mut self, inputs: &Inputs, are_seen: bool) -> Option<(&Table, &Evaluation)> {
        let table = self.tables[0].as_ref()?;
        if !(self.is_evaluated && are_seen) {
            self.evaluation.fill::<V>(table, inputs);
            (self.seen, self.known, self.is_evaluated) = (*inputs, Known::Nothing, true);
        }
        Some((table, &self.evaluation))
    }

    /// These inputs are the last that the law has seen, and nothing but this is known for them.
    #[inline(always)]
    pub fn see(&mut self, inputs: &Inputs, known: Known) {
        (self.seen, self.known, self.is_evaluated) = (*inputs, known, false);
    }

    /// Whether the loops are evaluated for some inputs.
    #[inline(always)]
    pub fn knows_loops(&self) -> bool {
        self.known == Known::Loops
    }

    /// Keeps the commands for these inputs.
    #[inline(always)]
    pub fn put(&mut self, inputs: &Inputs, commands: Commands) {
        self.see(inputs, Known::Commands);
        self.commands = commands;
    }

    /// Keeps the commands for the inputs that the law has seen last.
    #[inline(always)]
    pub(super) fn add(&mut self, commands: Commands) {
        (self.commands, self.known) = (commands, Known::Commands);
    }

    /// They do not hold any more.
    #[inline(always)]
    pub fn forget_commands(&mut self) {
        if self.known == Known::Commands {
            self.known = Known::Nothing;
        }
    }

    /// The commands, if they are known for these inputs.
    #[inline(always)]
    pub fn commands(&self, inputs: &Inputs) -> Option<Commands> {
        (self.known == Known::Commands && self.seen.has_bits_of(inputs)).then_some(self.commands)
    }
}

impl Nabfc {
    /// Other gains: nothing is known any more.
    pub(in crate::laws::nabfc) fn forget(&mut self) {
        self.keep = Keep::default();
    }

    /// Gets the table of a step size to the first place, if there is one. A new size gets one at once while there is room, later if it
    /// comes twice without another new one between: where every step has another size, that would be in vain.
    #[cold]
    #[inline(never)]
    pub(in crate::laws::nabfc) fn adopt(&mut self, h: f64) -> bool {
        if StepError::check_size(h).is_err() {
            return false;
        }
        let place = self.keep.tables.iter().position(|table| table.as_ref().is_none_or(|table| table.h == h));
        if place.is_none() && self.keep.without != h {
            self.keep.without = h;
            return false;
        }
        let place = place.unwrap_or(SIZES - 1);
        if self.keep.tables[place].as_ref().is_none_or(|table| table.h != h) {
            let Some(table) = Table::new(self, h) else { return false };
            if self.keep.tables[0].is_none() {
                self.leave();
            }
            self.keep.tables[place] = Some(shared(&table));
        }
        self.keep.tables[..=place].rotate_right(1);
        true
    }

    /// Gives back the memory that usual steps do without: what was asked before the first step had no table.
    fn leave(&mut self) {
        self.object.leave();
        for posture in &mut self.posture {
            posture.leave();
        }
        if self.keep.knows_loops() {
            self.keep.known = Known::Nothing;
        }
    }
}
