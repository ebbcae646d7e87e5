//! What a network knows where it is evaluated.

use super::Network;
use super::basis::in_lanes;
use super::layout::{GROUPS, Layout, MAX_PER_AXIS, USUAL_ARM, lane};
use crate::blocks::four::{LANES, Lanes};

/// Room for what rows have in common, in fours.
const OUTER: usize = MAX_PER_AXIS.div_ceil(LANES);

/// The activations at one point, and what follows from them. They are no state, and have memory of their own: a step whose activations
/// stay in registers does without.
#[derive(Debug)]
pub(super) struct Activations {
    /// Ŵᵀ Y at the point, if it is known: four sums that make it up.
    pub output: Option<Lanes>,
    /// What a star's nodes that are still contribute to Ŵᵀ Y, without the common factor, if it is known: four sums that make it up.
    pub kept: Option<Lanes>,
    /// The normalised input in the lanes of its axes.
    pub point: [Lanes; GROUPS],
    /// ‖x‖² of the first four axes of two.
    pub first_norm2: f64,
    /// What all activations of a row have in common: those along a grid's first axis, one per row, and exp(−‖x‖²/b²). A star has one
    /// row. Zeros beyond.
    pub outer: [Lanes; OUTER],
    /// What all rows share: a grid's products of all axes but the first; a star's activations; without what is common.
    pub inner: Vec<Lanes>,
    /// A usual star's activations along the last axes at the point before, of which this point differs in these axes only.
    pub before: [Lanes; USUAL_ARM],
    /// exp(−‖x‖²/b²) at that point.
    pub before_common: f64,
}

impl Activations {
    /// Of a network that is evaluated nowhere yet.
    #[cold]
    pub fn nowhere(layout: Layout, dimensions: usize) -> Box<Self> {
        let mut inner = vec![[0.0; LANES]; layout.row_length(dimensions)];
        if matches!(layout, Layout::Star(_)) {
            // The origin.
            inner[0][0] = 1.0;
        }
        Box::new(Self {
            // Unlike any point, so that nothing counts as evaluated.
            point: in_lanes([f64::NAN; 1]),
            first_norm2: 0.0,
            outer: [[0.0; LANES]; OUTER],
            inner,
            before: [[0.0; LANES]; USUAL_ARM],
            before_common: 0.0,
            kept: None,
            output: None,
        })
    }

    /// The weights are others.
    #[inline(always)]
    pub fn forget_outputs(&mut self) {
        (self.kept, self.output) = (None, None);
    }

    /// Nothing counts as evaluated any more.
    pub fn forget(&mut self) {
        self.point = in_lanes([f64::NAN; 1]);
        self.forget_outputs();
    }
}

impl<const D: usize> Network<D> {
    /// The activation of the node whose weight is there.
    #[inline]
    pub(super) fn activation(&self, row: usize, lane: usize) -> f64 {
        let Some(at) = &self.at else { return 0.0 };
        let outer = at.outer.as_flattened();
        // The tail has those along the first axis.
        if row == self.layout.rows() { outer[lane] } else { outer[row] * at.inner.as_flattened()[lane] }
    }

    /// The normalised input.
    pub(super) fn input(&self) -> [f64; D] {
        self.at.as_ref().map_or([0.0; D], |at| std::array::from_fn(|axis| at.point.as_flattened()[lane(D, axis)]))
    }

    /// All activations, node by node.
    pub(super) fn activations(&self) -> impl Iterator<Item = f64> {
        (0..self.layout.nodes(D)).map(|node| {
            let (row, lane) = self.layout.place(D, node);
            self.activation(row, lane)
        })
    }
}
