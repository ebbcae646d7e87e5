//! The law as differential equations: those of [`Pds`](super::Pds).

use super::Pd;
use crate::continuous::{Continuous, Decision, Direction, Regimes};
use crate::signals::{Commands, Inputs};

impl Continuous for Pd {
    #[inline]
    fn continuous_states(&self, out: &mut [f64]) {
        self.law.continuous_states(out);
    }

    #[inline]
    fn take_states(&mut self, states: &[f64]) {
        self.law.take_states(states);
    }

    #[inline]
    fn command_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Commands {
        self.law.command_change(inputs, along)
    }

    #[inline]
    fn derivatives(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        self.law.derivatives(inputs, regimes, out);
    }

    #[inline]
    fn derivative_change(&mut self, inputs: &Inputs, regimes: &Regimes, along: Direction<'_>, out: &mut [f64]) {
        self.law.derivative_change(inputs, regimes, along, out);
    }

    #[inline]
    fn event_indicators(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        self.law.event_indicators(inputs, regimes, out);
    }

    #[inline]
    fn decide(&mut self, inputs: &Inputs, regimes: &mut Regimes) -> Decision {
        self.law.decide(inputs, regimes)
    }
}
