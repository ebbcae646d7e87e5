//! Learning as differential equations: Ŵ˙ = a (φ Y − σ Ŵ), on its ball where that holds, and how it changes along a direction.

use super::Network;
use crate::blocks::adaptation::LeakyLaw;
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
    pub(crate) fn nodes(&self) -> usize {
        self.layout.nodes(D)
    }

    /// Writes the weights node by node.
    pub(crate) fn put_weights(&self, out: &mut [f64]) {
        for (out, weight) in out.iter_mut().zip(self.weights()) {
            *out = weight;
        }
    }

    /// Takes weights node by node.
    pub(crate) fn take_weights(&mut self, weights: &[f64]) {
        for (node, weight) in weights.iter().enumerate() {
            self.set_weight(node, *weight);
        }
        self.output = None;
    }

    /// Ŵ˙ at the last activation, with the weights `held` on their ball or not.
    pub(crate) fn put_rates(&self, law: &LeakyLaw, forcing: f64, held: bool, out: &mut [f64]) {
        for (out, (weight, y)) in out.iter_mut().zip(self.weights().zip(self.activations())) {
            *out = law.rate(weight, forcing * y);
        }
        if held {
            let share = dot(self.weights(), &*out) / self.norm().powi(2);
            for (out, weight) in out.iter_mut().zip(self.weights()) {
                *out -= share * weight;
            }
        }
    }

    /// Exact change of [`put_rates`](Self::put_rates).
    pub(crate) fn put_rate_changes(
        &self,
        law: &LeakyLaw,
        forcing: f64,
        held: bool,
        by: &NetworkChange<'_, D>,
        out: &mut [f64],
    ) {
        let changes = self.activation_changes(by.x).zip(self.activations());
        for (out, ((dy, y), dw)) in out.iter_mut().zip(changes.zip(by.weights)) {
            *out = law.rate(*dw, by.forcing * y + forcing * dy);
        }
        if held {
            let rates = || self.weights().zip(self.activations()).map(|(weight, y)| law.rate(weight, forcing * y));
            let (square, along) = (self.norm().powi(2), self.weights().zip(rates()).map(|(a, b)| a * b).sum::<f64>());
            let square_change = 2.0 * dot(self.weights(), by.weights);
            let along_change = dot(self.weights(), &*out) + dot(rates(), by.weights);
            let share = along / square;
            let share_change = (along_change - share * square_change) / square;
            for (out, (weight, dw)) in out.iter_mut().zip(self.weights().zip(by.weights)) {
                *out -= share_change * weight + share * dw;
            }
        }
    }

    /// Change of Y along a change of the normalised input, node by node.
    fn activation_changes(&self, x: [f64; D]) -> impl Iterator<Item = f64> {
        self.activations().enumerate().map(move |(node, y)| {
            // A point so far out that the rest overflows activates nothing.
            if y == 0.0 {
                return 0.0;
            }
            let centre = self.centre(node);
            let inner: f64 = (0..D).map(|axis| (self.point[axis] - centre[axis]) * x[axis]).sum();
            -2.0 * self.axis.sharpness * y * inner
        })
    }

    /// Change of Ŵᵀ Y by that of the weights alone.
    pub(crate) fn output_change(&self, weights: &[f64]) -> f64 {
        dot(self.activations(), weights)
    }

    /// Change of ‖Ŵ‖.
    pub(crate) fn norm_change(&self, weights: &[f64]) -> f64 {
        let norm = self.norm();
        if norm > 0.0 { dot(self.weights(), weights) / norm } else { 0.0 }
    }

    /// The norm of the weights and the radius of their ball.
    pub(crate) fn limit(&self, law: &LeakyLaw, forcing: f64, radius: f64) -> Limit {
        Limit { most: radius, magnitude: self.norm(), outward: self.norm_rate(law, forcing) }
    }

    /// Whether the ball holds the weights, which are put back if they are beyond.
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

fn dot<'a>(a: impl Iterator<Item = f64>, b: impl IntoIterator<Item = &'a f64>) -> f64 {
    a.zip(b).map(|(a, b)| a * b).sum()
}
