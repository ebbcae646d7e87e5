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
//! common factor times powers of another: `exp(−(x−c)²/b²) = exp(−x²/b²) exp(2xc/b²) exp(−c²/b²)`. So `exp(−‖x‖²/b²)` is common to
//! all nodes, and an evaluation needs one exponential for it and one per axis, for a step from node to node in both directions, and
//! not one per node. What is common never gets into the activations of single nodes: it is a factor of all of a star's nodes, and
//! of the first axis of a grid. The activations of a grid are the products of those along its first axis with those of its other axes, so
//! these two lists stand for all of them.
//!
//! Far outside the box every activation tends to zero and nothing else happens: where all are below 10⁻³⁰, what is common
//! counts as zero. With widths of 0.25 and more, no factor of an activation is too large or too small for a normal number. With narrower ones,
//! those below 10⁻¹⁰⁰ count as zero.
//!
//! Everything comes in fours: the axes while the basis is evaluated, the nodes while the weights learn. What
//! is left over is filled up with zeros, so that no loop has a remainder and every sum the same order on any processor. The usual grid has
//! 31 fours and one number for its 125 nodes, see `Layout::place`.
//!
//! A step of a law takes a shorter way if its networks are *plain*: of the usual sizes, and not narrow.

// Inlined into functions for wide registers, and indexed in step, or the compiler does not use these registers.
#![allow(clippy::inline_always, clippy::needless_range_loop)]
// What is unsafe asks for a feature of the processor, and nothing of the data.
#![allow(clippy::unsafe_derive_deserialize)]

mod activations;
mod axis;
mod basis;
#[cfg(test)]
mod bits;
mod continuous;
mod lanes;
mod layout;
mod learning;
mod network;
mod plain;
mod stored;
#[cfg(test)]
mod tests;
mod weights;

pub(crate) use continuous::NetworkChange;
pub use layout::{Layout, MAX_PER_AXIS};
pub use network::Network;
pub(crate) use plain::{
    GRID, GRID_ACTIVATIONS, GridActivations, Heights, PlainAxis, STAR, STILL_ACTIVATIONS, grid_output, learn_grid,
    learn_star, star_output, still_activations, still_output,
};

/// Narrowest and widest Gaussians in normalised units. Narrower ones would underflow inside the box.
pub const WIDTHS: std::ops::RangeInclusive<f64> = 0.1..=10.0;
