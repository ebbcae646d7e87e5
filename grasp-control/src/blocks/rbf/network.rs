//! A network: weights, output.

use super::axis::Axis;
use super::basis::in_lanes;
use super::lanes::{products, products_here, total};
use super::layout::{GROUPS, Layout, MAX_PER_AXIS, USUAL_ARM, USUAL_STAR, groups, lane};
use super::stored::Stored;
use super::weights::Weights;
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
#[repr(C)] // What every step of a law touches comes first.
pub struct Network<const D: usize> {
    /// Row by row, and the tail, see [`Layout::place`].
    pub(super) weights: Weights,
    /// Ŵᵀ Y at the point, if it is known: four sums that make it up.
    pub(super) output: Option<Lanes>,
    /// What a star's nodes that are still contribute to Ŵᵀ Y, without the common factor, if it is known: four sums that make it up.
    pub(super) kept: Option<Lanes>,
    pub(super) layout: Layout,
    pub(super) width: f64,
    is_plain: bool,
    pub(super) axis: Axis,
    /// The normalised input in the lanes of its axes.
    pub(super) point: [Lanes; GROUPS],
    /// ‖x‖² of the first four axes of two.
    pub(super) first_norm2: f64,
    /// What all activations of a row have in common: those along a grid's first axis, one per row, and exp(−‖x‖²/b²). A star has one
    /// row. Zeros beyond.
    pub(super) outer: [Lanes; OUTER],
    /// What all rows share: a grid's products of all axes but the first; a star's activations; without what is common.
    pub(super) inner: Vec<Lanes>,
    /// A usual star's activations along the last axes at the point before, of which this point differs in these axes only.
    pub(super) before: [Lanes; USUAL_ARM],
    /// exp(−‖x‖²/b²) at that point.
    pub(super) before_common: f64,
}

/// Room for what rows have in common, in fours.
const OUTER: usize = MAX_PER_AXIS.div_ceil(LANES);

impl<const D: usize> Network<D> {
    /// A network with zero weights and Gaussians of `width` b > 0 in normalised units.
    ///
    /// # Panics
    /// If the layout is beyond what [`Layout`] says.
    #[must_use]
    pub fn new(layout: Layout, width: f64) -> Self {
        assert!(layout.is_possible(D), "{layout:?} with {D} axes");
        let row_length = layout.row_length(D);
        let mut inner = vec![[0.0; LANES]; row_length];
        if matches!(layout, Layout::Star(_)) {
            // The origin.
            inner[0][0] = 1.0;
        }
        let axis = Axis::new(layout, D, width);
        Self {
            layout,
            width,
            is_plain: (layout.is_usual(D) || layout.is_usual_star(D)) && !axis.is_narrow,
            axis,
            weights: Weights::zeros(layout.rows() * row_length + layout.tail(D)),
            // Unlike any point, so that nothing counts as evaluated.
            point: in_lanes([f64::NAN; D]),
            first_norm2: 0.0,
            outer: [[0.0; LANES]; OUTER],
            inner,
            before: [[0.0; LANES]; USUAL_ARM],
            before_common: 0.0,
            kept: None,
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
        (self.kept, self.output) = (None, None);
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

    /// The activation of the node whose weight is there.
    #[inline]
    pub(super) fn activation(&self, row: usize, lane: usize) -> f64 {
        let outer = self.outer.as_flattened();
        // The tail has those along the first axis.
        if row == self.layout.rows() { outer[lane] } else { outer[row] * self.inner.as_flattened()[lane] }
    }

    /// The normalised input.
    pub(super) fn input(&self) -> [f64; D] {
        std::array::from_fn(|axis| self.point.as_flattened()[lane(D, axis)])
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
            // SAFETY: a wide register is in use.
            #[cfg(target_arch = "x86_64")]
            None if V::IS_WIDE => unsafe { self.sums_wide() },
            None => self.sums_narrow(),
        })
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    fn sums_wide(&self) -> Lanes {
        self.sums::<Wide>()
    }

    #[inline(never)]
    fn sums_narrow(&self) -> Lanes {
        self.sums::<Narrow>()
    }

    #[inline(always)]
    fn sums<V: Four>(&self) -> Lanes {
        if matches!(self.layout, Layout::Star(_)) {
            let of_both = if let (Some(still), Some((w, y))) = (&self.kept, self.usual_star()) {
                // What is usual first, of known length.
                const STILL: usize = USUAL_STAR - USUAL_ARM;
                V::load(still) + products_here::<V>(&w[STILL..], &y[STILL..])
            } else {
                let still = self.layout.still(D).min(self.weights.len());
                let (w, y) = (self.weights.split_at(still), self.inner.split_at(still));
                products_here::<V>(w.0, y.0) + products_here::<V>(w.1, y.1)
            };
            return (V::splat(self.outer[0][0]) * of_both).lanes();
        }
        // There are no grids with more axes.
        if groups(D) > 1 {
            return [0.0; LANES];
        }
        let (rows, tail) = self.weights.split_at(self.weights.len() - self.layout.tail(D));
        let mut sums = products_here::<V>(tail, &self.outer);
        for (row, factor) in rows.chunks_exact(self.inner.len()).zip(self.outer.as_flattened()) {
            sums = sums + V::splat(*factor) * products_here::<V>(row, &self.inner);
        }
        sums.lanes()
    }

    /// Weights and activations of a usual star.
    #[inline(always)]
    fn usual_star(&self) -> Option<(&[Lanes; USUAL_STAR], &[Lanes; USUAL_STAR])> {
        Some(((*self.weights).try_into().ok()?, self.inner.as_slice().try_into().ok()?))
    }

    /// Whether it has the usual size and no narrow Gaussians, so that the ways for plain networks are open.
    #[inline(always)]
    pub(crate) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// ‖Y‖² at the last activation: the gain with which the network learns there.
    #[must_use]
    pub fn learning_gain(&self) -> f64 {
        let factors = &self.outer.as_flattened()[..self.layout.rows()];
        // In the tail, the first axis has its activations alone.
        let alone = if self.layout.is_usual(D) { 1.0 } else { 0.0 };
        if self.axis.is_narrow {
            // The factors of an activation may be so tiny and so huge that their squares are not numbers.
            let of_row = |factor: &f64| {
                let activations = self.inner.as_flattened().iter().map(|ratio| factor * ratio);
                activations.map(|activation| activation * activation).sum::<f64>() + alone * (factor * factor)
            };
            return factors.iter().map(of_row).sum();
        }
        let outer: f64 = factors.iter().map(|factor| factor * factor).sum();
        outer * (total(products(&self.inner, &self.inner)) + alone)
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
        for lanes in &mut *self.weights {
            for weight in lanes {
                *weight *= factor;
            }
        }
        (self.kept, self.output) = (None, None);
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
            for ((slope, x), c) in gradient.iter_mut().zip(self.input()).zip(self.centre(node)) {
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
            self.activation(row, lane)
        })
    }
}
