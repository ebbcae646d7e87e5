//! The law as differential equations: the integrals.

use super::{Limits, Pds, PdsGains};
use crate::continuous::{Continuous, Decision, Direction, Regimes, indicator, slides, slides_change, state};
use crate::law::{Law, inner};
use crate::signals::{Commands, Inputs};

impl Pds {
    /// Rates of the integrals without anti-windup, for these errors: linear in them.
    #[inline]
    fn wanted(&self, e: [f64; 2], p: f64) -> [f64; 3] {
        let PdsGains { ki, ki_arm, .. } = self.gains;
        [ki_arm[0] * e[0], ki_arm[1] * e[1], ki * p]
    }

    #[inline]
    fn limits(&self) -> [f64; 3] {
        let Limits { torque, force } = self.limits;
        [torque, torque, force]
    }
}

impl Continuous for Pds {
    #[inline]
    fn continuous_states(&self, out: &mut [f64]) {
        out.fill(0.0);
        out[state::INTEGRALS].copy_from_slice(&self.integrals);
    }

    #[inline]
    fn take_states(&mut self, states: &[f64]) {
        self.integrals.copy_from_slice(&states[state::INTEGRALS]);
    }

    #[inline]
    fn command_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Commands {
        let Commands { tau, u } = self.jacobian(inputs).apply(along.inputs);
        let [hub1, hub2, object] = std::array::from_fn(|i| along.states[state::INTEGRALS.start + i]);
        Commands { tau: [tau[0] - hub1, tau[1] - hub2], u: u - object }
    }

    #[inline]
    fn derivatives(&mut self, inputs: &Inputs, _regimes: &Regimes, out: &mut [f64]) {
        let errors = self.arms.errors(inputs);
        let (wanted, limits) = (self.wanted(errors.e, errors.p), self.limits());
        let commands = self.commands(inputs).to_array();
        out.fill(0.0);
        for (i, out) in out[state::INTEGRALS].iter_mut().enumerate() {
            // An integral acts with the opposite sign on its command.
            *out = wanted[i] * slides(commands[i], limits[i], commands[i] * wanted[i] < 0.0);
        }
    }

    #[inline]
    fn derivative_change(&mut self, inputs: &Inputs, _regimes: &Regimes, along: Direction<'_>, out: &mut [f64]) {
        let errors = self.arms.errors(inputs);
        let (rows, values) = (self.arms.error_jacobian(), along.inputs.to_array());
        let wanted = self.wanted(errors.e, errors.p);
        let wanted_change = self.wanted(rows.e.map(|row| inner(&row, &values)), inner(&rows.p, &values));
        let (commands, limits) = (self.commands(inputs).to_array(), self.limits());
        let change = self.command_change(inputs, along).to_array();
        out.fill(0.0);
        for (i, out) in out[state::INTEGRALS].iter_mut().enumerate() {
            let outwards = commands[i] * wanted[i] < 0.0;
            *out = wanted_change[i] * slides(commands[i], limits[i], outwards)
                + wanted[i] * slides_change(commands[i], limits[i], outwards, change[i]);
        }
    }

    #[inline]
    fn event_indicators(&mut self, inputs: &Inputs, _regimes: &Regimes, out: &mut [f64]) {
        out.fill(1.0);
        if self.integrates() {
            let (commands, limits) = (self.commands(inputs).to_array(), self.limits());
            for (i, out) in out[indicator::ANTI_WINDUP].iter_mut().enumerate() {
                *out = limits[i] - commands[i].abs();
            }
        }
    }

    #[inline]
    fn decide(&mut self, _inputs: &Inputs, _regimes: &mut Regimes) -> Decision {
        Decision::default()
    }
}
