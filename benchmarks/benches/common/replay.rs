//! One model alone, with the inputs that it had in a coupled run: an FMU, or the same in C.

use super::peer::Peer;
use super::{RUN, Slave};

/// What is told all its inputs, makes a step, and is asked for all its outputs.
pub trait Steps {
    /// How many inputs and outputs are wired.
    fn wired(&self) -> (usize, usize);

    fn step(&mut self, inputs: &[f64], outputs: &mut [f64]);
}

impl Steps for Slave {
    fn wired(&self) -> (usize, usize) {
        (self.inputs.len(), self.outputs.len())
    }

    #[inline]
    fn step(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        Slave::step(self, inputs, outputs);
    }
}

impl Steps for Peer {
    fn wired(&self) -> (usize, usize) {
        (self.inputs.len(), self.outputs.len())
    }

    #[inline]
    fn step(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        Peer::step(self, inputs, outputs);
    }
}

/// A model and the inputs of its steps, in the order of time.
pub struct Replay<S> {
    pub model: S,
    pub inputs: Vec<f64>,
    outputs: Vec<f64>,
    next: usize,
}

impl<S: Steps> Replay<S> {
    /// With the inputs of [`RUN`] steps.
    pub fn new(model: S, inputs: Vec<f64>) -> Self {
        let (wired, outputs) = model.wired();
        assert_eq!(inputs.len(), wired * RUN);
        Self { model, inputs, outputs: vec![0.0; outputs], next: 0 }
    }

    #[inline]
    pub fn step(&mut self) {
        let width = self.inputs.len() / RUN;
        self.model.step(&self.inputs[self.next * width..][..width], &mut self.outputs);
        // Far on it is at rest: go round the part that moves.
        self.next = if self.next + 1 == RUN { 0 } else { self.next + 1 };
    }
}
