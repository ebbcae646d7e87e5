//! The basis: all Gaussians of a network at one point.
//!
//! First come the [exponents](Network::exponents), so that a law can take the exponentials of all its networks in one pass; then
//! the activations are [filled in](Network::fill) from the exponentials.

use super::Network;
use super::axis::NEGLIGIBLE;
use super::layout::{GROUPS, Layout, groups, lane};
use crate::blocks::exponential::exp_of;
use crate::blocks::four::{Four, LANES, Lanes, Narrow};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};

/// Where the common factor of a star is smaller, all its activations are negligible.
const NOTHING_IS_NEAR: f64 = 1e-200;

impl<const D: usize> Network<D> {
    /// Evaluates the basis at the normalised input `x`, unless it is evaluated there.
    pub fn activate(&mut self, x: [f64; D]) {
        if self.point == x {
            return;
        }
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.activate_wide(x) };
        }
        self.activate_here::<Narrow>(x);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn activate_wide(&mut self, x: [f64; D]) {
        self.activate_here::<Wide>(x);
    }

    #[inline(always)]
    pub(super) fn activate_here<V: Four>(&mut self, x: [f64; D]) {
        let [first, second] = self.exponents::<V>(x);
        self.fill::<V>(x, &[exp_of(first).lanes(), exp_of(second).lanes()]);
    }

    /// What the exponentials that [`fill`](Self::fill) needs are of.
    ///
    /// A grid: −x²/b² of each axis, then xΔ/b². A star: xΔ/b² of each axis, and −‖x‖²/b² in the lane after the last.
    #[inline(always)]
    pub(crate) fn exponents<V: Four>(&self, x: [f64; D]) -> [V; GROUPS] {
        match self.layout {
            Layout::Grid(_) => {
                let x = self.axis.clamped(V::load(&in_lanes(x)[0]));
                [self.axis.squares(x), self.axis.half_steps(x)]
            }
            Layout::Star(_) => {
                let x = in_lanes(x);
                let clamped = [self.axis.clamped(V::load(&x[0])), self.axis.clamped(V::load(&x[1]))];
                let mut exponents = [self.axis.half_steps(clamped[0]), self.axis.half_steps(clamped[1])];
                let last = groups(D) - 1;
                exponents[last] = self.with_common(exponents[last], clamped);
                exponents
            }
        }
    }

    /// The second half of a star's [`exponents`](Self::exponents), where only axes of the second four have moved.
    #[inline(always)]
    pub(crate) fn moving_exponents<V: Four>(&self, x: [f64; D]) -> V {
        let x = in_lanes(x);
        let clamped = [self.axis.clamped(V::load(&x[0])), self.axis.clamped(V::load(&x[1]))];
        self.with_common(self.axis.half_steps(clamped[1]), clamped)
    }

    /// Puts −‖x‖²/b² into its lane.
    #[inline(always)]
    fn with_common<V: Four>(&self, exponents: V, clamped: [V; GROUPS]) -> V {
        let squares = (clamped[0] * clamped[0] + clamped[1] * clamped[1]).lanes();
        let mut lanes = exponents.lanes();
        lanes[D % LANES] = ((squares[0] + squares[1]) + (squares[2] + squares[3])) * -self.axis.sharpness;
        V::load(&lanes)
    }

    /// Fills in the activations at `x` from the exponentials of its [`exponents`](Self::exponents).
    #[inline(always)]
    pub(crate) fn fill<V: Four>(&mut self, x: [f64; D], exponentials: &[Lanes; GROUPS]) {
        self.point = x;
        self.output = None;
        self.still = exponentials[0];
        #[cfg(target_arch = "x86_64")]
        if V::IS_WIDE {
            // SAFETY: a wide register is in use.
            return unsafe { self.fill_wide(exponentials) };
        }
        self.fill_here::<Narrow>(exponentials);
    }

    /// As [`fill`](Self::fill) for a star, from the second half of the exponentials; the first half is that of the last time.
    /// What was there before is kept in `before`.
    #[inline(always)]
    pub(crate) fn fill_moving<V: Four>(&mut self, x: [f64; D], moving: Lanes) {
        std::mem::swap(&mut self.inner, &mut self.before);
        let still = self.still;
        self.fill::<V>(x, &[still, moving]);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn fill_wide(&mut self, exponentials: &[Lanes; GROUPS]) {
        self.fill_here::<Wide>(exponentials);
    }

    #[inline(always)]
    fn fill_here<V: Four>(&mut self, exponentials: &[Lanes; GROUPS]) {
        let exponentials = [V::load(&exponentials[0]), V::load(&exponentials[1])];
        // Known sizes let the compiler unroll the rest.
        match self.layout {
            // There are none: see `Layout`.
            Layout::Grid(_) if groups(D) > 1 => {}
            Layout::Grid(1) => self.fill_grid::<V, 1>(exponentials),
            Layout::Grid(2) => self.fill_grid::<V, 2>(exponentials),
            Layout::Grid(3) => self.fill_grid::<V, 3>(exponentials),
            Layout::Grid(4) => self.fill_grid::<V, 4>(exponentials),
            Layout::Grid(5) => self.fill_grid::<V, 5>(exponentials),
            Layout::Grid(6) => self.fill_grid::<V, 6>(exponentials),
            Layout::Grid(7) => self.fill_grid::<V, 7>(exponentials),
            Layout::Grid(8) => self.fill_grid::<V, 8>(exponentials),
            Layout::Grid(_) => self.fill_grid::<V, 9>(exponentials),
            Layout::Star(0) => self.fill_star::<V, 1>(exponentials),
            Layout::Star(1) => self.fill_star::<V, 3>(exponentials),
            Layout::Star(2) => self.fill_star::<V, 5>(exponentials),
            Layout::Star(3) => self.fill_star::<V, 7>(exponentials),
            Layout::Star(_) => self.fill_star::<V, 9>(exponentials),
        }
    }

    /// Tensor product of all axes but the first, the last one running fastest; `N` nodes per axis.
    #[inline(always)]
    fn fill_grid<V: Four, const N: usize>(&mut self, [scale, half_step]: [V; GROUPS]) {
        let ratios = self.axis.ratios::<V, N>(half_step);
        let mut values = [[0.0; LANES]; N];
        for node in 0..N {
            values[node] = (scale * ratios[node]).above(NEGLIGIBLE).lanes();
            self.outer[node] = values[node][0];
        }
        let inner = self.inner.as_flattened_mut();
        inner[0] = 1.0;
        let mut filled = 1;
        for axis in 1..D {
            let mut factors = [0.0; N];
            for node in 0..N {
                factors[node] = values[node][axis % LANES];
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
    fn fill_star<V: Four, const N: usize>(&mut self, exponentials: [V; GROUPS]) {
        let groups = groups(D);
        // One axis alone makes ‖x‖²/b² at most 370. So where it is 460, the other axes leave nothing of any node.
        let common = exponentials[groups - 1].lanes()[D % LANES];
        let common = if common > NOTHING_IS_NEAR { common } else { 0.0 };
        let (origin, nodes) = self.inner.split_at_mut(1);
        origin[0][0] = if common > NEGLIGIBLE { common } else { 0.0 };
        let nodes = &mut nodes[..(N - 1) * groups];
        let middle = N / 2;
        for group in 0..groups {
            // No axis, no node. A field and not constants: to assemble a vector of some `common` and some zeros, the
            // compiler may choose an instruction that valgrind 3.19 does not know, and hosts run under valgrind, too.
            let scale = V::load(&self.presence[group]) * V::splat(common);
            let ratios = self.axis.ratios::<V, N>(exponentials[group]);
            for position in 0..middle {
                nodes[position * groups + group] = (scale * ratios[position]).above(NEGLIGIBLE).lanes();
                let right = (scale * ratios[middle + 1 + position]).above(NEGLIGIBLE);
                nodes[(middle + position) * groups + group] = right.lanes();
            }
        }
    }
}

/// The components of a vector in the lanes of their axes, and zeros.
#[inline(always)]
fn in_lanes<const D: usize>(x: [f64; D]) -> [Lanes; GROUPS] {
    const { assert!(groups(D) <= GROUPS) };
    let mut lanes = [[0.0; LANES]; GROUPS];
    for axis in 0..D {
        let lane = lane(D, axis);
        lanes[lane / LANES][lane % LANES] = x[axis];
    }
    lanes
}
