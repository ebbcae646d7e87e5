//! A network: weights, output, learning.

use super::axis::Axis;
use super::lanes::{LANES, Lanes, MAX_GROUPS, adapt_row, add_scaled, products, total};
use super::layout::{Layout, MAX_PER_AXIS};
use super::stored::Stored;
use crate::blocks::adaptation::LeakyLaw;
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
    pub(super) presence: [Lanes; MAX_GROUPS],
    /// Row by row, see [`Layout::place`].
    pub(super) weights: Vec<Lanes>,
    pub(super) point: [f64; D],
    /// Activations along a grid's first axis, one per row; a star has one row only, and 1.
    pub(super) outer: [f64; MAX_PER_AXIS],
    /// What all rows share: a grid's products of all axes but the first; all activations of a star.
    pub(super) inner: Vec<Lanes>,
    /// Ŵᵀ Y at the point, if it is known: four sums that make it up.
    pub(super) output: Option<Lanes>,
}

impl<const D: usize> Network<D> {
    /// A network with zero weights and Gaussians of `width` b > 0 in normalised units.
    #[must_use]
    pub fn new(layout: Layout, width: f64) -> Self {
        let row_length = layout.row_length(D);
        let mut presence = [[0.0; LANES]; MAX_GROUPS];
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
        total(self.output.unwrap_or_else(|| {
            let mut sums = [0.0; LANES];
            for (row, factor) in self.rows() {
                add_scaled(&mut sums, factor, products(row, &self.inner));
            }
            sums
        }))
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
        if super::wide::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.adapt_wide(decay, weight) };
        }
        self.adapt_here(decay, weight);
    }

    /// As [`activate_wide`](Self::activate_wide).
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn adapt_wide(&mut self, decay: f64, weight: f64) {
        self.adapt_here(decay, weight);
    }

    #[inline(always)]
    pub(super) fn adapt_here(&mut self, decay: f64, weight: f64) {
        let mut sums = [0.0; LANES];
        let mut rest = self.weights.as_mut_slice();
        for factor in &self.outer[..self.layout.rows()] {
            let (row, others) = rest.split_at_mut(self.inner.len());
            add_scaled(&mut sums, *factor, adapt_row(row, &self.inner, decay, weight * factor));
            rest = others;
        }
        // What `output` would find, to the bit: the same operations in the same order. It adds the four up, because here
        // the compiler would take the registers apart for that from the beginning.
        self.output = Some(sums);
    }
}
