//! Learning as differential equations: Ŵ˙ = a (φ Y − σ Ŵ), on its ball where that holds, and how it changes along a direction.

use super::Network;
use super::layout::Layout;
use crate::blocks::adaptation::LeakyLaw;
use crate::blocks::four::LANES;
use crate::continuous::{Decision, Limit};

/// What changes around a network: its weights, its normalised input, and the forcing φ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NetworkChange<'a, const D: usize> {
    pub weights: &'a [f64],
    pub x: [f64; D],
    pub forcing: f64,
}

impl<const D: usize> Network<D> {
    /// Number of nodes, so of weights.
    #[inline]
    pub(crate) fn nodes(&self) -> usize {
        self.layout.nodes(D)
    }

    /// Calls `visit` with each node, the row of its weight and the lane in it.
    #[inline]
    fn places(&self, mut visit: impl FnMut(usize, usize, usize)) {
        for node in 0..self.nodes() {
            let (row, lane) = self.layout.place(D, node);
            visit(node, row, lane);
        }
    }

    /// Calls `visit` with each node, its weight and its activation.
    #[inline]
    fn each(&self, mut visit: impl FnMut(usize, f64, f64)) {
        let (weights, length) = (self.weights.as_flattened(), LANES * self.layout.row_length(D));
        self.places(|node, row, lane| visit(node, weights[row * length + lane], self.activation(row, lane)));
    }

    /// Calls `visit` with each node, its weight, its activation and the change of that for a change of the normalised input:
    /// dY = −2 Y Σ (x − c) dx/b².
    #[inline]
    fn each_change(&self, x: [f64; D], mut visit: impl FnMut(usize, f64, f64, f64)) {
        let (weights, length) = (self.weights.as_flattened(), LANES * self.layout.row_length(D));
        // Most directions that a solver asks for are single weights.
        let moves = x.iter().any(|dx| *dx != 0.0);
        let slope = 2.0 * self.axis.sharpness;
        let common: f64 = self.input().iter().zip(x).map(|(point, dx)| -slope * point * dx).sum();
        self.places(|node, row, lane| {
            let y = self.activation(row, lane);
            // A point so far out that the rest overflows activates nothing.
            let dy = if moves && y != 0.0 { y * (common + slope * self.along_centre(node, &x)) } else { 0.0 };
            visit(node, weights[row * length + lane], y, dy);
        });
    }

    /// Σ c dx.
    #[inline]
    fn along_centre(&self, node: usize, x: &[f64; D]) -> f64 {
        match self.layout {
            Layout::Grid(n) => {
                let (mut index, mut sum) = (node, 0.0);
                for dx in x.iter().rev() {
                    sum += dx * self.axis.centre(index % n);
                    index /= n;
                }
                sum
            }
            Layout::Star(rings) => node.checked_sub(1).map_or(0.0, |index| {
                let (axis, position) = (index / (2 * rings), index % (2 * rings));
                x[axis] * self.axis.centre(position + usize::from(position >= rings))
            }),
        }
    }

    /// Writes the weights node by node.
    #[inline]
    pub(crate) fn put_weights(&self, out: &mut [f64]) {
        self.each(|node, weight, _| out[node] = weight);
    }

    /// Takes weights node by node.
    #[inline]
    pub(crate) fn take_weights(&mut self, new: &[f64]) {
        let length = LANES * self.layout.row_length(D);
        let mut weights = std::mem::take(&mut self.weights);
        self.places(|node, row, lane| weights.as_flattened_mut()[row * length + lane] = new[node]);
        self.weights = weights;
        self.forget_outputs();
    }

    /// Ŵ˙ at the last activation, with the weights `held` on their ball or not.
    #[inline]
    pub(crate) fn put_rates(&self, law: &LeakyLaw, forcing: f64, held: bool, out: &mut [f64]) {
        self.each(|node, weight, y| out[node] = law.rate(weight, forcing * y));
        if held {
            let (mut square, mut along) = (0.0, 0.0);
            self.each(|node, weight, _| (square, along) = (square + weight * weight, along + weight * out[node]));
            self.each(|node, weight, _| out[node] -= along / square * weight);
        }
    }

    /// Exact change of [`put_rates`](Self::put_rates).
    #[inline]
    pub(crate) fn put_rate_changes(
        &self,
        law: &LeakyLaw,
        forcing: f64,
        held: bool,
        by: &NetworkChange<'_, D>,
        out: &mut [f64],
    ) {
        self.each_change(by.x, |node, _, y, dy| {
            out[node] = law.rate(by.weights[node], by.forcing * y + forcing * dy);
        });
        if held {
            let (mut square, mut along) = (0.0, 0.0);
            let (mut square_change, mut along_change) = (0.0, 0.0);
            self.each(|node, weight, y| {
                let (rate, change) = (law.rate(weight, forcing * y), by.weights[node]);
                square += weight * weight;
                along += weight * rate;
                square_change += 2.0 * weight * change;
                along_change += weight * out[node] + change * rate;
            });
            let share = along / square;
            let share_change = (along_change - share * square_change) / square;
            self.each(|node, weight, _| out[node] -= share_change * weight + share * by.weights[node]);
        }
    }

    /// Change of Ŵᵀ Y for a change of the weights and of the normalised input.
    #[inline]
    pub(crate) fn output_change(&self, weights: &[f64], x: [f64; D]) -> f64 {
        let mut sum = 0.0;
        self.each_change(x, |node, weight, y, dy| sum += y * weights[node] + dy * weight);
        sum
    }

    /// Change of ‖Ŵ‖.
    #[inline]
    pub(crate) fn norm_change(&self, weights: &[f64]) -> f64 {
        let (norm, mut sum) = (self.norm(), 0.0);
        self.each(|node, weight, _| sum += weight * weights[node]);
        if norm > 0.0 { sum / norm } else { 0.0 }
    }

    /// The norm of the weights and the radius of their ball.
    #[inline]
    pub(crate) fn limit(&self, law: &LeakyLaw, forcing: f64, radius: f64) -> Limit {
        Limit { most: radius, magnitude: self.norm(), outward: self.norm_rate(law, forcing) }
    }

    /// Whether the ball holds the weights, which are put back if they are beyond.
    #[inline]
    pub(crate) fn decide(
        &mut self,
        law: &LeakyLaw,
        forcing: f64,
        radius: f64,
        held: &mut bool,
        decision: &mut Decision,
    ) {
        let factor = self.limit(law, forcing, radius).decide(held, decision);
        if factor < 1.0 {
            self.scale(factor);
        }
    }
}
