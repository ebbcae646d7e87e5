//! The law as differential equations: observers, filters, the mass estimate, networks.

use super::loops::{Outcome, Point};
use super::mass::MassEstimator;
use super::networks::{NetworkDirection, Sight, SightChange};
use super::{RootStrain, motions};
use crate::blocks::observer::{Observer, ObserverChange, RateSource};
use crate::continuous::{Continuous, Decision, Direction, Regimes, indicator, state};
use crate::laws::encoders::{observers, put_observers};
use crate::laws::nabfc::{Estimates, Surfaces};
use crate::signals::{Commands, Inputs};

/// Everything at one instant.
struct Present {
    at: Point,
    outcome: Outcome,
    shear_rate: [f64; 2],
    sight: [Sight; 3],
}

/// How everything changes along a direction.
struct Change {
    by: Point,
    outcome: Outcome,
    shear_rate: [f64; 2],
    sight: [SightChange; 3],
}

impl Present {
    fn commands(&self) -> Commands {
        self.outcome.into()
    }
}

impl RootStrain {
    /// Whether the low-passes are in use.
    fn filters(&self) -> bool {
        self.source == RateSource::Measured && self.root_moment_rate.is_on()
    }

    fn present(&mut self, inputs: &Inputs) -> Present {
        let mut at = self.point(inputs);
        let (_, shear_rate) = self.strain_rates(inputs);
        let (known, measured) = (self.known(), motions(inputs));
        let mut sight: [Sight; 3] =
            std::array::from_fn(|i| Sight { known: known[i], observer: self.observers[i], measured: measured[i] });
        let mut outcome = self.loops().at(&at);
        if self.networks.is_some() {
            // Surfaces, which the networks see, do not depend on what they learn.
            let seen = self.seen(&at, &outcome, inputs.measured.tip_shear, shear_rate);
            if let Some(networks) = &mut self.networks {
                at.unknown = networks.outputs(&seen, &sight);
            }
            for (sight, unknown) in sight.iter_mut().zip(at.unknown) {
                sight.observer.disturbance = unknown;
            }
            outcome = self.loops().at(&at);
        }
        Present { at, outcome, shear_rate, sight }
    }

    fn change(&mut self, inputs: &Inputs, now: &Present, along: Direction<'_>) -> Change {
        let states = along.states;
        let mut by = self.direction(along.inputs);
        let mut moving = observers(states);
        by.omega = [moving[0].rate, moving[1].rate];
        by.v = moving[2].rate;
        by.unknown = moving.map(|observer| observer.disturbance);
        let mass = MassEstimator::from_array(std::array::from_fn(|i| states[state::MASS.start + i]));
        by.mass = self.mass.mass_change(&self.gains.mass, &mass);
        let pair = |first: usize| [states[first], states[first + 1]];
        let (moment_rate, shear_rate) = match self.source {
            RateSource::Estimated => self.quasi_static(by.omega, by.v),
            RateSource::Measured if self.filters() => (pair(state::MOMENT_RATES.start), pair(state::SHEAR_RATES.start)),
            RateSource::Measured => (along.inputs.measured.root_moment_dot, along.inputs.measured.tip_shear_dot),
        };
        (by.moment_rate, by.shear_rate) = (moment_rate, shear_rate[0] + shear_rate[1]);
        let measured = motions(along.inputs);
        let mut outcome = self.loops().change(&now.at, &by);
        let mut sight: [SightChange; 3] = std::array::from_fn(|i| SightChange {
            inertia: if i == 2 { by.mass } else { 0.0 },
            observer: moving[i],
            measured: measured[i],
        });
        if self.networks.is_some() {
            let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
            let seen_by = self.seen(&by, &outcome, along.inputs.measured.tip_shear, shear_rate);
            if let Some(networks) = &mut self.networks {
                let direction = network_direction(networks.nodes(), states);
                let unknown = networks.output_changes((&seen, &now.sight), (&seen_by, &sight), &direction);
                for ((observer, sight), unknown) in moving.iter_mut().zip(&mut sight).zip(unknown) {
                    observer.disturbance = unknown;
                    sight.observer.disturbance = unknown;
                }
                by.unknown = unknown;
            }
            outcome = self.loops().change(&now.at, &by);
        }
        Change { by, outcome, shear_rate, sight }
    }

    /// Change of the surfaces along a direction.
    pub fn surface_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Surfaces {
        let now = self.present(inputs);
        self.change(inputs, &now, along).outcome.into()
    }

