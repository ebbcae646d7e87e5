//! One-dimensional Gaussians, evaluated for four axes at a time.

use super::lanes::{LANES, Lanes, MAX_GROUPS, groups};
use super::layout::MAX_PER_AXIS;
use crate::blocks::exponential::exp;

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

    /// The inputs in fours, clamped to the reach, and zeros.
    ///
    /// With b ≥ 0.1 no exponent of one axis, x²/b² or xΔ/b², exceeds 370, so no power of their exponentials overflows.
    #[inline(always)]
    pub fn clamped<const D: usize>(&self, x: [f64; D]) -> [Lanes; MAX_GROUPS] {
        const { assert!(groups(D) <= MAX_GROUPS) };
        let mut clamped = [[0.0; LANES]; MAX_GROUPS];
        for axis in 0..D {
            clamped[axis / LANES][axis % LANES] = x[axis].clamp(-self.reach, self.reach);
        }
        clamped
    }

    /// `scale` exp(−(x − cⱼ)²/b²)/exp(−x²/b²) of the `N` = `self.nodes` nodes of four axes, from exp(xΔ/b²) of each.
    #[inline(always)]
    pub fn values<const N: usize>(&self, scale: Lanes, half_step: Lanes) -> [Lanes; N] {
        // exp(2xc/b²): the centres are even multiples of Δ/2 when N is odd, odd ones when it is even.
        let (mut up, mut down) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            up[lane] = half_step[lane] * half_step[lane];
            down[lane] = 1.0 / up[lane];
        }
        let mut powers = [[1.0; LANES]; N];
        let middle = N / 2;
        if N.is_multiple_of(2) {
            for lane in 0..LANES {
                powers[middle][lane] = half_step[lane];
                powers[middle - 1][lane] = 1.0 / half_step[lane];
            }
        }
        for node in middle + 1..N {
            for lane in 0..LANES {
                powers[node][lane] = powers[node - 1][lane] * up[lane];
                powers[N - 1 - node][lane] = powers[N - node][lane] * down[lane];
            }
        }
        for node in 0..N {
            for lane in 0..LANES {
                let value = scale[lane] * self.heights[node] * powers[node][lane];
                powers[node][lane] = if value > NEGLIGIBLE { value } else { 0.0 };
            }
        }
        powers
    }
}
