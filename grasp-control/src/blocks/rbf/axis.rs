//! One-dimensional Gaussians, evaluated for four axes at a time.

use super::layout::{Layout, MAX_PER_AXIS};
use crate::blocks::exponential::{LARGEST, exp};
use crate::blocks::four::{Four, LANES, Lanes};
use std::f64::consts::LOG2_E;

/// Activations that are smaller count as zero.
const NEGLIGIBLE: f64 = 1e-30;

/// With Gaussians that are narrower, there are points where a factor of an activation is tiny and another one huge.
const NARROW: f64 = 0.25;

/// With narrow Gaussians, factors that are smaller count as zero.
const TINY: f64 = 1e-100;

/// Distances of nodes from the middle of an axis.
const DISTANCES: usize = MAX_PER_AXIS / 2;

/// Equally spaced Gaussians on [−1, 1], along all `D` axes of a network.
///
/// exp(−(x − c)²/b²) = exp(−x²/b²) exp(2xc/b²) exp(−c²/b²): the first factor is common to all nodes, that of all axes together is
/// exp(−‖x‖²/b²); the second is a power of that of one step along the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis<const D: usize> {
    nodes: usize,
    /// Distance of neighbouring centres Δ.
    spacing: f64,
    /// 1/b².
    pub sharpness: f64,
    /// 1/b², for powers of two.
    pub square: f64,
    /// 2Δ/b², for powers of two; of half a step Δ/b² where the number of nodes is even, for then their centres are odd multiples of Δ/2.
    pub step: f64,
    /// Where exp(−‖x‖²/b²) is not larger, every activation is negligible.
    pub least: f64,
    /// Beyond this |x| that is so.
    pub reach: f64,
    pub is_narrow: bool,
    /// exp(−c²/b²) of the centres by their distance from the middle, the nearest first.
    heights: [f64; DISTANCES],
}

impl<const D: usize> Axis<D> {
    pub fn new(layout: Layout, width: f64) -> Self {
        let nodes = layout.per_axis();
        let spacing = if nodes > 1 { 2.0 / (nodes - 1) as f64 } else { 0.0 };
        let sharpness = width.powi(-2);
        // How far a node is from the origin, and a point from any node where that is negligible; a little farther, so that
        // rounding cannot matter.
        let farthest = if matches!(layout, Layout::Grid(_)) { (D as f64).sqrt() } else { 1.0 };
        let reach = farthest + 1.01 * width * (-NEGLIGIBLE.ln()).sqrt();
        let mut axis = Self {
            nodes,
            spacing,
            sharpness,
            square: LOG2_E * sharpness,
            step: LOG2_E * sharpness * if nodes.is_multiple_of(2) { spacing } else { 2.0 * spacing },
            least: exp(-reach * reach * sharpness),
            reach,
            is_narrow: width < NARROW,
            heights: [0.0; DISTANCES],
        };
        for distance in 0..nodes / 2 {
            axis.heights[distance] = exp(-axis.centre(nodes / 2 - 1 - distance).powi(2) * sharpness);
        }
        axis
    }

    /// exp(−c²/b²) of the centres at a distance from the middle of four axes; 0 in lanes that stand for no axis.
    #[inline(always)]
    pub fn heights(&self, group: usize, distance: usize) -> Lanes {
        std::array::from_fn(|lane| if LANES * group + lane < D { self.heights[distance] } else { 0.0 })
    }

    pub fn centre(&self, node: usize) -> f64 {
        (node as f64 - 0.5 * (self.nodes - 1) as f64) * self.spacing
    }

    /// The exponent of two for one step along four axes, and x², both of inputs that are clamped to the reach.
    ///
    /// With b ≥ 0.1 no exponent exceeds [`LARGEST`].
    #[inline(always)]
    pub fn steps<V: Four>(&self, x: V) -> (V, V) {
        let x = x.within(self.reach);
        (x * V::splat(self.step), x * x)
    }

    /// The exponents with that for exp(−‖x‖²/b²) in the last lane.
    #[inline(always)]
    pub fn with_common<V: Four>(&self, exponents: V, norm2: f64) -> V {
        exponents.with_last(norm2 * -self.square).larger(V::splat(-LARGEST))
    }

    /// exp(−‖x‖²/b²), if any activation is not negligible there.
    #[inline(always)]
    pub fn relevant(&self, common: f64) -> f64 {
        if common > self.least { common } else { 0.0 }
    }

    /// exp(−(x − cⱼ)²/b²)/exp(−x²/b²) of the `n` = `self.nodes` nodes of the four axes of a group, from the powers for one step up and down;
    /// `common` is [`relevant`](Self::relevant).
    ///
    /// For Gaussians that may be narrow.
    #[inline(always)]
    pub fn ratios<V: Four>(&self, n: usize, group: usize, powers: [V; 2], common: f64) -> [V; MAX_PER_AXIS] {
        let mut ratios = self.plain_ratios(n, group, powers);
        if self.is_narrow {
            // Products of two stay finite and normal numbers.
            let least = if common > 0.0 { TINY } else { f64::INFINITY };
            for ratio in &mut ratios {
                *ratio = ratio.above(least);
            }
        }
        ratios
    }

    /// As [`ratios`](Self::ratios), for Gaussians that are not narrow.
    #[inline(always)]
    pub fn plain_ratios<V: Four>(&self, n: usize, group: usize, [up, down]: [V; 2]) -> [V; MAX_PER_AXIS] {
        let mut ratios = [V::splat(1.0); MAX_PER_AXIS];
        let n = n.min(MAX_PER_AXIS);
        let half = n / 2;
        // Half steps where the number of nodes is even.
        let per_node = if n.is_multiple_of(2) { 2 } else { 1 };
        for distance in 0..half {
            // The height first, so that nothing overflows.
            let height = V::load(&self.heights(group, distance));
            let (mut left, mut right) = (height * down, height * up);
            for _ in 0..per_node * distance {
                (left, right) = (left * down, right * up);
            }
            (ratios[half - 1 - distance], ratios[n - half + distance]) = (left, right);
        }
        ratios
    }

    /// `common` times ratios, as the outer factors of a grid.
    #[inline(always)]
    pub fn outer<V: Four>(&self, ratios: V, common: f64) -> V {
        let outer = ratios * V::splat(common);
        // Ten orders above the smallest normal number, so much less than what is negligible divided by the largest other factor.
        if self.is_narrow { outer.above(1e-298) } else { outer }
    }
}
