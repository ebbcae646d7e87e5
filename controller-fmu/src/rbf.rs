//! Gaussian radial-basis-function networks, Ŵᵀ Y(X) of (35) and Ûᵀ Y(Z) of (53).
//!
//! Basis function j is `Yⱼ(X) = exp(−‖x − cⱼ‖²/b²)`, where x is the input with every component divided by its scale.
//! The centres fill the box |x| ≤ 1, equally spaced along each axis, in one of two layouts:
//!
//! * [`Layout::Grid`]: the full tensor grid, n nodes per axis. For the three inputs of the posture networks.
//! * [`Layout::Star`]: a node at the origin and r nodes on both sides of it along each axis, 1 + 2rD in all. For the
//!   seven inputs of the object network, where a grid of only five nodes per axis would have 78125.
//!
//! Both have their nodes densest where the networks must work in the end: at the origin, which is the target (zero
//! errors, at rest). There a network acts on its loop as a leaky integrator of the sliding variable s with gain
//! `a‖Y‖²` and forgetting rate aσ, so a lasting disturbance d leaves `s ≈ d σ/‖Y‖²`; the star is there for that reason
//! and not a low-discrepancy set, whose nodes in seven dimensions nearly all lie in the corners.
//!
//! A Gaussian of the whole vector is the product of one-dimensional ones, and along an equally spaced axis those are a
//! common factor times powers of another: `exp(−(x−c)²/b²) = exp(−x²/b²) exp(2xc/b²) exp(−c²/b²)`. So an evaluation needs
//! few exponentials, not one per node:
//!
//! * a grid two per axis; and its activations are the products of those along its first axis with those of its other
//!   axes, so these two lists stand for all of them;
//! * a star one per axis and one more, because `exp(−‖x‖²/b²)` is common to all its nodes.
//!
//! Far outside the box every activation tends to zero and nothing else happens: values below 10⁻³⁰ count as zero (on
//! each axis of a grid, in all of a star), which keeps denormal numbers out of the products.
//!
//! Everything comes in fours, `Lanes`: the axes while the basis is evaluated, the nodes while the weights learn. What
//! is left over is filled up with zeros, so that no loop has a remainder and every sum the same order on any processor.

// Inlined into functions for wide registers, and indexed in step, or the compiler does not use these registers.
#![allow(clippy::inline_always, clippy::needless_range_loop)]
// What is unsafe asks for a feature of the processor, and nothing of the data.
#![allow(clippy::unsafe_derive_deserialize)]

use crate::adaptation::LeakyLaw;
use crate::exponential::{exp, exp_all};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Largest number of nodes along one axis.
pub const MAX_PER_AXIS: usize = 9;

/// Narrowest and widest Gaussians in normalised units. Narrower ones would underflow inside the box.
pub const WIDTHS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// Numbers that are computed with at once: a register where the processor has one of that width.
const LANES: usize = 4;

/// Four numbers side by side.
type Lanes = [f64; LANES];

/// Room for the axes of a network, in fours, with one lane to spare.
const MAX_GROUPS: usize = 2;

/// Activations that are smaller count as zero.
const NEGLIGIBLE: f64 = 1e-30;

/// Where the common factor of a star is smaller, all its activations are negligible.
const NOTHING_IS_NEAR: f64 = 1e-200;

/// Where the centres are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Layout {
    /// Tensor grid with this many nodes per axis, 1 ≤ n ≤ 9; n = 1 is a single node at the origin.
    Grid(usize),
    /// A node at the origin and this many on each side of it along every axis, 0 ≤ r ≤ 4.
    Star(usize),
}

impl Layout {
    /// Nodes along one axis.
    const fn per_axis(self) -> usize {
        match self {
            Self::Grid(n) => n,
            Self::Star(rings) => 2 * rings + 1,
        }
    }

    /// Whether the number of nodes per axis is in its range.
    const fn is_possible(self) -> bool {
        match self {
            Self::Grid(n) => 1 <= n && n <= MAX_PER_AXIS,
            Self::Star(rings) => rings <= MAX_PER_AXIS / 2,
        }
    }

