//! A network: weights, output.

use super::activations::Activations;
use super::axis::Axis;
use super::lanes::{products, products_here, total};
use super::layout::{Layout, USUAL_ARM, USUAL_STAR, groups};
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
/// of the weights share one evaluation of the basis. They are no state: copies and serialised networks come without them. A network that
/// was never evaluated has zeros for them.
#[derive(Debug, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
#[repr(C)] // What every step of a law touches comes first.
pub struct Network<const D: usize> {
    /// Row by row, and the tail, see [`Layout::place`].
    pub(super) weights: Weights,
    /// Where it is evaluated.
    pub(super) at: Option<Box<Activations>>,
    pub(super) layout: Layout,
    pub(super) width: f64,
    is_plain: bool,
    pub(super) axis: Axis<D>,
}

impl<const D: usize> Clone for Network<D> {
    fn clone(&self) -> Self {
        let Self { weights, at: _, layout, width, is_plain, axis } = self;
        Self { weights: weights.clone(), at: None, layout: *layout, width: *width, is_plain: *is_plain, axis: *axis }
    }

    /// The same in the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        let Self { weights, at: _, layout, width, is_plain, axis } = source;
        self.weights.clone_from(weights);
        (self.layout, self.width, self.is_plain, self.axis) = (*layout, *width, *is_plain, *axis);
        if let Some(at) = &mut self.at {
            if at.inner.len() == self.layout.row_length(D) { at.forget() } else { self.at = None }
        }
    }
}

impl<const D: usize> Network<D> {
    /// A network with zero weights and Gaussians of `width` b > 0 in normalised units.
    ///
    /// # Panics
    /// If the layout is beyond what [`Layout`] says.
    #[must_use]
    pub fn new(layout: Layout, width: f64) -> Self {
        assert!(layout.is_possible(D), "{layout:?} with {D} axes");
        let axis = Axis::new(layout, width);
        Self {
            layout,
            width,
            is_plain: (layout.is_usual(D) || layout.is_usual_star(D)) && !axis.is_narrow,
            axis,
            weights: Weights::zeros(layout.rows() * layout.row_length(D) + layout.tail(D)),
            at: None,
        }
    }

    /// Where it is evaluated, or is to be.
    #[inline(always)]
    pub(super) fn place(&mut self) -> &mut Activations {
        self.at.get_or_insert_with(|| Activations::nowhere(self.layout, D))
    }

    /// Gives the memory of its activations back.
    pub(crate) fn leave(&mut self) {
        self.at = None;
    }

    /// The weights are others.
    #[inline(always)]
    pub(super) fn forget_outputs(&mut self) {
        if let Some(at) = &mut self.at {
            at.forget_outputs();
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
        self.forget_outputs();
    }

    /// The weights Ŵ, node by node.
    pub fn weights(&self) -> impl Iterator<Item = f64> {
        let length = LANES * self.layout.row_length(D);
        (0..self.layout.nodes(D)).map(move |node| {
            let (row, lane) = self.layout.place(D, node);
            self.weights.as_flattened()[length * row + lane]
        })
    }

    pub(super) fn set_weight(&mut self, node: usize, weight: f64) {
        let (row, lane) = self.layout.place(D, node);
        let length = LANES * self.layout.row_length(D);
        self.weights.as_flattened_mut()[length * row + lane] = weight;
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
        let Some(at) = &self.at else { return 0.0 };
        total(match at.output {
            Some(sums) => sums,
            // SAFETY: a wide register is in use.
            #[cfg(target_arch = "x86_64")]
            None if V::IS_WIDE => unsafe { self.sums_wide(at) },
            None => self.sums_narrow(at),
        })
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    fn sums_wide(&self, at: &Activations) -> Lanes {
        self.sums::<Wide>(at)
    }

    #[inline(never)]
    fn sums_narrow(&self, at: &Activations) -> Lanes {
        self.sums::<Narrow>(at)
    }

    #[inline(always)]
    fn sums<V: Four>(&self, at: &Activations) -> Lanes {
        if matches!(self.layout, Layout::Star(_)) {
            let of_both = if let (Some(still), Some((w, y))) = (&at.kept, self.usual_star(at)) {
                // What is usual first, of known length.
                const STILL: usize = USUAL_STAR - USUAL_ARM;
                V::load(still) + products_here::<V>(&w[STILL..], &y[STILL..])
            } else {
                let still = self.layout.still(D).min(self.weights.len());
                let (w, y) = (self.weights.split_at(still), at.inner.split_at(still));
                products_here::<V>(w.0, y.0) + products_here::<V>(w.1, y.1)
            };
            return (V::splat(at.outer[0][0]) * of_both).lanes();
        }
        // There are no grids with more axes.
        if groups(D) > 1 {
            return [0.0; LANES];
        }
        let (rows, tail) = self.weights.split_at(self.weights.len() - self.layout.tail(D));
        let mut sums = products_here::<V>(tail, &at.outer);
        for (row, factor) in rows.chunks_exact(at.inner.len()).zip(at.outer.as_flattened()) {
            sums = sums + V::splat(*factor) * products_here::<V>(row, &at.inner);
        }
        sums.lanes()
    }

    /// Weights and activations of a usual star.
    #[inline(always)]
    fn usual_star<'a>(&'a self, at: &'a Activations) -> Option<(&'a [Lanes; USUAL_STAR], &'a [Lanes; USUAL_STAR])> {
        Some(((*self.weights).try_into().ok()?, at.inner.as_slice().try_into().ok()?))
    }

    /// Whether it has the usual size and no narrow Gaussians, so that the ways for plain networks are open.
    #[inline(always)]
    pub(crate) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// ‖Y‖² at the last activation: the gain with which the network learns there.
    #[must_use]
    pub fn learning_gain(&self) -> f64 {
        let Some(at) = &self.at else { return 0.0 };
        let factors = &at.outer.as_flattened()[..self.layout.rows()];
        // In the tail, the first axis has its activations alone.
        let alone = if self.layout.is_usual(D) { 1.0 } else { 0.0 };
        if self.axis.is_narrow {
            // The factors of an activation may be so tiny and so huge that their squares are not numbers.
            let of_row = |factor: &f64| {
                let activations = at.inner.as_flattened().iter().map(|ratio| factor * ratio);
                activations.map(|activation| activation * activation).sum::<f64>() + alone * (factor * factor)
            };
            return factors.iter().map(of_row).sum();
        }
        let outer: f64 = factors.iter().map(|factor| factor * factor).sum();
        outer * (total(products(&at.inner, &at.inner)) + alone)
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
        self.forget_outputs();
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
}
