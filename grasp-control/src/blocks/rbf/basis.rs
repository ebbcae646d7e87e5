//! The basis: all Gaussians of a network at one point.
//!
//! First come the exponents of a four of axes: if there are two fours, the [first](Network::first_exponents) are those that stay where
//! only shear rates change; the [last](Network::last_exponents) come with what is common to all nodes. Then the activations are filled
//! in from the powers. A law that knows its networks to be [plain](Network::is_plain) takes the powers of all in one pass.

use super::Network;
use super::layout::{GROUPS, Layout, MAX_PER_AXIS, USUAL, USUAL_ARM, USUAL_ROW, USUAL_STAR, groups, lane};
use crate::blocks::exponential::powers;
use crate::blocks::four::{Four, LANES, Lanes, Narrow};

impl<const D: usize> Network<D> {
    /// The last four of the axes.
    const LAST: usize = groups(D) - 1;

    /// Evaluates the basis at the normalised input `x`, unless it is evaluated there.
    pub fn activate(&mut self, x: [f64; D]) {
        self.activate_lanes(&in_lanes(x));
    }

    /// As [`activate`](Self::activate), for the input in the lanes of its axes and zeros.
    pub(crate) fn activate_lanes(&mut self, x: &[Lanes; GROUPS]) {
        if self.at.as_ref().is_some_and(|at| at.point == *x) {
            return;
        }
        // In narrow registers on all processors, for the code is there once: what is fast is for plain networks.
        self.activate_here::<Narrow>(x);
    }

    #[inline(always)]
    pub(super) fn activate_here<V: Four>(&mut self, x: &[Lanes; GROUPS]) {
        if Self::LAST > 0 {
            let exponents = self.first_exponents(V::load(&x[0]));
            let [of_first] = powers([exponents]);
            self.fill_first(of_first);
        }
        let last = V::load(&x[Self::LAST]);
        let [of_last] = powers([self.last_exponents(last)]);
        self.fill_last(last, of_last);
    }

    /// Goes on from where it is evaluated to a point that differs along the last axes; the last lane of `last` does not count.
    pub(crate) fn go_on(&mut self, last: Lanes) {
        let mut x = self.place().point;
        x[Self::LAST] = Narrow::load(&last).with_last(0.0).lanes();
        self.activate_lanes(&x);
    }

    /// The exponents of two for the first four axes of two at `x`, which is kept.
    #[inline(always)]
    pub(crate) fn first_exponents<V: Four>(&mut self, x: V) -> V {
        let (steps, squares) = self.axis.steps(x);
        let at = self.place();
        at.point[0] = x.lanes();
        at.first_norm2 = sum(squares.lanes());
        steps
    }

    /// The exponents of two for the last four axes at `x`, whose last lane does not count. In that lane is the exponent for
    /// exp(−‖x‖²/b²).
    #[inline(always)]
    pub(crate) fn last_exponents<V: Four>(&self, x: V) -> V {
        let (steps, squares) = self.axis.steps(x);
        let [a, b, c, _] = squares.lanes();
        let norm2 = self.at.as_ref().map_or(0.0, |at| at.first_norm2) + ((a + b) + c);
        self.axis.with_common(steps, norm2)
    }

    /// Fills in a star's activations along the first four axes of two, without what is common to all.
    fn fill_first<V: Four>(&mut self, powers: [V; 2]) {
        self.place().kept = None;
        if let Layout::Star(rings) = self.layout {
            self.fill_arm(rings, 0, powers, 1.0);
        }
    }

    /// Fills in the activations along the last four axes at `x`, and what is common to all.
    #[inline(always)]
    fn fill_last<V: Four>(&mut self, x: V, powers: [V; 2]) {
        self.arrive(x);
        let common = self.axis.relevant(powers[0].last());
        match self.layout {
            // There are none: see `Layout`.
            Layout::Grid(_) if groups(D) > 1 => {}
            Layout::Grid(USUAL) if D == 3 => {
                let [a, b, _, c, d, ..] = self.axis.ratios(USUAL, 0, powers, common);
                let factors = V::columns([a, b, c, d]);
                self.fill_usual([self.axis.outer(factors[0], common), factors[1], factors[2]], common);
            }
            Layout::Grid(n) => self.fill_grid(n, powers.map(V::lanes), common),
            Layout::Star(rings) => {
                self.place().outer[0][0] = common;
                self.fill_arm(rings, Self::LAST, powers, common);
            }
        }
    }

    /// The network is evaluated at `x` along the last axes.
    #[inline(always)]
    fn arrive<V: Four>(&mut self, x: V) {
        let at = self.place();
        at.point[Self::LAST] = x.with_last(0.0).lanes();
        at.output = None;
    }

    /// A star: the nodes along four axes, from −1 to 1, without the origin.
    #[inline(always)]
    fn fill_arm<V: Four>(&mut self, rings: usize, group: usize, powers: [V; 2], common: f64) {
        let rings = rings.min(MAX_PER_AXIS / 2);
        let ratios = self.axis.ratios(2 * rings + 1, group, powers, common);
        let nodes = &mut self.place().inner[1 + 2 * rings * group..][..2 * rings];
        for position in 0..rings {
            nodes[position] = ratios[position].lanes();
            nodes[rings + position] = ratios[rings + 1 + position].lanes();
        }
    }

