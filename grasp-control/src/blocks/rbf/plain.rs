//! Plain networks in the usual step of a law, which evaluates and learns in one go: activations stay in registers.
//!
//! [`learn_grid`] does the same operations in the same order as [`fill_plain_grid`](Network::fill_plain_grid) and [`adapt`](Network::adapt),
//! [`learn_star`] and [`star_output`] as [`fill_plain_both`](Network::fill_plain_both) and [`adapt_twice`](Network::adapt_twice), so both the same bits. Where the network was evaluated
//! before, it stays evaluated.

// The usual step is for wide registers, which other processors than x86-64 have not.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]

use super::Network;
use super::lanes::{adapt_row, products_here};
use super::layout::{TAIL, USUAL, USUAL_ARM, USUAL_ROW, USUAL_STAR};
use crate::blocks::four::{Four, LANES, Lanes};

/// What the axes of a plain network have in common, but for the heights of their Gaussians.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlainAxis {
    /// Beyond this |x| every activation is negligible.
    pub reach: f64,
    /// The exponent of two for one step along an axis at x = 1.
    pub step: f64,
    /// −1/b², for powers of two.
    pub common: f64,
    /// Where exp(−‖x‖²/b²) is not larger, every activation is negligible.
    pub least: f64,
}

/// exp(−c²/b²) of the centres of four axes.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct Heights {
    near: Lanes,
    far: Lanes,
}

impl Heights {
    /// exp(−(x − cⱼ)²/b²)/exp(−x²/b²) of the nodes from one end of the axes to the other, without the middle, from the powers for one
    /// step up and down.
    #[inline(always)]
    fn ratios<V: Four>(&self, [up, down]: [V; 2]) -> [V; USUAL_ARM] {
        let (near, far) = (V::load(&self.near), V::load(&self.far));
        [far * down * down, near * down, near * up, far * up * up]
    }
}

/// exp(−‖x‖²/b²), if any activation is not negligible there.
#[inline(always)]
fn relevant<V: Four>(powers: [V; 2], least: f64) -> f64 {
    let common = powers[0].last();
    if common > least { common } else { 0.0 }
}

impl<const D: usize> Network<D> {
    /// Its axes.
    pub(crate) fn plain_axis(&self) -> PlainAxis {
        let axis = &self.axis;
        PlainAxis { reach: axis.reach, step: axis.step, common: -axis.square, least: axis.least }
    }

    /// The heights of a group of its axes.
    pub(crate) fn heights(&self, group: usize) -> Heights {
        let [near, far] = [0, 1].map(|distance| self.axis.heights(group, distance));
        Heights { near, far }
    }

    /// The weights of a usual network, to be changed. Outputs are then not known any more.
    #[inline(always)]
    pub(crate) fn plain_weights<const N: usize>(&mut self) -> Option<&mut [Lanes; N]> {
        self.forget_outputs();
        self.weights.first_chunk_mut()
    }
}

/// Fours in the rows of a usual grid.
const ROWS: usize = USUAL * USUAL_ROW;

/// Fours of weights of a usual grid.
pub(crate) const GRID: usize = ROWS + TAIL;

/// Fours of weights of a usual star.
pub(crate) const STAR: usize = USUAL_STAR;

/// Fours of a star's nodes that stay where only its last axes move.
const STILL: usize = USUAL_STAR - USUAL_ARM;

/// Fours of activations of these nodes, without the origin, which has 1.
pub(crate) const STILL_ACTIVATIONS: usize = USUAL_ARM;

/// One node in a four.
const ALONE: Lanes = [1.0, 0.0, 0.0, 0.0];

/// Weights learn: w ← decay·w + weight·y; returns the new ones.
#[inline(always)]
fn learn<V: Four>(w: &mut Lanes, decay: V, learnt: V) -> V {
    let new = decay * V::load(w) + learnt;
    *w = new.lanes();
    new
}

/// Activations of a grid, without the middle of its second and third axis.
#[derive(Clone, Copy)]
pub(crate) struct GridActivations<V> {
    /// exp(−‖x‖²/b²), or zero where every activation is negligible.
    pub common: f64,
    /// Those along the first axis.
    outer: V,
    /// What all rows share.
    inner: [V; USUAL_ROW],
}

/// Fours of a grid's activations besides what is common.
pub(crate) const GRID_ACTIVATIONS: usize = USUAL_ROW + 1;

impl<V: Four> GridActivations<V> {
    /// Where the `powers` are.
    #[inline(always)]
    pub fn new(heights: &Heights, least: f64, powers: [V; 2]) -> Self {
        let common = relevant(powers, least);
        let [first, second, third, _] = V::columns(heights.ratios(powers));
        let outer = first * V::splat(common);
        let factors = second.lanes();
        let mut inner = [third; USUAL_ROW];
        for i in 0..LANES {
            inner[i] = V::splat(factors[i]) * third;
        }
        inner[USUAL_ROW - 1] = second;
        Self { common, outer, inner }
    }

    /// As numbers in memory.
    #[inline(always)]
    pub fn lanes(&self) -> [Lanes; GRID_ACTIVATIONS] {
        let [a, b, c, d, e, f] = self.inner;
        [self.outer.lanes(), a.lanes(), b.lanes(), c.lanes(), d.lanes(), e.lanes(), f.lanes()]
    }

