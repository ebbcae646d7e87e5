//! What inputs alone decide, and neither what has been learnt nor the low-pass. It is kept for commands before a step, which then finds it,
//! and for steps whose inputs are those of the step before.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]

use super::HUBS;
use super::signals::Signals;
use super::table::Table;
use crate::blocks::exponential::powers;
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::Wide;
use crate::blocks::four::{Four, Lanes};
use crate::blocks::rbf::{GRID_ACTIVATIONS, GridActivations, STILL_ACTIVATIONS, still_activations};
use crate::signals::Inputs;

/// Signals and activations for some inputs.
#[derive(Debug, Default)]
#[repr(C, align(32))] // Registers are then not read from two lines of the cache.
pub(super) struct Evaluation {
    grids: [[Lanes; GRID_ACTIVATIONS]; HUBS],
    /// The star's, along the axes that the shear rates do not move.
    pub still: [Lanes; STILL_ACTIVATIONS],
    error: Lanes,
    s: Lanes,
    regressor: Lanes,
    tanh: Lanes,
    common: [f64; HUBS],
    still_norm2: f64,
}

impl Evaluation {
    /// For these inputs.
    #[inline(always)]
    fn put<V: Four>(&mut self, table: &Table, inputs: &Inputs) {
        let signals = Signals::<V>::of(table, inputs);
        let [z1, z2, still] = powers(signals.exponents);
        for (hub, z) in [z1, z2].into_iter().enumerate() {
            let grid = GridActivations::new(&table.grid_heights[hub], table.least[hub], z);
            (self.grids[hub], self.common[hub]) = (grid.lanes(), grid.common);
        }
        self.still = still_activations(&table.star_heights[0], still);
        self.tanh = signals.tanh(table).lanes();
        let Signals { error, s, regressor, still_norm2, .. } = signals;
        (self.error, self.s, self.regressor) = (error.lanes(), s.lanes(), regressor.lanes());
        self.still_norm2 = still_norm2;
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    fn put_wide(&mut self, table: &Table, inputs: &Inputs) {
        self.put::<Wide>(table, inputs);
    }

    /// For these inputs: one function for all who need it.
    #[inline(always)]
    pub fn fill<V: Four>(&mut self, table: &Table, inputs: &Inputs) {
        #[cfg(target_arch = "x86_64")]
        if V::IS_WIDE {
            // SAFETY: a wide register is in use.
            return unsafe { self.put_wide(table, inputs) };
        }
        self.put::<V>(table, inputs);
    }

    /// The signals, without exponents.
    #[inline(always)]
    pub fn signals<V: Four>(&self) -> Signals<V> {
        Signals {
            error: V::load(&self.error),
            s: V::load(&self.s),
            regressor: V::load(&self.regressor),
            exponents: [V::splat(0.0); 3],
            still_norm2: self.still_norm2,
        }
    }

    /// tanh(s/ϵ).
    #[inline(always)]
    pub fn tanh<V: Four>(&self) -> V {
        V::load(&self.tanh)
    }

    /// Activations of a hub's grid.
    #[inline(always)]
    pub fn grid<V: Four>(&self, hub: usize) -> GridActivations<V> {
        GridActivations::load(self.common[hub], &self.grids[hub])
    }
}