    /// Rows of the weights: as many as the first axis of a grid has nodes.
    const fn rows(self) -> usize {
        match self {
            Self::Grid(n) => n,
            Self::Star(_) => 1,
        }
    }

    /// Lanes of a row, in fours.
    fn row_length(self, dimensions: usize) -> usize {
        match self {
            Self::Grid(_) => (self.nodes(dimensions) / self.rows()).div_ceil(LANES),
            Self::Star(rings) => 1 + 2 * rings * groups(dimensions),
        }
    }

    /// Where the weight of a node is: the row, and the lane in it.
    ///
    /// The row of a star has its origin first, then position by position along the axes those of all axes side by side.
    fn place(self, dimensions: usize, node: usize) -> (usize, usize) {
        match self {
            Self::Grid(_) => {
                let row = self.nodes(dimensions) / self.rows();
                (node / row, node % row)
            }
            Self::Star(rings) => (
                0,
                node.checked_sub(1).map_or(0, |index| {
                    let (axis, position) = (index / (2 * rings), index % (2 * rings));
                    LANES * (1 + position * groups(dimensions)) + axis
                }),
            ),
        }
    }

    /// Number of nodes in `dimensions` dimensions.
    #[must_use]
    pub fn nodes(self, dimensions: usize) -> usize {
        match self {
            Self::Grid(n) => std::iter::repeat_n(n, dimensions).product(),
            Self::Star(rings) => 1 + 2 * rings * dimensions,
        }
    }
}

/// Fours of the axes of a network, with one lane to spare: there is the common factor of a star.
const fn groups(dimensions: usize) -> usize {
    (dimensions + 1).div_ceil(LANES)
}

/// Equally spaced Gaussians on [−1, 1].
#[derive(Debug, Clone, Copy)]
struct Axis {
    nodes: usize,
    /// Distance of neighbouring centres Δ.
    spacing: f64,
    /// 1/b².
    sharpness: f64,
    /// Beyond this |x| every Gaussian is negligible.
    reach: f64,
    /// exp(−c²/b²) of the centres.
    heights: [f64; MAX_PER_AXIS],
}