    /// From numbers in memory.
    #[inline(always)]
    pub fn load(common: f64, [outer, a, b, c, d, e, f]: &[Lanes; GRID_ACTIVATIONS]) -> Self {
        let inner = [V::load(a), V::load(b), V::load(c), V::load(d), V::load(e), V::load(f)];
        Self { common, outer: V::load(outer), inner }
    }
}

/// Four sums that make up a grid's Ŵᵀ Y.
#[inline(always)]
pub(crate) fn grid_output<V: Four>(w: &[Lanes; GRID], at: GridActivations<V>) -> V {
    let GridActivations { common, outer, inner } = at;
    let middle = V::load(&ALONE) * V::splat(common);
    let mut sums = V::load(&w[ROWS]) * outer;
    sums = sums + V::load(&w[ROWS + 1]) * middle;
    let outer = outer.lanes();
    for row in 0..USUAL {
        let factor = V::splat(if row < LANES { outer[row] } else { common });
        let w = &w[USUAL_ROW * row..];
        let mut of_row = V::load(&w[0]) * inner[0];
        for i in 1..USUAL_ROW {
            of_row = of_row + V::load(&w[i]) * inner[i];
        }
        sums = sums + factor * of_row;
    }
    sums
}

/// A grid: Ŵ ← decay·Ŵ + weight·Y; four sums that make up Ŵᵀ Y afterwards.
#[inline(always)]
pub(crate) fn learn_grid<V: Four>(w: &mut [Lanes; GRID], at: GridActivations<V>, (decay, weight): (f64, f64)) -> V {
    let GridActivations { common, outer, inner } = at;
    let (decay, weight) = (V::splat(decay), V::splat(weight));
    // The tail: the nodes in the middle of the second and third axis.
    // Not as a load of a number and zeros: for these the compiler may choose an instruction that valgrind 3.19 does not know.
    let middle = V::load(&ALONE) * V::splat(common);
    let by = weight * outer;
    let mut sums = learn(&mut w[ROWS], decay, by) * outer;
    sums = sums + learn(&mut w[ROWS + 1], decay, weight * middle) * middle;
    let (by, outer, by_common) = (by.lanes(), outer.lanes(), (weight * V::splat(common)).lanes()[0]);
    for row in 0..USUAL {
        let (factor, by) = if row < LANES { (outer[row], by[row]) } else { (common, by_common) };
        let (factor, by) = (V::splat(factor), V::splat(by));
        let mut of_row = V::splat(0.0);
        for i in 0..USUAL_ROW {
            let new = learn(&mut w[USUAL_ROW * row + i], decay, by * inner[i]);
            of_row = if i == 0 { new * inner[i] } else { of_row + new * inner[i] };
        }
        sums = sums + factor * of_row;
    }
    sums
}

/// A star at two points that differ along its last axes: Ŵ ← decay·Ŵ + first·Y' + second·Y''. What its nodes along the first axes then
/// contribute to Ŵᵀ Y, without the common factor: four sums that make it up.
#[inline(always)]
pub(crate) fn learn_star<V: Four>(
    w: &mut [Lanes; STAR],
    still: &[Lanes; STILL_ACTIVATIONS],
    (moving, least): (&Heights, f64),
    [of_first, of_second]: [[V; 2]; 2],
    (decay, shares): (f64, [f64; 2]),
) -> V {
    let (first, second) = (shares[0] * relevant(of_first, least), shares[1] * relevant(of_second, least));
    let decay = V::splat(decay);
    let of_still = adapt_row(&mut w[..STILL], &with_origin(still), decay, V::splat(first + second));
    let (first, second) = (V::splat(first), V::splat(second));
    let (at_first, at_second) = (moving.ratios(of_first), moving.ratios(of_second));
    for i in 0..USUAL_ARM {
        learn(&mut w[STILL + i], decay, first * at_first[i] + second * at_second[i]);
    }
    of_still
}

/// Activations of a star's nodes along its first axes where the `powers` are, without the origin and the common factor.
#[inline(always)]
pub(crate) fn still_activations<V: Four>(heights: &Heights, powers: [V; 2]) -> [Lanes; STILL_ACTIVATIONS] {
    let [a, b, c, d] = heights.ratios(powers);
    [a.lanes(), b.lanes(), c.lanes(), d.lanes()]
}

#[inline(always)]
fn with_origin(&[a, b, c, d]: &[Lanes; STILL_ACTIVATIONS]) -> [Lanes; STILL] {
    [ALONE, a, b, c, d]
}

/// What a star's nodes along its first axes contribute to Ŵᵀ Y, without the common factor: four sums that make it up.
#[inline(always)]
pub(crate) fn still_output<V: Four>(w: &[Lanes; STAR], still: &[Lanes; STILL_ACTIVATIONS]) -> V {
    products_here(&w[..STILL], &with_origin(still))
}

/// Four sums that make up a star's Ŵᵀ Y at another such point, from those of [`learn_star`] or [`still_output`].
#[inline(always)]
pub(crate) fn star_output<V: Four>(w: &[Lanes; STAR], moving: &Heights, least: f64, powers: [V; 2], still: V) -> V {
    let y = moving.ratios(powers);
    let mut of_moving = V::load(&w[STILL]) * y[0];
    for i in 1..USUAL_ARM {
        of_moving = of_moving + V::load(&w[STILL + i]) * y[i];
    }
    V::splat(relevant(powers, least)) * (still + of_moving)
}
