//! The effect of the exact step of one size on the modal coordinates, four blocks side by side.
//!
//! With held forces f the forces travel by what the coordinates and ζ at the start of the step and f determine. With o the row of ẏ_M,
//!
//! ```text
//! Δy_M    = o h φ_1 z + o h² φ_2 Γ f + velocity (h ζ + ½ h² gain·f),
//! Δw_i(l) = w_i (e^{Λh} − I) z + w_i h φ_1 Γ f,   l Δθ_i = Δw_i(l) + Δy_M,   Δζ = h gain·f.
//! ```
//!
//! So these sums need not wait for the next coordinates.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::arrangement::{Arrangement, Parity, Parts, Row};
use super::block::{Block, Functions};
use super::four::Four;
use super::readings::Readings;
use super::step::Rigid;
use crate::cache::OfOneSize;
use crate::dynamics::FORCES;

/// Blocks side by side.
pub(super) const LANES: usize = 4;

/// Numbers of as many blocks.
pub(crate) use grasp_kernel::Lanes;

/// Coordinates of a group: the first of each block, then the second.
pub(super) const GROUP: usize = 2 * LANES;

/// The effect of each force on the two coordinates of each block.
pub(super) type Gain<const DRIVES: usize> = [[Lanes; DRIVES]; 2];

/// The effect of a step of one size on a group, with held forces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held<const DRIVES: usize> {
    /// e^{Λh} − I.
    pub increment: [[Lanes; 2]; 2],
    /// h φ_1 Γ.
    pub gain: Gain<DRIVES>,
    /// How far what is driven (θ_1, θ_2 and y_M, or what an even or odd block sees of them) travels per coordinate at the start.
    pub travel: [Row; DRIVES],
}

/// The additional matrices for ramps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramped<const DRIVES: usize> {
    /// h² φ_2 Γ: the effect of a slope on the coordinates, and of a force on their integral.
    pub gain: Gain<DRIVES>,
    /// h (φ_1 − I): the integral of the coordinates' changes since the start of the step.
    pub integral: [[Lanes; 2]; 2],
    /// h³ φ_3 Γ.
    pub integral_gain: Gain<DRIVES>,
}

/// Of which of three forces an even or odd block's gains are, and of which travels its rows: of the first arm, and of the object.
const EVEN: [usize; 2] = [0, 2];
const ODD: [usize; 1] = [0];
const ANY: [usize; FORCES] = [0, 1, 2];

/// The exact step of one size.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub(super) h: f64,
    /// What a step costs of the [`BUDGET`](super::calm::BUDGET).
    pub(super) calm_cost: u32,
    /// What ζ and each held force add to the travels of θ_1, θ_2 and y_M, and in the last lane to ζ. Of equal arms: what ζ, τ_1 + τ_2, the force
    /// on the object and τ_1 − τ_2 add to ½(θ_1 + θ_2), y_M, ½(θ_1 − θ_2) and ζ.
    travel: [Lanes; 1 + FORCES],
    pub(super) held: Parts<Held<3>, Held<2>, Held<1>>,
    pub(super) ramped: Parts<Ramped<3>, Ramped<2>, Ramped<1>>,
}

/// The step's effect on one block, and on what it is read by: as in [`Held`] and [`Ramped`], of all forces.
struct OfBlock {
    increment: [[f64; 2]; 2],
    gain: [[f64; FORCES]; 2],
    travel: [[f64; 2]; FORCES],
    integral: [[f64; 2]; 2],
    ramped_gain: [[f64; FORCES]; 2],
    integral_gain: [[f64; FORCES]; 2],
}