    /// The usual grid, from the factors of each axis but those in its middle: products in the order of [`Layout::place`].
    #[inline(always)]
    fn fill_usual<V: Four>(&mut self, [outer, second, third]: [V; 3], common: f64) {
        let at = self.place();
        at.outer[0] = outer.lanes();
        at.outer[1][0] = common;
        let Some([products @ .., beside, last]) = at.inner.first_chunk_mut::<USUAL_ROW>() else { return };
        let factors = second.lanes();
        for (products, factor) in products.iter_mut().zip(factors) {
            *products = (V::splat(factor) * third).lanes();
        }
        (*beside, *last) = (third.whole().lanes(), second.whole().lanes());
    }

    /// A usual grid whose Gaussians are not narrow, from the powers of its [`last_exponents`](Self::last_exponents) at `x`.
    #[inline(always)]
    pub(crate) fn fill_plain_grid<V: Four>(&mut self, x: V, powers: [V; 2]) {
        self.arrive(x);
        let common = self.axis.relevant(powers[0].last());
        let [a, b, _, c, d, ..] = self.axis.plain_ratios(USUAL, 0, powers);
        let [first, second, third, _] = V::columns([a, b, c, d]);
        self.fill_usual([first * V::splat(common), second, third], common);
    }

    /// A usual star whose Gaussians are not narrow: its nodes along four axes.
    #[inline(always)]
    fn plain_arm<V: Four>(&self, group: usize, powers: [V; 2]) -> [Lanes; USUAL_ARM] {
        let [a, b, _, c, d, ..] = self.axis.plain_ratios(USUAL_ARM + 1, group, powers);
        [a.lanes(), b.lanes(), c.lanes(), d.lanes()]
    }

    /// Such a star along its first axes, from the powers of its [`first_exponents`](Self::first_exponents).
    #[inline(always)]
    pub(crate) fn fill_plain_first<V: Four>(&mut self, powers: [V; 2]) {
        let arm = self.plain_arm(0, powers);
        let at = self.place();
        at.kept = None;
        if let Some([_, still @ .., _, _, _, _]) = at.inner.first_chunk_mut::<USUAL_STAR>() {
            *still = arm;
        }
    }

    /// Such a star along its last axes at `x`, from the powers of its [`last_exponents`](Self::last_exponents).
    #[inline(always)]
    pub(crate) fn fill_plain_last<V: Four>(&mut self, x: V, powers: [V; 2]) {
        self.arrive(x);
        let common = self.axis.relevant(powers[0].last());
        let arm = self.plain_arm(1, powers);
        let at = self.place();
        at.outer[0][0] = common;
        if let Some([_, _, _, _, _, moving @ ..]) = at.inner.first_chunk_mut::<USUAL_STAR>() {
            *moving = arm;
        }
    }

    /// The same at two points that differ along the last axes; `x` is the second.
    #[inline(always)]
    pub(crate) fn fill_plain_both<V: Four>(&mut self, x: V, [first, second]: [[V; 2]; 2]) {
        let common = self.axis.relevant(first[0].last());
        let arm = self.plain_arm(1, first);
        let at = self.place();
        (at.before_common, at.before) = (common, arm);
        self.fill_plain_last(x, second);
    }

    /// Any other grid: tensor product of all axes but the first, the last one running fastest; `n` nodes per axis. Not inlined, and one
    /// number by one: there are few.
    #[inline(never)]
    fn fill_grid(&mut self, n: usize, powers: [Lanes; 2], common: f64) {
        let n = n.clamp(1, MAX_PER_AXIS);
        let powers = powers.map(|lanes| Narrow::load(&lanes));
        let ratios = self.axis.ratios(n, 0, powers, common).map(Narrow::lanes);
        let [second, third] = [1, 2].map(|axis| ratios.map(|of_axes| of_axes[axis]));
        let axis = self.axis;
        let at = self.place();
        for (node, outer) in at.outer.as_flattened_mut()[..n].iter_mut().enumerate() {
            let ratio = Narrow::load(&[ratios[node][0]; LANES]);
            *outer = axis.outer(ratio, common).last();
        }
        let (second, third) = match D {
            1 => (&[1.0][..], &[1.0][..]),
            2 => (&[1.0][..], &second[..n]),
            _ => (&second[..n], &third[..n]),
        };
        for (row, second) in at.inner.as_flattened_mut().chunks_mut(third.len()).zip(second) {
            for (place, third) in row.iter_mut().zip(third) {
                *place = second * third;
            }
        }
    }
}

/// What four lanes add up to.
#[inline(always)]
fn sum(lanes: Lanes) -> f64 {
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// The components of a vector in the lanes of their axes, and zeros.
#[inline(always)]
pub(super) fn in_lanes<const D: usize>(x: [f64; D]) -> [Lanes; GROUPS] {
    const { assert!(groups(D) <= GROUPS) };
    let mut lanes = [[0.0; LANES]; GROUPS];
    for axis in 0..D {
        let lane = lane(D, axis);
        lanes[lane / LANES][lane % LANES] = x[axis];
    }
    lanes
}
