//! Observers and law as differential equations.

use super::{Encoders, motions};
use crate::blocks::observer::{Observer, ObserverChange, RateSource};
use crate::continuous::{Continuous, Decision, Direction, Regimes, indicator, state};
use crate::signals::{Commands, Inputs};

impl<L: Continuous> Encoders<L> {
    /// The change of what the law sees along a direction of states and inputs.
    #[must_use]
    #[inline]
    pub fn seen_change(&self, along: Direction<'_>) -> Inputs {
        match self.source {
            RateSource::Measured => *along.inputs,
            RateSource::Estimated => {
                self.with_rates(along.inputs, observers(along.states).map(|observer| observer.rate))
            }
        }
    }

    /// The known forces with the commands of the moment.
    #[inline]
    fn present_forces(&mut self, inputs: &Inputs) -> [f64; 3] {
        let commands = self.present_commands(inputs);
        self.actuation.forces(&commands, inputs)
    }
}

/// The observers of a vector of states, or of a direction.
#[inline]
pub(crate) fn observers(states: &[f64]) -> [Observer; 3] {
    std::array::from_fn(|i| Observer::from_array(std::array::from_fn(|j| states[state::OBSERVERS.start + 3 * i + j])))
}

/// Puts observers into a vector of states.
#[inline]
pub(crate) fn put_observers(observers: &[Observer; 3], out: &mut [f64]) {
    for (observer, out) in observers.iter().zip(out[state::OBSERVERS].chunks_exact_mut(3)) {
        out.copy_from_slice(&observer.to_array());
    }
}

impl<L: Continuous> Continuous for Encoders<L> {
    #[inline]
    fn continuous_states(&self, out: &mut [f64]) {
        self.law.continuous_states(out);
        if self.source == RateSource::Estimated {
            put_observers(&self.observers, out);
        }
    }

    #[inline]
    fn take_states(&mut self, states: &[f64]) {
        self.law.take_states(states);
        if self.source == RateSource::Estimated {
            self.observers = observers(states);
        }
    }

    #[inline]
    fn present_commands(&mut self, inputs: &Inputs) -> Commands {
        let seen = self.seen(inputs);
        self.law.present_commands(&seen)
    }

    #[inline]
    fn command_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Commands {
        let (seen, change) = (self.seen(inputs), self.seen_change(along));
        self.law.command_change(&seen, Direction { inputs: &change, ..along })
    }

    #[inline]
    fn derivatives(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        let seen = self.seen(inputs);
        self.law.derivatives(&seen, regimes, out);
        if self.source == RateSource::Estimated {
            let (forces, motions) = (self.present_forces(inputs), motions(inputs));
            let rates = std::array::from_fn(|i| {
                self.observers[i].present_derivative(&self.known(i), motions[i], forces[i], regimes.disturbance[i])
            });
            put_observers(&rates, out);
        }
    }

    #[inline]
    fn derivative_change(&mut self, inputs: &Inputs, regimes: &Regimes, along: Direction<'_>, out: &mut [f64]) {
        let (seen, seen_change) = (self.seen(inputs), self.seen_change(along));
        self.law.derivative_change(&seen, regimes, Direction { inputs: &seen_change, ..along }, out);
        if self.source == RateSource::Estimated {
            let commands = self.present_commands(inputs);
            let command_change = self.command_change(inputs, along);
            let forces = self.actuation.forces(&commands, inputs);
            let force_changes = self.actuation.force_changes(&commands, &command_change, along.inputs);
            let (motions, motion_changes) = (motions(inputs), motions(along.inputs));
            let changes = observers(along.states);
            let rates = std::array::from_fn(|i| {
                let by = ObserverChange {
                    observer: changes[i],
                    measured: motion_changes[i],
                    force: force_changes[i],
                    inertia: 0.0,
                };
                let held = regimes.disturbance[i];
                self.observers[i].derivative_change(&self.known(i), motions[i], forces[i], held, &by)
            });
            put_observers(&rates, out);
        }
    }

    #[inline]
    fn event_indicators(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        let seen = self.seen(inputs);
        self.law.event_indicators(&seen, regimes, out);
        if self.source == RateSource::Estimated {
            let commands = self.present_commands(inputs);
            let forces = self.actuation.forces(&commands, inputs);
            let motions = motions(inputs);
            out[indicator::LIMITS].copy_from_slice(&self.actuation.distances(&commands));
            for (i, out) in out[indicator::DISTURBANCES].iter_mut().enumerate() {
                let limit = self.observers[i].limit(&self.known(i), motions[i], forces[i]);
                *out = limit.indicator(regimes.disturbance[i]);
            }
        }
    }

    #[inline]
    fn decide(&mut self, inputs: &Inputs, regimes: &mut Regimes) -> Decision {
        let seen = self.seen(inputs);
        let mut decision = self.law.decide(&seen, regimes);
        if self.source == RateSource::Estimated {
            let (forces, motions) = (self.present_forces(inputs), motions(inputs));
            for i in 0..3 {
                let known = self.known(i);
                let held = &mut regimes.disturbance[i];
                let observer = &mut self.observers[i];
                observer.disturbance *= observer.decide(&known, motions[i], forces[i], held, &mut decision);
            }
        }
        decision
    }
}

impl super::Actuation {
    /// Change of [`forces`](Self::forces) for a change of commands and inputs.
    #[inline]
    pub(crate) fn force_changes(&self, commands: &Commands, command_change: &Commands, inputs: &Inputs) -> [f64; 3] {
        let loads = Self { torque_limit: 0.0, force_limit: 0.0, ..*self }.forces(&Commands::default(), inputs);
        let (distances, changes) = (self.distances(commands), command_change.to_array());
        std::array::from_fn(|i| loads[i] + if distances[i] >= 0.0 { changes[i] } else { 0.0 })
    }

    /// How far commands are inside their limits.
    #[inline]
    pub(crate) fn distances(&self, commands: &Commands) -> [f64; 3] {
        let limit = self.torque_limit;
        [limit - commands.tau[0].abs(), limit - commands.tau[1].abs(), self.force_limit - commands.u.abs()]
    }
}
