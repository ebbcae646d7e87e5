//! A network: weights, output, learning.

use super::axis::Axis;
use super::lanes::{adapt_row, products, products_here, total};
use super::layout::{GROUPS, Layout, MAX_PER_AXIS, USUAL_ROW};
use super::stored::Stored;
use crate::blocks::adaptation::LeakyLaw;
use crate::blocks::four::{Four, LANES, Lanes, Narrow};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};
use serde::{Deserialize, Serialize};

/// A network of `D` inputs with its weights.
///
/// The activations of the last [`activate`](Self::activate) are kept, so that the output, its gradient and the update
/// of the weights share one evaluation of the basis. They are no state: serialised networks come back without them.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Network<const D: usize> {
    pub(super) layout: Layout,
    pub(super) width: f64,
    pub(super) axis: Axis,
    /// 1 in the lanes that stand for an axis, 0 in the others.
    pub(super) presence: [Lanes; GROUPS],
    /// Row by row, see [`Layout::place`].
    pub(super) weights: Vec<Lanes>,
    pub(super) point: [f64; D],
    /// Activations along a grid's first axis, one per row; a star has one row only, and 1.
    pub(super) outer: [f64; MAX_PER_AXIS],
    /// What all rows share: a grid's products of all axes but the first; all activations of a star.
    pub(super) inner: Vec<Lanes>,
    /// A star's activations at the point before, of which this point differs in the axes of the second four only.
    pub(super) before: Vec<Lanes>,
    /// exp(xΔ/b²) of the axes of the first four at the point.
    pub(super) still: Lanes,
    /// Ŵᵀ Y at the point, if it is known: four sums that make it up.
    pub(super) output: Option<Lanes>,
}

impl<const D: usize> Network<D> {
    /// A network with zero weights and Gaussians of `width` b > 0 in normalised units.
    ///
    /// # Panics
    /// If the layout is beyond what [`Layout`] says.
    #[must_use]
    pub fn new(layout: Layout, width: f64) -> Self {
        assert!(layout.is_possible(D), "{layout:?} with {D} axes");
        let row_length = layout.row_length(D);
        let mut presence = [[0.0; LANES]; GROUPS];
        presence.as_flattened_mut()[..D].fill(1.0);
        Self {
            layout,
            width,
            axis: Axis::new(layout.per_axis(), width),
            presence,
            weights: vec![[0.0; LANES]; layout.rows() * row_length],
            // Unlike any point, so that nothing counts as evaluated.
            point: [f64::NAN; D],
            outer: [1.0; MAX_PER_AXIS],
            inner: vec![[0.0; LANES]; row_length],
            before: match layout {
                Layout::Grid(_) => Vec::new(),
                Layout::Star(_) => vec![[0.0; LANES]; row_length],
            },
            still: [0.0; LANES],
            output: None,
        }
    }

    /// Whether nodes and widths are those of another network.
    #[must_use]
    pub fn has_layout_of(&self, other: &Self) -> bool {
        self.layout == other.layout && self.width == other.width
    }

    /// Sets all weights to zero.
    pub fn reset(&mut self) {
        self.weights.fill([0.0; LANES]);
        self.output = None;
    }

    /// The weights Ŵ, node by node.
    pub fn weights(&self) -> impl Iterator<Item = f64> {
        (0..self.layout.nodes(D)).map(|node| {
            let (row, lane) = self.layout.place(D, node);
            self.weights.as_flattened()[LANES * row * self.inner.len() + lane]
        })
    }

    pub(super) fn set_weight(&mut self, node: usize, weight: f64) {
        let (row, lane) = self.layout.place(D, node);
        self.weights.as_flattened_mut()[LANES * row * self.inner.len() + lane] = weight;
    }