impl OfBlock {
    /// The step of size h of a block: with the effects of the forces, and the rows by which the tips and the object's velocity see it.
    fn new(
        h: f64,
        block: &Block,
        gain: &[[f64; FORCES]; 2],
        tips: &[[f64; 2]; 2],
        object: [f64; 2],
        length: f64,
    ) -> Self {
        let Functions { increment, first_less_one, second, third } = block.functions(h);
        let (h_2, h_3) = (h * h, h * h * h);
        let per_force = |of: &dyn Fn(usize, f64, f64) -> f64| {
            [0, 1].map(|r| std::array::from_fn(|f| of(r, gain[r][f], gain[1 - r][f])))
        };
        let rise: [f64; 2] = std::array::from_fn(|c| {
            h * (object[c] + (object[0] * first_less_one[0][c] + object[1] * first_less_one[1][c]))
        });
        let turn = |tip: &[f64; 2]| {
            std::array::from_fn(|c| (tip[0] * increment[0][c] + tip[1] * increment[1][c] + rise[c]) / length)
        };
        Self {
            increment,
            gain: per_force(&|r, own, other| {
                h * (own + (first_less_one[r][r] * own + first_less_one[r][1 - r] * other))
            }),
            travel: [turn(&tips[0]), turn(&tips[1]), rise],
            integral: first_less_one.map(|row| row.map(|entry| h * entry)),
            ramped_gain: per_force(&|r, own, other| h_2 * (second[r][r] * own + second[r][1 - r] * other)),
            integral_gain: per_force(&|r, own, other| h_3 * (third[r][r] * own + third[r][1 - r] * other)),
        }
    }

    /// Puts it into its lane.
    #[inline(never)]
    fn put<const DRIVES: usize>(
        &self,
        held: &mut Held<DRIVES>,
        ramped: &mut Ramped<DRIVES>,
        lane: usize,
        drives: [usize; DRIVES],
    ) {
        for r in 0..2 {
            for c in 0..2 {
                held.increment[r][c][lane] = self.increment[r][c];
                ramped.integral[r][c][lane] = self.integral[r][c];
            }
            for (to, from) in drives.into_iter().enumerate() {
                held.gain[r][to][lane] = self.gain[r][from];
                held.travel[to][r][lane] = self.travel[from][r];
                ramped.gain[r][to][lane] = self.ramped_gain[r][from];
                ramped.integral_gain[r][to][lane] = self.integral_gain[r][from];
            }
        }
    }
}

impl<const DRIVES: usize> Held<DRIVES> {
    const NONE: Self = Self {
        increment: [[[0.0; LANES]; 2]; 2],
        gain: [[[0.0; LANES]; DRIVES]; 2],
        travel: [[[0.0; LANES]; 2]; DRIVES],
    };

    fn largest_change(&self) -> f64 {
        let size = |numbers: &[f64]| numbers.iter().map(|number| number.abs()).sum::<f64>();
        // By lanes all of them would be a few times less.
        let rows = self.increment.iter().zip(&self.gain);
        rows.map(|(increment, gain)| size(increment.as_flattened()) + size(gain.as_flattened())).fold(0.0, f64::max)
    }

    #[cfg(test)]
    fn entries(&self) -> impl Iterator<Item = &f64> {
        let Self { increment, gain, travel } = self;
        increment.iter().flatten().chain(gain.iter().flatten()).chain(travel.iter().flatten()).flatten()
    }
}

impl<const DRIVES: usize> Ramped<DRIVES> {
    const NONE: Self = Self {
        gain: [[[0.0; LANES]; DRIVES]; 2],
        integral: [[[0.0; LANES]; 2]; 2],
        integral_gain: [[[0.0; LANES]; DRIVES]; 2],
    };
}

impl Table {
    /// Room for the steps of blocks that lie so.
    pub(super) fn new(arrangement: Arrangement) -> Self {
        Self {
            h: 0.0,
            calm_cost: u32::MAX,
            travel: [[0.0; LANES]; 1 + FORCES],
            held: Parts::new(arrangement, Held::NONE, Held::NONE, Held::NONE),
            ramped: Parts::new(arrangement, Ramped::NONE, Ramped::NONE, Ramped::NONE),
        }
    }