    /// Change of the estimates along a direction of the states.
    #[must_use]
    pub fn estimate_change(&self, states: &[f64]) -> Estimates {
        let mass = MassEstimator::from_array(std::array::from_fn(|i| states[state::MASS.start + i]));
        let ([u1, u2, w], [pi1, pi2, epsilon]) = if let Some(networks) = &self.networks {
            let direction = network_direction(networks.nodes(), states);
            (networks.norm_changes(direction.weights), direction.bounds)
        } else {
            let changes = observers(states);
            let change = |i: usize| changes[i].disturbance * self.observers[i].disturbance.signum();
            ([change(0), change(1), change(2)], [0.0; 3])
        };
        Estimates {
            m_hat: self.mass.mass_change(&self.gains.mass, &mass),
            j_hat: [0.0; 2],
            epsilon_hat: epsilon,
            pi_hat: [pi1, pi2],
            w_norm: w,
            u_norm: [u1, u2],
        }
    }

    /// The learners' limits that hold: balls, robust terms.
    fn held(regimes: &Regimes) -> [[bool; 2]; 3] {
        std::array::from_fn(|i| [regimes.weights[i], regimes.bound[i]])
    }
}

/// Û₁, Û₂, Ŵ and the robust terms of a vector of states.
fn network_direction(nodes: [usize; 3], states: &[f64]) -> NetworkDirection<'_> {
    let (u1, rest) = states[state::WEIGHTS..].split_at(nodes[0]);
    let (u2, rest) = rest.split_at(nodes[1]);
    NetworkDirection {
        weights: [u1, u2, &rest[..nodes[2]]],
        bounds: std::array::from_fn(|i| states[state::BOUNDS.start + i]),
    }
}

/// The weights in a vector of states, to be written.
fn weights_of(nodes: [usize; 3], weights: &mut [f64]) -> [&mut [f64]; 3] {
    let (u1, rest) = weights.split_at_mut(nodes[0]);
    let (u2, rest) = rest.split_at_mut(nodes[1]);
    [u1, u2, &mut rest[..nodes[2]]]
}

impl Continuous for RootStrain {
    fn continuous_states(&self, out: &mut [f64]) {
        out.fill(0.0);
        // A position means something where the rate is estimated, a disturbance where no networks stand for it.
        let kept = self.observers.map(|observer| Observer {
            position: if self.source == RateSource::Estimated { observer.position } else { 0.0 },
            disturbance: if self.networks.is_some() { 0.0 } else { observer.disturbance },
            ..observer
        });
        put_observers(&kept, out);
        if self.filters() {
            out[state::SHEAR_RATES].copy_from_slice(&self.tip_shear_rate.output([0.0; 2]));
            out[state::MOMENT_RATES].copy_from_slice(&self.root_moment_rate.output([0.0; 2]));
        }
        out[state::MASS].copy_from_slice(&self.mass.to_array());
        if let Some(networks) = &self.networks {
            let (first, weights) = out.split_at_mut(state::WEIGHTS);
            let bounds = networks.put(weights_of(networks.nodes(), weights));
            first[state::BOUNDS].copy_from_slice(&bounds);
        }
    }

    fn take_states(&mut self, states: &[f64]) {
        self.observers = observers(states);
        if self.filters() {
            self.tip_shear_rate.settle(std::array::from_fn(|i| states[state::SHEAR_RATES.start + i]));
            self.root_moment_rate.settle(std::array::from_fn(|i| states[state::MOMENT_RATES.start + i]));
        }
        self.mass = MassEstimator::from_array(std::array::from_fn(|i| states[state::MASS.start + i]));
        if let Some(networks) = &mut self.networks {
            networks.take(&network_direction(networks.nodes(), states));
        }
    }

    fn present_commands(&mut self, inputs: &Inputs) -> Commands {
        self.present(inputs).commands()
    }

    fn command_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Commands {
        let now = self.present(inputs);
        self.change(inputs, &now, along).outcome.into()
    }

    fn derivatives(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        let now = self.present(inputs);
        let forces = self.actuation.forces(&now.commands(), inputs);
        out.fill(0.0);
        let rates = std::array::from_fn(|i| {
            let Sight { known, observer, measured } = &now.sight[i];
            let held = regimes.disturbance[i] || self.networks.is_some();
            observer.present_derivative(known, *measured, forces[i], held)
        });
        put_observers(&rates, out);
        if self.filters() {
            let measured = &inputs.measured;
            out[state::SHEAR_RATES].copy_from_slice(&self.tip_shear_rate.output_rate(measured.tip_shear_dot, [0.0; 2]));
            out[state::MOMENT_RATES]
                .copy_from_slice(&self.root_moment_rate.output_rate(measured.root_moment_dot, [0.0; 2]));
        }
        let mass = self.mass.derivative(&self.gains.mass, self.object_rate(inputs), forces[2]);
        out[state::MASS].copy_from_slice(&mass.to_array());
        let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
        if let Some(networks) = &mut self.networks {
            let (first, weights) = out.split_at_mut(state::WEIGHTS);
            let weights = weights_of(networks.nodes(), weights);
            let held = Self::held(regimes);
            let bounds = networks.derivatives(&self.gains.networks, &seen, &now.sight, held, weights);
            first[state::BOUNDS].copy_from_slice(&bounds);
        }
    }