    /// Centre cⱼ of a node in normalised units.
    #[must_use]
    pub fn centre(&self, node: usize) -> [f64; D] {
        let mut centre = [0.0; D];
        match self.layout {
            Layout::Grid(n) => {
                let mut index = node;
                for component in centre.iter_mut().rev() {
                    *component = self.axis.centre(index % n);
                    index /= n;
                }
            }
            Layout::Star(rings) => {
                if let Some(index) = node.checked_sub(1) {
                    let (axis, position) = (index / (2 * rings), index % (2 * rings));
                    // The node in the middle of the axis is the common one at the origin.
                    centre[axis] = self.axis.centre(position + usize::from(position >= rings));
                }
            }
        }
        centre
    }

    /// The weights row by row, each row with the activation that it shares.
    fn rows(&self) -> impl Iterator<Item = (&[Lanes], f64)> {
        self.weights.chunks_exact(self.inner.len()).zip(self.outer)
    }

    /// Ŵᵀ Y at the last activation.
    #[must_use]
    pub fn output(&self) -> f64 {
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.output_wide() };
        }
        self.output_here::<Narrow>()
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn output_wide(&self) -> f64 {
        self.output_here::<Wide>()
    }

    /// As [`output`](Self::output), for a caller that knows the registers.
    #[inline(always)]
    pub(crate) fn output_here<V: Four>(&self) -> f64 {
        total(match self.output {
            Some(sums) => sums,
            None if V::IS_WIDE => self.sums::<V>(),
            None => self.sums_narrow(),
        })
    }

    #[inline(never)]
    fn sums_narrow(&self) -> Lanes {
        self.sums::<Narrow>()
    }

    #[inline(always)]
    fn sums<V: Four>(&self) -> Lanes {
        // A star has one row, with the factor 1; asked first, for the number of rows is a division.
        if matches!(self.layout, Layout::Star(_)) {
            return products_here::<V>(&self.weights, &self.inner).lanes();
        }
        let mut sums = V::splat(0.0);
        for (row, factor) in self.rows() {
            sums = sums + V::splat(factor) * products_here::<V>(row, &self.inner);
        }
        sums.lanes()
    }

    /// ‖Y‖² at the last activation: the gain with which the network learns there.
    #[must_use]
    pub fn learning_gain(&self) -> f64 {
        let outer: f64 = self.outer[..self.layout.rows()].iter().map(|factor| factor * factor).sum();
        outer * total(products(&self.inner, &self.inner))
    }

    /// ‖Ŵ‖.
    #[must_use]
    pub fn norm(&self) -> f64 {
        total(products(&self.weights, &self.weights)).sqrt()
    }

    /// Ŵ ← Ŵ·radius/‖Ŵ‖ if the weights are outside the ball of this radius: the projection onto Lemma 3's `F_s`.
    pub fn project(&mut self, radius: f64) {
        let norm = self.norm();
        if norm > radius {
            self.scale(radius / norm);
        }
    }

    /// Ŵ ← factor Ŵ.
    pub(super) fn scale(&mut self, factor: f64) {
        for lanes in &mut self.weights {
            for weight in lanes {
                *weight *= factor;
            }
        }
        self.output = None;
    }

    /// d‖Ŵ‖/dt at the last activation, for weights that follow `law` with the forcing s Y: Ŵᵀ(dŴ/dt)/‖Ŵ‖, and from zero
    /// weights ‖dŴ/dt‖.
    #[must_use]
    pub fn norm_rate(&self, law: &LeakyLaw, s: f64) -> f64 {
        let norm = self.norm();
        if norm > 0.0 {
            law.rate(norm, s * self.output() / norm)
        } else {
            law.rate(0.0, s.abs() * self.learning_gain().sqrt())
        }
    }

    /// Gradient of Ŵᵀ Y with respect to the normalised input, at the last activation.
    #[must_use]
    pub fn gradient(&self) -> [f64; D] {
        let mut gradient = [0.0; D];
        for (node, (weight, activation)) in self.weights().zip(self.activations()).enumerate() {
            let pull = -2.0 * self.axis.sharpness * weight * activation;
            for ((slope, x), c) in gradient.iter_mut().zip(self.point).zip(self.centre(node)) {
                // A point so far out that this overflows activates nothing.
                *slope += if pull == 0.0 { 0.0 } else { pull * (x - c) };
            }
        }
        gradient
    }

    /// All activations, node by node.
    pub(super) fn activations(&self) -> impl Iterator<Item = f64> {
        (0..self.layout.nodes(D)).map(|node| {
            let (row, lane) = self.layout.place(D, node);
            self.outer[row] * self.inner.as_flattened()[lane]
        })
    }

    /// Ŵ ← decay·Ŵ + weight·Y, with the Y of the last activation.
    pub fn adapt(&mut self, decay: f64, weight: f64) {
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.adapt_wide(decay, weight) };
        }
        self.adapt_narrow(decay, weight);
    }

    /// As [`adapt`](Self::adapt), for a caller that knows the registers.
    #[inline(always)]
    pub(crate) fn adapt_here<V: Four>(&mut self, decay: f64, weight: f64) {
        #[cfg(target_arch = "x86_64")]
        if V::IS_WIDE {
            // SAFETY: a wide register is in use.
            return unsafe { self.adapt_wide(decay, weight) };
        }
        self.adapt_narrow(decay, weight);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn adapt_wide(&mut self, decay: f64, weight: f64) {
        self.adapt_in::<Wide>(decay, weight);
    }

    #[inline(never)]
    fn adapt_narrow(&mut self, decay: f64, weight: f64) {
        self.adapt_in::<Narrow>(decay, weight);
    }

    #[inline(always)]
    pub(super) fn adapt_in<V: Four>(&mut self, decay: f64, weight: f64) {
        let (inner, outer) = (self.inner.as_slice(), &self.outer);
        // What `output` would find, to the bit: the same operations in the same order.
        let mut sums = V::splat(0.0);
        let decay = V::splat(decay);
        if let (true, Ok(inner)) = (V::IS_WIDE, <&[Lanes; USUAL_ROW]>::try_from(inner)) {
            // The row length by default: the activations stay in registers.
            let mut activations = [V::splat(0.0); USUAL_ROW];
            for i in 0..USUAL_ROW {
                activations[i] = V::load(&inner[i]);
            }
            for (row, factor) in self.weights.as_chunks_mut::<USUAL_ROW>().0.iter_mut().zip(outer) {
                let by = V::splat(weight * factor);
                let mut of_row = V::splat(0.0);
                for i in 0..USUAL_ROW {
                    let new = decay * V::load(&row[i]) + by * activations[i];
                    row[i] = new.lanes();
                    of_row = of_row + new * activations[i];
                }
                sums = sums + V::splat(*factor) * of_row;
            }
        } else {
            for (row, factor) in self.weights.chunks_exact_mut(inner.len()).zip(outer) {
                sums = sums + V::splat(*factor) * adapt_row(row, inner, decay, V::splat(weight * factor));
            }
        }
        self.output = Some(sums.lanes());
    }

    /// Ŵ ← decay·Ŵ + first·Y' + second·Y of a star, with the Y of the last activation and the Y' of the one before, which
    /// [`fill_moving`](Self::fill_moving) kept.
    #[inline(always)]
    pub(crate) fn adapt_twice<V: Four>(&mut self, decay: f64, shares: [f64; 2]) {
        if V::IS_WIDE { self.adapt_twice_in::<V>(decay, shares) } else { self.adapt_twice_narrow(decay, shares) }
    }

    #[inline(never)]
    fn adapt_twice_narrow(&mut self, decay: f64, shares: [f64; 2]) {
        self.adapt_twice_in::<Narrow>(decay, shares);
    }

    #[inline(always)]
    fn adapt_twice_in<V: Four>(&mut self, decay: f64, [first, second]: [f64; 2]) {
        let (decay, first, second) = (V::splat(decay), V::splat(first), V::splat(second));
        for ((w, before), y) in self.weights.iter_mut().zip(&self.before).zip(&self.inner) {
            *w = ((decay * V::load(w) + first * V::load(before)) + second * V::load(y)).lanes();
        }
        self.output = None;
    }
}