    /// Fills the table for the step of size h of these blocks, with the effects of the forces on each, and for arms of this length.
    pub(super) fn fill(
        &mut self,
        h: f64,
        blocks: &[Block],
        gains: &[[[f64; FORCES]; 2]],
        readings: &Readings,
        rigid: &Rigid,
        length: f64,
    ) {
        self.h = h;
        // Of w_1(l), w_2(l) and y_M, by force.
        let mut travel = rigid.gain.map(|gain| [0.0, 0.0, 0.5 * h * h * (rigid.velocity * gain)]);
        for (i, (block, gain)) in blocks.iter().zip(gains).enumerate() {
            let (tips, object) = readings.of_block(i);
            let of_block = OfBlock::new(h, block, gain, &tips, object, length);
            for (f, travel) in travel.iter_mut().enumerate() {
                for (tip, travel) in tips.iter().zip(&mut *travel) {
                    *travel += tip[0] * of_block.gain[0][f] + tip[1] * of_block.gain[1][f];
                }
                travel[2] += object[0] * of_block.ramped_gain[0][f] + object[1] * of_block.ramped_gain[1][f];
            }
            let (group, lane) = readings.arrangement.place(i);
            let Self { held, ramped, .. } = self;
            match readings.arrangement.parity(i) {
                None => of_block.put(&mut held.any[group], &mut ramped.any[group], lane, ANY),
                Some(Parity::Even) => of_block.put(&mut held.even[group], &mut ramped.even[group], lane, EVEN),
                Some(Parity::Odd) => of_block.put(&mut held.odd[group], &mut ramped.odd[group], lane, ODD),
            }
        }
        let rise = h * rigid.velocity;
        let by_force: [Lanes; FORCES] = std::array::from_fn(|f| {
            let [first, second, rise] = travel[f];
            [(first + rise) / length, (second + rise) / length, rise, h * rigid.gain[f]]
        });
        self.travel = if readings.arrangement.equal_arms {
            let [[first, second, rise_by_torque, push], _, [by_object, _, rise_by_object, push_by_object]] = by_force;
            [
                [rise / length, rise, 0.0, 0.0],
                [0.5 * (first + second), rise_by_torque, 0.0, push],
                [by_object, rise_by_object, 0.0, push_by_object],
                [0.0, 0.0, 0.5 * (first - second), 0.0],
            ]
        } else {
            let [first, second, object] = by_force;
            [[rise / length, rise / length, rise, 0.0], first, second, object]
        };
    }

    /// How far θ_1, θ_2 and y_M travel while forces are held, and in the last lane by how much ζ grows: from the sums over the coordinates, whose
    /// last lane is zero, ζ at the start, and the forces, or of equal arms the [sides](super::arrangement::sides).
    #[inline(always)]
    pub(super) fn travel<V: Four>(&self, sums: V, zeta: f64, forces: &[V; FORCES], equal_arms: bool) -> V {
        let [by_zeta, first, second, third] = &self.travel;
        let with_zeta = V::load(by_zeta).times(V::splat(zeta)).plus(V::load(first).times(forces[0]));
        let others = V::load(second).times(forces[1]).plus(V::load(third).times(forces[2]));
        let travel = sums.plus(with_zeta.plus(others));
        if equal_arms { travel.apart() } else { travel }
    }

    /// What a step costs of the budget of steps without a look at the state; of a table that is [kept](super::Modal::table_of).
    #[inline]
    pub fn calm_cost(&self) -> u32 {
        self.calm_cost
    }

    /// The sizes of what a step adds to a coordinate: the largest sum over the coordinates and forces.
    pub(super) fn largest_change(&self) -> f64 {
        let Parts { any, even, odd } = &self.held;
        let of = |change: f64, part: f64| change.max(part);
        any.iter()
            .map(|held| held.largest_change())
            .chain(even.iter().map(|held| held.largest_change()))
            .chain(odd.iter().map(|held| held.largest_change()))
            .fold(0.0, of)
    }

    /// Every number, padding included.
    #[cfg(test)]
    pub fn entries(&self) -> impl Iterator<Item = &f64> {
        let Parts { any, even, odd } = &self.held;
        let held = any.iter().flat_map(|h| h.entries()).chain(even.iter().flat_map(|h| h.entries()));
        let held = held.chain(odd.iter().flat_map(|h| h.entries()));
        let Parts { any, even, odd } = &self.ramped;
        let ramped = any.iter().flat_map(|r| r.entries()).chain(even.iter().flat_map(|r| r.entries()));
        held.chain(ramped.chain(odd.iter().flat_map(|r| r.entries()))).chain(self.travel.as_flattened())
    }
}

#[cfg(test)]
impl<const DRIVES: usize> Ramped<DRIVES> {
    fn entries(&self) -> impl Iterator<Item = &f64> {
        let Self { gain, integral, integral_gain } = self;
        gain.iter().flatten().chain(integral.iter().flatten()).chain(integral_gain.iter().flatten()).flatten()
    }
}

impl OfOneSize for Table {
    fn step_size(&self) -> f64 {
        self.h
    }
}
