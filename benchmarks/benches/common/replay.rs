//! One model alone, with the inputs that it had in a coupled run: an FMU, or the same in C.

use super::RUN;

/// What can be told all its wired inputs, make a step, and be asked for all its wired outputs.
pub trait Steps {
    fn step(&mut self, inputs: &[f64], outputs: &mut [f64]);
}

/// A model and the inputs of its steps, in the order of time.
pub struct Replay<S> {
    model: S,
    pub inputs: Vec<f64>,
    outputs: Vec<f64>,
    next: usize,
}

impl<S: Steps> Replay<S> {
    /// With the inputs of [`RUN`] steps, and so many outputs.
    pub fn new(model: S, inputs: Vec<f64>, outputs: usize) -> Self {
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
