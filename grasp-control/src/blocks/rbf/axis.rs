//! One-dimensional Gaussians, evaluated for four axes at a time.

use super::layout::MAX_PER_AXIS;
use crate::blocks::exponential::exp;
use crate::blocks::four::Four;

/// Activations that are smaller count as zero.
pub(super) const NEGLIGIBLE: f64 = 1e-30;

/// Equally spaced Gaussians on [−1, 1].
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    nodes: usize,
    /// Distance of neighbouring centres Δ.
    pub spacing: f64,
    /// 1/b².
    pub sharpness: f64,
    /// Beyond this |x| every Gaussian is negligible.
    reach: f64,
    /// exp(−c²/b²) of the centres.
    heights: [f64; MAX_PER_AXIS],
}

impl Axis {
    pub fn new(nodes: usize, width: f64) -> Self {
        let spacing = if nodes > 1 { 2.0 / (nodes - 1) as f64 } else { 0.0 };
        let mut axis = Self {
            nodes,
            spacing,
            sharpness: width.powi(-2),
            // A little farther than where the outermost is just negligible, so that rounding cannot matter.
            reach: 1.0 + 1.01 * width * (-NEGLIGIBLE.ln()).sqrt(),
            heights: [0.0; MAX_PER_AXIS],
        };
        for node in 0..nodes {
            axis.heights[node] = exp(-axis.centre(node).powi(2) * axis.sharpness);
        }
        axis
    }

    pub fn centre(&self, node: usize) -> f64 {
        (node as f64 - 0.5 * (self.nodes - 1) as f64) * self.spacing
    }

    /// Inputs, clamped to the reach.
    ///
    /// With b ≥ 0.1 no exponent of one axis, x²/b² or xΔ/b², exceeds 370, so no power of their exponentials overflows.
    #[inline(always)]
    pub fn clamped<V: Four>(&self, x: V) -> V {
        x.within(self.reach)
    }

    /// The exponent −x²/b² of clamped inputs.
    #[inline(always)]
    pub fn squares<V: Four>(&self, x: V) -> V {
        x * x * V::splat(-self.sharpness)
    }

    /// The exponent xΔ/b² of clamped inputs.
    #[inline(always)]
    pub fn half_steps<V: Four>(&self, x: V) -> V {
        x * V::splat(self.spacing * self.sharpness)
    }

    /// exp(−(x − cⱼ)²/b²)/exp(−x²/b²) of the `n` = `self.nodes` nodes of four axes, from exp(xΔ/b²) of each.
    #[inline(always)]
    pub fn ratios<V: Four>(&self, n: usize, half_step: V) -> [V; MAX_PER_AXIS] {
        // exp(2xc/b²): the centres are even multiples of Δ/2 when n is odd, odd ones when it is even.
        let one = V::splat(1.0);
        let up = half_step * half_step;
        let down = one / up;
        let mut ratios = [one; MAX_PER_AXIS];
        let (n, middle) = (n.min(MAX_PER_AXIS), n.min(MAX_PER_AXIS) / 2);
        if n.is_multiple_of(2) && middle > 0 {
            ratios[middle] = half_step;
            ratios[middle - 1] = one / half_step;
        }
        for node in middle + 1..n {
            ratios[node] = ratios[node - 1] * up;
            ratios[n - 1 - node] = ratios[n - node] * down;
        }
        for node in 0..n {
            ratios[node] = ratios[node] * V::splat(self.heights[node]);
        }
        ratios
    }
}