    fn derivative_change(&mut self, inputs: &Inputs, regimes: &Regimes, along: Direction<'_>, out: &mut [f64]) {
        let now = self.present(inputs);
        let change = self.change(inputs, &now, along);
        let commands = now.commands();
        let forces = self.actuation.forces(&commands, inputs);
        let force_changes = self.actuation.force_changes(&commands, &change.outcome.into(), along.inputs);
        out.fill(0.0);
        let rates = std::array::from_fn(|i| {
            let Sight { known, observer, measured } = &now.sight[i];
            let SightChange { inertia, observer: moving, measured: measured_change } = change.sight[i];
            let by = ObserverChange { observer: moving, measured: measured_change, force: force_changes[i], inertia };
            let held = regimes.disturbance[i] || self.networks.is_some();
            observer.derivative_change(known, *measured, forces[i], held, &by)
        });
        put_observers(&rates, out);
        if self.filters() {
            let (w, moving) = (self.gains.strain_rate_bandwidth, &along.inputs.measured);
            for i in 0..2 {
                let (shear, moment) = (state::SHEAR_RATES.start + i, state::MOMENT_RATES.start + i);
                out[shear] = w * (moving.tip_shear_dot[i] - along.states[shear]);
                out[moment] = w * (moving.root_moment_dot[i] - along.states[moment]);
            }
        }
        let mass = MassEstimator::from_array(std::array::from_fn(|i| along.states[state::MASS.start + i]));
        let velocity = self.object_rate(inputs);
        let velocity_change = match self.source {
            RateSource::Measured => along.inputs.measured.y_object_dot,
            RateSource::Estimated => change.by.v,
        };
        let by = (velocity_change, force_changes[2]);
        let mass = self.mass.derivative_change(&self.gains.mass, velocity, &mass, by);
        out[state::MASS].copy_from_slice(&mass.to_array());
        let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
        let seen_by = self.seen(&change.by, &change.outcome, along.inputs.measured.tip_shear, change.shear_rate);
        if let Some(networks) = &mut self.networks {
            let (first, weights) = out.split_at_mut(state::WEIGHTS);
            let direction = network_direction(networks.nodes(), along.states);
            let weights = weights_of(networks.nodes(), weights);
            let bounds = networks.derivative_changes(
                &self.gains.networks,
                (&seen, &now.sight),
                (&seen_by, &change.sight),
                &direction,
                Self::held(regimes),
                weights,
            );
            first[state::BOUNDS].copy_from_slice(&bounds);
        }
    }

    fn event_indicators(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        let now = self.present(inputs);
        let commands = now.commands();
        let forces = self.actuation.forces(&commands, inputs);
        out.fill(1.0);
        out[indicator::LIMITS].copy_from_slice(&self.actuation.distances(&commands));
        out[indicator::MASS].copy_from_slice(&self.mass.distances(&self.gains.mass));
        let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
        if let Some(networks) = &mut self.networks {
            let found = networks.indicators(&self.gains.networks, &seen, &now.sight, Self::held(regimes));
            for (i, [ball, bound, clip]) in found.into_iter().enumerate() {
                out[indicator::WEIGHTS.start + i] = ball;
                out[indicator::BOUNDS.start + i] = bound;
                out[indicator::UNKNOWNS.start + i] = clip;
            }
        } else {
            for i in 0..3 {
                let Sight { known, observer, measured } = &now.sight[i];
                let limit = observer.limit(known, *measured, forces[i]);
                out[indicator::DISTURBANCES.start + i] = limit.indicator(regimes.disturbance[i]);
            }
        }
    }

    fn decide(&mut self, inputs: &Inputs, regimes: &mut Regimes) -> Decision {
        let now = self.present(inputs);
        let forces = self.actuation.forces(&now.commands(), inputs);
        let mut decision = Decision::default();
        let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
        if let Some(networks) = &mut self.networks {
            let Regimes { weights, bound, .. } = regimes;
            networks.decide(&self.gains.networks, &seen, &now.sight, weights, bound, &mut decision);
        } else {
            for (i, held) in regimes.disturbance.iter_mut().enumerate() {
                let Sight { known, measured, .. } = now.sight[i];
                self.observers[i].decide(&known, measured, forces[i], held, &mut decision);
            }
        }
        decision
    }
}
