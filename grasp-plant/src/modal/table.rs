//! The effect of the exact step of one size on the modal coordinates, four blocks side by side.

use super::block::{Block, Functions};
use crate::cache::OfOneSize;
use crate::dynamics::FORCES;
use std::ops::{Deref, DerefMut};

/// Blocks side by side.
pub(super) const LANES: usize = 4;

/// Numbers of as many blocks.
pub(crate) use grasp_kernel::Lanes;

/// At the beginning of a line of the processor's cache. Elsewhere every other register would be read from two lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Aligned<T>(pub T);

impl<T> Deref for Aligned<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> DerefMut for Aligned<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}

/// Coordinates of a group: the first of each block, then the second.
pub(super) const GROUP: usize = 2 * LANES;

/// The effect of each force on the two coordinates of each block.
pub(super) type Gain = [[Lanes; FORCES]; 2];

/// The effect of a step of one size on a group, with held forces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// e^{Λh} − I.
    pub increment: [[Lanes; 2]; 2],
    /// h φ_1 Γ.
    pub gain: Gain,
}

/// The additional matrices for ramps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramped {
    /// h² φ_2 Γ: the effect of a slope on the coordinates, and of a force on their integral.
    pub gain: Gain,
    /// h (φ_1 − I): the integral of the coordinates' changes since the start of the step.
    pub integral: [[Lanes; 2]; 2],
    /// h³ φ_3 Γ.
    pub integral_gain: Gain,
}

/// The exact step of one size.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub(super) h: f64,
    /// What a step costs of the [`BUDGET`](super::calm::BUDGET).
    pub(super) calm_cost: u32,
    pub(super) held: Vec<Aligned<Held>>,
    pub(super) ramped: Vec<Aligned<Ramped>>,
}

impl Table {
    /// Room for the steps of so many blocks.
    pub fn new(blocks: usize) -> Self {
        let gain = [[[0.0; LANES]; FORCES]; 2];
        let square = [[[0.0; LANES]; 2]; 2];
        let groups = blocks.div_ceil(LANES);
        Self {
            h: 0.0,
            calm_cost: u32::MAX,
            held: vec![Aligned(Held { increment: square, gain }); groups],
            ramped: vec![Aligned(Ramped { gain, integral: square, integral_gain: gain }); groups],
        }
    }

    /// Fills the table for the step of size h of these blocks, with the effects of the forces on each.
    pub(super) fn fill(&mut self, h: f64, blocks: &[Block], gains: &[[[f64; FORCES]; 2]]) {
        self.h = h;
        for (i, (block, gain)) in blocks.iter().zip(gains).enumerate() {
            let (held, ramped) = (&mut self.held[i / LANES], &mut self.ramped[i / LANES]);
            let lane = i % LANES;
            let Functions { increment, first_less_one, second, third } = block.functions(h);
            let (h_2, h_3) = (h * h, h * h * h);
            for r in 0..2 {
                for c in 0..2 {
                    held.increment[r][c][lane] = increment[r][c];
                    ramped.integral[r][c][lane] = h * first_less_one[r][c];
                }
                for (f, (own, other)) in gain[r].iter().zip(gain[1 - r]).enumerate() {
                    held.gain[r][f][lane] = h * (own + (first_less_one[r][r] * own + first_less_one[r][1 - r] * other));
                    ramped.gain[r][f][lane] = h_2 * (second[r][r] * own + second[r][1 - r] * other);
                    ramped.integral_gain[r][f][lane] = h_3 * (third[r][r] * own + third[r][1 - r] * other);
                }
            }
        }
    }

    /// What a step costs of the budget of steps without a look at the state; of a table that is [kept](super::Modal::table_of).
    #[inline]
    pub fn calm_cost(&self) -> u32 {
        self.calm_cost
    }

    /// Every number, padding included.
    #[cfg(test)]
    pub fn entries(&self) -> impl Iterator<Item = &f64> {
        let held = self.held.iter().flat_map(|h| h.increment.as_flattened().iter().chain(h.gain.as_flattened()));
        let ramped = self.ramped.iter().flat_map(|r| {
            r.gain.as_flattened().iter().chain(r.integral.as_flattened()).chain(r.integral_gain.as_flattened())
        });
        held.chain(ramped).flatten()
    }
}

impl OfOneSize for Table {
    fn step_size(&self) -> f64 {
        self.h
    }
}
