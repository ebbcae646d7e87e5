//! What a law keeps between calls. It is no state: without it everything is found again, to the bit.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::shared::{Shared, shared};
use super::table::Table;
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
#[derive(Debug, Clone, Default)]
#[repr(C, align(64))] // What a step touches is on as few lines of the cache as can be.
pub(in crate::laws::nabfc) struct Keep {
    /// Tables of step sizes, that of the last step first.
    tables: [Option<Arc<Shared>>; SIZES],
    commands: Commands,
    pub known: Known,
    /// The inputs that the law has seen last.
    pub seen: Inputs,
    /// The last step size that has no table.
    without: f64,
}

impl Keep {
    /// The table of the last step's size, if this is the same.
    #[inline(always)]
    pub(super) fn table(&self, h: f64) -> Option<&Table> {
        self.tables[0].as_ref().filter(|table| table.h == h).map(|table| &***table)
    }

    /// The table of the last step's size, whatever that is: commands do not depend on it.
    #[inline(always)]
    pub(super) fn any_table(&self) -> Option<&Table> {
        self.tables[0].as_ref().map(|table| &***table)
    }

    /// Whether the last step's size has a table and is this one.
    pub fn has_table(&self, h: f64) -> bool {
        self.table(h).is_some()
    }

    /// Whether the loops are evaluated for some inputs.
    #[inline(always)]
    pub fn knows_loops(&self) -> bool {
        self.known == Known::Loops
    }

    /// Keeps the commands for these inputs.
    #[inline(always)]
    pub fn put(&mut self, inputs: &Inputs, commands: Commands) {
        (self.seen, self.commands, self.known) = (*inputs, commands, Known::Commands);
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
