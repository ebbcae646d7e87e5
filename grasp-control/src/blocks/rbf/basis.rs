//! The basis: all Gaussians of a network at one point.
//!
//! First come the [exponents](Network::exponents), so that a law can take the exponentials of all its networks in one pass; then
//! the activations are [filled in](Network::fill) from the exponentials.

use super::Network;
use super::axis::NEGLIGIBLE;
use super::layout::{GROUPS, Layout, MAX_PER_AXIS, USUAL, USUAL_ROW, groups, lane};
use crate::blocks::exponential::exp_of_all;
use crate::blocks::four::{Four, LANES, Lanes, Narrow};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};

/// Where the common factor of a star is smaller, all its activations are negligible.
const NOTHING_IS_NEAR: f64 = 1e-200;

/// Room for the nodes along an axis, in fours.
const FACTORS: usize = MAX_PER_AXIS.next_multiple_of(LANES);

/// The product of no axes.
const ONE: [f64; FACTORS] = {
    let mut factors = [0.0; FACTORS];
    factors[0] = 1.0;
    factors
};

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
        let exponents = self.exponents::<V>(x);
        self.fill::<V>(x, &exp_of_all(exponents));
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
        self.fill_narrow(exponentials);
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

    #[inline(never)]
    fn fill_narrow(&mut self, exponentials: &[Lanes; GROUPS]) {
        self.fill_here::<Narrow>(exponentials);
    }

    #[inline(always)]
    pub(super) fn fill_here<V: Four>(&mut self, exponentials: &[Lanes; GROUPS]) {
        let exponentials = [V::load(&exponentials[0]), V::load(&exponentials[1])];
        match self.layout {
            // There are none: see `Layout`.
            Layout::Grid(_) if groups(D) > 1 => {}
            // The usual sizes: if it knows them, the compiler unrolls the rest.
            Layout::Grid(USUAL) => self.fill_grid(USUAL, exponentials),
            Layout::Star(2) => self.fill_star(2, exponentials),
            Layout::Grid(n) => self.fill_grid(n, exponentials),
            Layout::Star(rings) => self.fill_star(rings, exponentials),
        }
    }

    /// Tensor product of all axes but the first, the last one running fastest; `n` nodes per axis.
    #[inline(always)]
    fn fill_grid<V: Four>(&mut self, n: usize, [scale, half_step]: [V; GROUPS]) {
        let n = n.clamp(1, MAX_PER_AXIS);
        let ratios = self.axis.ratios(n, half_step);
        // Of each axis; filled up with zeros.
        let mut values = [[0.0; FACTORS]; LANES];
        for node in 0..n {
            let of_axes = (scale * ratios[node]).above(NEGLIGIBLE).lanes();
            for axis in 0..D.min(LANES) {
                values[axis][node] = of_axes[axis];
            }
        }
        self.outer.copy_from_slice(&values[0][..MAX_PER_AXIS]);
        if D < 3 {
            let inner = self.inner.as_flattened_mut();
            let factors = if D == 2 { values[1] } else { ONE };
            inner.copy_from_slice(&factors[..inner.len()]);
            return;
        }
        if n == USUAL
            && let Some(inner) = self.inner.first_chunk_mut::<USUAL_ROW>()
        {
            // Four by four, as they will be read: what is read back while parts of it are on their way to memory has to wait.
            for group in 0..USUAL_ROW {
                let (mut slow, mut fast) = ([0.0; LANES], [0.0; LANES]);
                for lane in 0..LANES {
                    let node = group * LANES + lane;
                    if node < USUAL * USUAL {
                        (slow[lane], fast[lane]) = (values[1][node / USUAL], values[2][node % USUAL]);
                    }
                }
                inner[group] = (V::load(&slow) * V::load(&fast)).lanes();
            }
            return;
        }
        let inner = self.inner.as_flattened_mut();
        let (slow, fast) = (values[1], values[2].as_chunks::<LANES>().0);
        let row = n.div_ceil(LANES);
        let needed = (n - 1) * n + row * LANES;
        if needed > inner.len() {
            // Two or six nodes per axis.
            for (row, slow) in inner.chunks_exact_mut(n).zip(slow) {
                for (place, fast) in row.iter_mut().zip(values[2]) {
                    *place = slow * fast;
                }
            }
            return;
        }
        let inner = &mut inner[..needed];
        for node in 0..n {
            // What is beyond a row is zero, until the next row takes its place.
            for group in 0..row {
                if let Some(place) = inner[node * n + group * LANES..].first_chunk_mut() {
                    *place = (V::splat(slow[node]) * V::load(&fast[group])).lanes();
                }
            }
        }
    }

    /// The origin, then the positions from −1 to 1 without the origin.
    #[inline(always)]
    fn fill_star<V: Four>(&mut self, rings: usize, exponentials: [V; GROUPS]) {
        let groups = groups(D);
        let rings = rings.min(MAX_PER_AXIS / 2);
        // One axis alone makes ‖x‖²/b² at most 370. So where it is 460, the other axes leave nothing of any node.
        let common = exponentials[groups - 1].lanes()[D % LANES];
        let common = if common > NOTHING_IS_NEAR { common } else { 0.0 };
        let (origin, nodes) = self.inner.split_at_mut(1);
        origin[0] = V::load(&[common, 0.0, 0.0, 0.0]).above(NEGLIGIBLE).lanes();
        let nodes = &mut nodes[..2 * rings * groups];
        for group in 0..groups {
            // No axis, no node. A field and not constants: to assemble a vector of some `common` and some zeros, the
            // compiler may choose an instruction that valgrind 3.19 does not know, and hosts run under valgrind, too.
            let scale = V::load(&self.presence[group]) * V::splat(common);
            let ratios = self.axis.ratios(2 * rings + 1, exponentials[group]);
            for position in 0..rings {
                nodes[position * groups + group] = (scale * ratios[position]).above(NEGLIGIBLE).lanes();
                let right = (scale * ratios[rings + 1 + position]).above(NEGLIGIBLE);
                nodes[(rings + position) * groups + group] = right.lanes();
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
