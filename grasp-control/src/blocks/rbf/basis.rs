//! The basis: all Gaussians of a network at one point.

use super::Network;
use super::axis::NEGLIGIBLE;
use super::lanes::{LANES, Lanes, MAX_GROUPS, groups, total};
use super::layout::Layout;
use crate::blocks::exponential::exp_all;

/// Where the common factor of a star is smaller, all its activations are negligible.
const NOTHING_IS_NEAR: f64 = 1e-200;

impl<const D: usize> Network<D> {
    /// Evaluates the basis at the normalised input `x`, unless it is evaluated there.
    pub fn activate(&mut self, x: [f64; D]) {
        if self.point == x {
            return;
        }
        #[cfg(target_arch = "x86_64")]
        if super::wide::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.activate_wide(x) };
        }
        self.activate_here(x);
    }

    /// The same arithmetic in wider registers: the same bits, because nothing is fused or summed in another order.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn activate_wide(&mut self, x: [f64; D]) {
        self.activate_here(x);
    }

    #[inline(always)]
    pub(super) fn activate_here(&mut self, x: [f64; D]) {
        self.output = None;
        self.point = x;
        // The exponentials come first, once for all sizes: they are most of the code. Known sizes let the compiler unroll the rest.
        match self.layout {
            Layout::Grid(nodes) => {
                let exponentials = self.grid_exponentials(x);
                match nodes {
                    1 => self.fill_grid::<1>(&exponentials),
                    2 => self.fill_grid::<2>(&exponentials),
                    3 => self.fill_grid::<3>(&exponentials),
                    4 => self.fill_grid::<4>(&exponentials),
                    5 => self.fill_grid::<5>(&exponentials),
                    6 => self.fill_grid::<6>(&exponentials),
                    7 => self.fill_grid::<7>(&exponentials),
                    8 => self.fill_grid::<8>(&exponentials),
                    _ => self.fill_grid::<9>(&exponentials),
                }
            }
            Layout::Star(rings) => {
                let exponentials = self.star_exponentials(x);
                match rings {
                    0 => self.fill_star::<1>(&exponentials),
                    1 => self.fill_star::<3>(&exponentials),
                    2 => self.fill_star::<5>(&exponentials),
                    3 => self.fill_star::<7>(&exponentials),
                    _ => self.fill_star::<9>(&exponentials),
                }
            }
        }
    }

    /// exp(−x²/b²) of each axis, then exp(xΔ/b²): all at once.
    #[inline(always)]
    fn grid_exponentials(&self, x: [f64; D]) -> [Lanes; 2 * MAX_GROUPS] {
        let axis = &self.axis;
        let groups = groups(D);
        let mut exponentials = [[0.0; LANES]; 2 * MAX_GROUPS];
        for (group, x) in axis.clamped(x).iter().enumerate().take(groups) {
            for lane in 0..LANES {
                exponentials[group][lane] = -x[lane] * x[lane] * axis.sharpness;
                exponentials[groups + group][lane] = x[lane] * axis.spacing * axis.sharpness;
            }
        }
        exp_all(exponentials[..2 * groups].as_flattened_mut());
        exponentials
    }

    /// exp(xΔ/b²) of each axis, then exp(−‖x‖²/b²): all at once.
    #[inline(always)]
    fn star_exponentials(&self, x: [f64; D]) -> [Lanes; MAX_GROUPS] {
        let axis = &self.axis;
        let groups = groups(D);
        let clamped = axis.clamped(x);
        let mut squares = [0.0; LANES];
        for x in clamped {
            for lane in 0..LANES {
                squares[lane] += x[lane] * x[lane];
            }
        }
        let mut exponentials = [[0.0; LANES]; MAX_GROUPS];
        for group in 0..groups {
            for lane in 0..LANES {
                exponentials[group][lane] = clamped[group][lane] * axis.spacing * axis.sharpness;
            }
        }
        exponentials[D / LANES][D % LANES] = -total(squares) * axis.sharpness;
        exp_all(exponentials[..groups].as_flattened_mut());
        exponentials
    }

    /// Tensor product of all axes but the first, the last one running fastest; `N` nodes per axis.
    #[inline(always)]
    fn fill_grid<const N: usize>(&mut self, exponentials: &[Lanes; 2 * MAX_GROUPS]) {
        let axis = &self.axis;
        let groups = groups(D);
        let mut values = [[[0.0; LANES]; N]; MAX_GROUPS];
        for group in 0..groups {
            values[group] = axis.values::<N>(exponentials[group], exponentials[groups + group]);
        }
        for node in 0..N {
            self.outer[node] = values[0][node][0];
        }
        let inner = self.inner.as_flattened_mut();
        inner[0] = 1.0;
        let mut filled = 1;
        for axis in 1..D {
            let mut factors = [0.0; N];
            for node in 0..N {
                factors[node] = values[axis / LANES][node][axis % LANES];
            }
            // From the back, so that no product is overwritten before it is expanded.
            for node in (0..filled).rev() {
                let mut products = [inner[node]; N];
                for (product, factor) in products.iter_mut().zip(factors) {
                    *product *= factor;
                }
                inner[node * N..][..N].copy_from_slice(&products);
            }
            filled *= N;
        }
    }

    /// The origin, then the positions from −1 to 1 without the origin; `N` nodes per axis.
    #[inline(always)]
    fn fill_star<const N: usize>(&mut self, exponentials: &[Lanes; MAX_GROUPS]) {
        let axis = &self.axis;
        let groups = groups(D);
        // One axis alone makes ‖x‖²/b² at most 370. So where it is 460, the other axes leave nothing of any node.
        let common = exponentials[D / LANES][D % LANES];
        let common = if common > NOTHING_IS_NEAR { common } else { 0.0 };
        let (origin, nodes) = self.inner.split_at_mut(1);
        origin[0][0] = if common > NEGLIGIBLE { common } else { 0.0 };
        let middle = N / 2;
        for group in 0..groups {
            // No axis, no node. A field and not constants: to assemble a vector of some `common` and some zeros, the
            // compiler may choose an instruction that valgrind 3.19 does not know, and hosts run under valgrind, too.
            let mut scale = self.presence[group];
            for lane in 0..LANES {
                scale[lane] *= common;
            }
            let values = axis.values::<N>(scale, exponentials[group]);
            for position in 0..middle {
                nodes[position * groups + group] = values[position];
                nodes[(middle + position) * groups + group] = values[middle + 1 + position];
            }
        }
    }
}