impl Axis {
    fn new(nodes: usize, width: f64) -> Self {
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

    fn centre(&self, node: usize) -> f64 {
        (node as f64 - 0.5 * (self.nodes - 1) as f64) * self.spacing
    }

    /// The inputs in fours, clamped to the reach, and zeros.
    ///
    /// With b ≥ 0.1 no exponent of one axis, x²/b² or xΔ/b², exceeds 370, so no power of their exponentials overflows.
    #[inline(always)]
    fn clamped<const D: usize>(&self, x: [f64; D]) -> [Lanes; MAX_GROUPS] {
        const { assert!(groups(D) <= MAX_GROUPS) };
        let mut clamped = [[0.0; LANES]; MAX_GROUPS];
        for axis in 0..D {
            clamped[axis / LANES][axis % LANES] = x[axis].clamp(-self.reach, self.reach);
        }
        clamped
    }

    /// `scale` exp(−(x − cⱼ)²/b²)/exp(−x²/b²) of the `N` = `self.nodes` nodes of four axes, from exp(xΔ/b²) of each.
    #[inline(always)]
    fn values<const N: usize>(&self, scale: Lanes, half_step: Lanes) -> [Lanes; N] {
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

/// A network of `D` inputs with its weights.
///
/// The activations of the last [`activate`](Self::activate) are kept, so that the output, its gradient and the update
/// of the weights share one evaluation of the basis. They are no state: serialised networks come back without them.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Network<const D: usize> {
    layout: Layout,
    width: f64,
    axis: Axis,
    /// 1 in the lanes that stand for an axis, 0 in the others.
    presence: [Lanes; MAX_GROUPS],
    /// Row by row, see [`Layout::place`].
    weights: Vec<Lanes>,
    point: [f64; D],
    /// Activations along a grid's first axis, one per row; a star has one row only, and 1.
    outer: [f64; MAX_PER_AXIS],
    /// What all rows share: a grid's products of all axes but the first; all activations of a star.
    inner: Vec<Lanes>,
    /// Ŵᵀ Y at the point, if it is known: four sums that make it up.
    output: Option<Lanes>,
}

/// What is stored of a network.
#[derive(Serialize, Deserialize)]
struct Stored {
    layout: Layout,
    width: f64,
    weights: Vec<f64>,
}

/// A stored network that is none.
#[derive(Debug, Error)]
#[error("stored network has an impossible layout, width or number of weights")]
struct StoredNetworkError;

impl<const D: usize> From<Network<D>> for Stored {
    fn from(network: Network<D>) -> Self {
        Self { layout: network.layout, width: network.width, weights: network.weights().collect() }
    }
}

impl<const D: usize> TryFrom<Stored> for Network<D> {
    type Error = StoredNetworkError;

    fn try_from(Stored { layout, width, weights }: Stored) -> Result<Self, StoredNetworkError> {
        if !layout.is_possible() || !WIDTHS.contains(&width) || weights.len() != layout.nodes(D) {
            return Err(StoredNetworkError);
        }
        let mut network = Self::new(layout, width);
        for (node, weight) in weights.into_iter().enumerate() {
            network.set_weight(node, weight);
        }
        Ok(network)
    }
}

impl<const D: usize> Network<D> {
    /// A network with zero weights and Gaussians of `width` b > 0 in normalised units.
    #[must_use]
    pub fn new(layout: Layout, width: f64) -> Self {
        let row_length = layout.row_length(D);
        let mut presence = [[0.0; LANES]; MAX_GROUPS];
        presence.as_flattened_mut()[..D].fill(1.0);
        Self {
            layout,
            width,
            axis: Axis::new(layout.per_axis(), width),
            presence,
            weights: vec![[0.0; LANES]; layout.rows() * row_length],
            // Unlike any point, so that nothing counts as evaluated.
            point: [f64::NAN; D],
            outer: [1.0; MAX_PER_AXIS],
            inner: vec![[0.0; LANES]; row_length],
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
        self.output = None;
    }

    /// The weights Ŵ, node by node.
    pub fn weights(&self) -> impl Iterator<Item = f64> {
        (0..self.layout.nodes(D)).map(|node| {
            let (row, lane) = self.layout.place(D, node);
            self.weights.as_flattened()[LANES * row * self.inner.len() + lane]
        })
    }

    fn set_weight(&mut self, node: usize, weight: f64) {
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

    /// Evaluates the basis at the normalised input `x`, unless it is evaluated there.
    pub fn activate(&mut self, x: [f64; D]) {
        if self.point == x {
            return;
        }
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
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
    fn activate_here(&mut self, x: [f64; D]) {
        self.output = None;
        // Known sizes let the compiler unroll.
        match self.layout {
            Layout::Grid(1) => self.fill_grid::<1>(x),
            Layout::Grid(2) => self.fill_grid::<2>(x),
            Layout::Grid(3) => self.fill_grid::<3>(x),
            Layout::Grid(4) => self.fill_grid::<4>(x),
            Layout::Grid(5) => self.fill_grid::<5>(x),
            Layout::Grid(6) => self.fill_grid::<6>(x),
            Layout::Grid(7) => self.fill_grid::<7>(x),
            Layout::Grid(8) => self.fill_grid::<8>(x),
            Layout::Grid(_) => self.fill_grid::<9>(x),
            Layout::Star(0) => self.fill_star::<1>(x),
            Layout::Star(1) => self.fill_star::<3>(x),
            Layout::Star(2) => self.fill_star::<5>(x),
            Layout::Star(3) => self.fill_star::<7>(x),
            Layout::Star(_) => self.fill_star::<9>(x),
        }
    }

    /// Tensor product of all axes but the first, the last one running fastest; `N` nodes per axis.
    #[inline(always)]
    fn fill_grid<const N: usize>(&mut self, x: [f64; D]) {
        let axis = &self.axis;
        let groups = groups(D);
        // exp(−x²/b²), then exp(xΔ/b²): all at once.
        let mut exponentials = [[0.0; LANES]; 2 * MAX_GROUPS];
        for (group, x) in axis.clamped(x).iter().enumerate().take(groups) {
            for lane in 0..LANES {
                exponentials[group][lane] = -x[lane] * x[lane] * axis.sharpness;
                exponentials[groups + group][lane] = x[lane] * axis.spacing * axis.sharpness;
            }
        }
        exp_all(exponentials[..2 * groups].as_flattened_mut());
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
        self.point = x;
    }

    /// The origin, then the positions from −1 to 1 without the origin; `N` nodes per axis.
    #[inline(always)]
    fn fill_star<const N: usize>(&mut self, x: [f64; D]) {
        let axis = &self.axis;
        let groups = groups(D);
        let clamped = axis.clamped(x);
        let mut squares = [0.0; LANES];
        for x in clamped {
            for lane in 0..LANES {
                squares[lane] += x[lane] * x[lane];
            }
        }
        // exp(xΔ/b²) of each axis, then exp(−‖x‖²/b²): all at once.
        let mut exponentials = [[0.0; LANES]; MAX_GROUPS];
        for group in 0..groups {
            for lane in 0..LANES {
                exponentials[group][lane] = clamped[group][lane] * axis.spacing * axis.sharpness;
            }
        }
        exponentials[D / LANES][D % LANES] = -total(squares) * axis.sharpness;
        exp_all(exponentials[..groups].as_flattened_mut());
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
        self.point = x;
    }

    /// The weights row by row, each row with the activation that it shares.
    fn rows(&self) -> impl Iterator<Item = (&[Lanes], f64)> {
        self.weights.chunks_exact(self.inner.len()).zip(self.outer)
    }

    /// Ŵᵀ Y at the last activation.
    #[must_use]
    pub fn output(&self) -> f64 {
        total(self.output.unwrap_or_else(|| {
            let mut sums = [0.0; LANES];
            for (row, factor) in self.rows() {
                add_scaled(&mut sums, factor, products(row, &self.inner));
            }
            sums
        }))
    }

    /// ‖Y‖² at the last activation: the gain with which the network learns there.
    #[must_use]
    pub fn learning_gain(&self) -> f64 {
        let outer: f64 = self.outer[..self.layout.rows()].iter().map(|factor| factor * factor).sum();
        outer * total(products(&self.inner, &self.inner))
    }

    /// ‖Ŵ‖.
    #[must_use]
    pub fn norm(&self) -> f64 {
        total(products(&self.weights, &self.weights)).sqrt()
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
            for ((slope, x), c) in gradient.iter_mut().zip(self.point).zip(self.centre(node)) {
                // A point so far out that this overflows activates nothing.
                *slope += if pull == 0.0 { 0.0 } else { pull * (x - c) };
            }
        }
        gradient
    }

    /// All activations, node by node.
    fn activations(&self) -> impl Iterator<Item = f64> {
        (0..self.layout.nodes(D)).map(|node| {
            let (row, lane) = self.layout.place(D, node);
            self.outer[row] * self.inner.as_flattened()[lane]
        })
    }

    /// Ŵ ← decay·Ŵ + weight·Y, with the Y of the last activation.
    pub fn adapt(&mut self, decay: f64, weight: f64) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has it.
            return unsafe { self.adapt_wide(decay, weight) };
        }
        self.adapt_here(decay, weight);
    }

    /// As [`activate_wide`](Self::activate_wide).
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn adapt_wide(&mut self, decay: f64, weight: f64) {
        self.adapt_here(decay, weight);
    }

    #[inline(always)]
    fn adapt_here(&mut self, decay: f64, weight: f64) {
        let mut sums = [0.0; LANES];
        let mut rest = self.weights.as_mut_slice();
        for factor in &self.outer[..self.layout.rows()] {
            let (row, others) = rest.split_at_mut(self.inner.len());
            add_scaled(&mut sums, *factor, adapt_row(row, &self.inner, decay, weight * factor));
            rest = others;
        }
        // What `output` would find, to the bit: the same operations in the same order. It adds the four up, because here
        // the compiler would take the registers apart for that from the beginning.
        self.output = Some(sums);
    }
}

/// w ← decay·w + weight·y; returns [`products`] of the new w with y.
#[inline(always)]
fn adapt_row(w: &mut [Lanes], y: &[Lanes], decay: f64, weight: f64) -> Lanes {
    let mut sums = [0.0; LANES];
    for (w, y) in w.iter_mut().zip(y) {
        // All lanes before the store, or the compiler leaves them one by one; and no closure, which would not be compiled
        // for the wide registers of a caller.
        let mut new = [0.0; LANES];
        for lane in 0..LANES {
            new[lane] = decay * w[lane] + weight * y[lane];
        }
        *w = new;
        for lane in 0..LANES {
            sums[lane] += new[lane] * y[lane];
        }
    }
    sums
}

/// The inner product of two lists, in four sums.
#[inline(always)]
fn products(a: &[Lanes], b: &[Lanes]) -> Lanes {
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums
}

#[inline(always)]
fn add_scaled(sums: &mut Lanes, factor: f64, row: Lanes) {
    for lane in 0..LANES {
        sums[lane] += factor * row[lane];
    }
}

/// What the four sums add up to.
fn total(sums: Lanes) -> f64 {
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition, node by node.
    fn gaussian<const D: usize>(x: [f64; D], centre: [f64; D], width: f64) -> f64 {
        let distance2: f64 = x.iter().zip(centre).map(|(x, c)| (x - c).powi(2)).sum();
        (-distance2 / width.powi(2)).exp()
    }

    fn assert_definition<const D: usize>(layout: Layout, width: f64, x: [f64; D]) {
        let mut network = Network::<D>::new(layout, width);
        network.activate(x);
        for (node, activation) in network.activations().enumerate() {
            let expected = gaussian(x, network.centre(node), width);
            // Exponents of up to 340 cost as many ulp; negligible factors are flushed to zero.
            assert!((activation - expected).abs() < 1e-12 * expected + 1e-29, "{layout:?} {width} {x:?} {node}");
        }
    }

    fn weighted<const D: usize>(layout: Layout, width: f64) -> Network<D> {
        let mut network = Network::<D>::new(layout, width);
        for node in 0..layout.nodes(D) {
            network.set_weight(node, (1.7 * node as f64).sin());
        }
        network
    }

    #[test]
    fn layouts_have_the_documented_sizes_and_centres() {
        assert_eq!(Layout::Grid(5).nodes(3), 125);
        assert_eq!(Layout::Star(2).nodes(7), 29);
        let grid = Network::<3>::new(Layout::Grid(3), 1.0);
        assert_eq!(grid.centre(0), [-1.0, -1.0, -1.0]);
        assert_eq!(grid.centre(13), [0.0; 3]);
        assert_eq!(grid.centre(14), [0.0, 0.0, 1.0]);
        let star = Network::<2>::new(Layout::Star(2), 1.0);
        let centres: Vec<_> = (0..9).map(|node| star.centre(node)).collect();
        assert_eq!(
            centres,
            [
                [0.0, 0.0],
                [-1.0, 0.0],
                [-0.5, 0.0],
                [0.5, 0.0],
                [1.0, 0.0],
                [0.0, -1.0],
                [0.0, -0.5],
                [0.0, 0.5],
                [0.0, 1.0],
            ]
        );
    }

    #[test]
    fn extreme_inputs_activate_nothing_and_give_no_nan() {
        for x in [1e3, -1e9, 1e300, f64::MAX, f64::MIN] {
            let mut grid = weighted::<3>(Layout::Grid(9), 0.1);
            grid.activate([x, 0.0, 0.3]);
            assert_eq!(grid.output(), 0.0);
            assert_eq!(grid.gradient(), [0.0; 3]);
            let mut star = weighted::<7>(Layout::Star(4), 10.0);
            star.activate([x; 7]);
            assert_eq!(star.output(), 0.0);
            assert_eq!(star.gradient(), [0.0; 7]);
        }
    }

    #[test]
    fn activations_survive_serialisation_by_recomputation() {
        let mut network = weighted::<3>(Layout::Grid(4), 0.6);
        network.activate([0.1, -0.2, 0.3]);
        let text = serde_json::to_string(&network).unwrap();
        let mut copy: Network<3> = serde_json::from_str(&text).unwrap();
        copy.activate([0.1, -0.2, 0.3]);
        assert_eq!(copy.output(), network.output());
    }

    /// The output that adaptation leaves behind is the one that a copy without it computes, to the bit; and wide
    /// registers change nothing.
    #[test]
    fn every_way_to_the_output_gives_the_same_bits() {
        fn check<const D: usize>(layout: Layout) {
            let mut network = weighted::<D>(layout, 0.7);
            let mut plain = network.clone();
            for step in 0..20 {
                let x = std::array::from_fn(|axis| (0.3 * f64::from(step) + axis as f64).sin());
                network.activate(x);
                plain.activate_here(x);
                network.adapt(0.99, 0.1);
                plain.adapt_here(0.99, 0.1);
                assert_eq!(network.weights, plain.weights);
                plain.output = None;
                assert_eq!(network.output().to_bits(), plain.output().to_bits(), "{layout:?}");
            }
        }
        for n in 1..=9 {
            check::<3>(Layout::Grid(n));
        }
        for rings in 0..=4 {
            check::<7>(Layout::Star(rings));
        }
    }

    #[test]
    fn impossible_stored_networks_are_refused() {
        let good = Network::<3>::new(Layout::Grid(2), 0.5);
        let text = serde_json::to_string(&good).unwrap();
        assert!(serde_json::from_str::<Network<3>>(&text).is_ok());
        assert!(serde_json::from_str::<Network<7>>(&text).is_err());
        for (part, instead) in [("2", "200"), ("0.5", "0.0"), ("[0.0,", "[")] {
            assert!(text.contains(part));
            assert!(serde_json::from_str::<Network<3>>(&text.replacen(part, instead, 1)).is_err(), "{instead}");
        }
    }

    proptest! {
        #[test]
        fn grid_activations_are_the_gaussians(
            n in 1_usize..=9, width in 0.1..3.0, x in prop::array::uniform3(-2.5..2.5),
        ) {
            assert_definition::<3>(Layout::Grid(n), width, x);
        }

        #[test]
        fn star_activations_are_the_gaussians(
            rings in 0_usize..=4, width in 0.1..3.0, x in prop::array::uniform7(-2.5..2.5),
        ) {
            assert_definition::<7>(Layout::Star(rings), width, x);
        }

        /// Central differences of step 1e-5: truncation ~1e-10 times the third derivative (≤ ~1e3 at these widths).
        #[test]
        fn gradients_agree_with_differences(
            width in 0.4..2.0, x in prop::array::uniform3(-1.5..1.5), rings in 1_usize..=4, n in 2_usize..=5,
        ) {
            fn check<const D: usize>(mut network: Network<D>, x: [f64; D]) {
                network.activate(x);
                let gradient = network.gradient();
                for (axis, slope) in gradient.into_iter().enumerate() {
                    let mut at = |step: f64| {
                        let mut moved = x;
                        moved[axis] += step;
                        network.activate(moved);
                        network.output()
                    };
                    let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                    assert!((slope - difference).abs() < 1e-6, "{slope} {difference}");
                }
            }
            check(weighted::<3>(Layout::Grid(n), width), x);
            check(weighted::<3>(Layout::Star(rings), width), x);
        }
    }
}
