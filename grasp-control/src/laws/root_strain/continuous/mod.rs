//! The law as differential equations: observers, filters, estimates of inertias, networks.

mod present;

use super::RootStrain;
use super::networks::{Sight, SightChange};
use crate::blocks::observer::{Observer, ObserverChange, RateSource};
use crate::continuous::{Continuous, Decision, Direction, Regimes, indicator, state};
use crate::laws::encoders::{observers, put_observers};
use crate::signals::{Commands, Inputs};
use present::{estimators, network_direction, put_estimators};

/// The weights in a vector of states, to be written.
#[inline]
fn weights_of(nodes: [usize; 3], weights: &mut [f64]) -> [&mut [f64]; 3] {
    let (u1, rest) = weights.split_at_mut(nodes[0]);
    let (u2, rest) = rest.split_at_mut(nodes[1]);
    [u1, u2, &mut rest[..nodes[2]]]
}

/// The learners' limits that hold: balls, robust terms.
#[inline]
fn held(regimes: &Regimes) -> [[bool; 2]; 3] {
    std::array::from_fn(|i| [regimes.weights[i], regimes.bound[i]])
}

impl Continuous for RootStrain {
    #[inline]
    fn continuous_states(&self, out: &mut [f64]) {
        out.fill(0.0);
        // A position means something where the rate is estimated, a disturbance where no networks stand for it.
        let kept = self.observers.all().map(|observer| Observer {
            position: if self.source == RateSource::Estimated { observer.position } else { 0.0 },
            disturbance: if self.networks.is_some() { 0.0 } else { observer.disturbance },
            ..observer
        });
        put_observers(&kept, out);
        if self.filters() {
            out[state::SLOW_SHEARS].copy_from_slice(&self.tip_shear_rate.filtered());
            out[state::SLOW_MOMENTS].copy_from_slice(&self.root_moment_rate.filtered());
        }
        if self.root_moment.is_on() {
            out[state::MOMENTS].copy_from_slice(&self.root_moment.output([0.0; 2]));
        }
        put_estimators(&self.inertia.clone().into(), out);
        if let Some(networks) = &self.networks {
            let (first, weights) = out.split_at_mut(state::WEIGHTS);
            let bounds = networks.put(weights_of(networks.nodes(), weights));
            first[state::BOUNDS].copy_from_slice(&bounds);
        }
    }

    #[inline]
    fn take_states(&mut self, states: &[f64]) {
        self.observers = observers(states).into();
        if self.filters() {
            self.tip_shear_rate.take(std::array::from_fn(|i| states[state::SLOW_SHEARS.start + i]));
            self.root_moment_rate.take(std::array::from_fn(|i| states[state::SLOW_MOMENTS.start + i]));
        }
        if self.root_moment.is_on() {
            self.root_moment.settle(std::array::from_fn(|i| states[state::MOMENTS.start + i]));
        }
        self.inertia = estimators(states).into();
        self.found = None;
        if let Some(networks) = &mut self.networks {
            networks.take(&network_direction(networks.nodes(), states));
        }
    }

    #[inline]
    fn present_commands(&mut self, inputs: &Inputs) -> Commands {
        self.present(inputs).commands()
    }

    #[inline]
    fn command_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Commands {
        let now = self.present(inputs);
        self.change(inputs, &now, along).outcome.into()
    }

    #[inline]
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
            out[state::SLOW_SHEARS].copy_from_slice(&self.tip_shear_rate.filtered_rate(measured.tip_shear));
            out[state::SLOW_MOMENTS].copy_from_slice(&self.root_moment_rate.filtered_rate(measured.root_moment));
        }
        if self.root_moment.is_on() {
            let rates = self.root_moment.output_rate(inputs.measured.root_moment, [0.0; 2]);
            out[state::MOMENTS].copy_from_slice(&rates);
        }
        let moving = self.moving(inputs, &forces);
        let rates =
            std::array::from_fn(|i| self.inertia.of(i).derivative(&self.gains.filter, &self.priors[i], moving[i]));
        put_estimators(&rates, out);
        let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
        if let Some(networks) = &mut self.networks {
            let (first, weights) = out.split_at_mut(state::WEIGHTS);
            let weights = weights_of(networks.nodes(), weights);
            let held = held(regimes);
            let bounds = networks.derivatives(&self.gains.networks, &seen, &now.sight, held, weights);
            first[state::BOUNDS].copy_from_slice(&bounds);
        }
    }

    #[inline]
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
            let (w, moving) = (self.scaled.strain_rate_bandwidth, &along.inputs.measured);
            for i in 0..2 {
                let (shear, moment) = (state::SLOW_SHEARS.start + i, state::SLOW_MOMENTS.start + i);
                out[shear] = w * (moving.tip_shear[i] - along.states[shear]);
                out[moment] = w * (moving.root_moment[i] - along.states[moment]);
            }
        }
        if self.root_moment.is_on() {
            let (w, moments) = (self.gains.strain_bandwidth, along.inputs.measured.root_moment);
            for (i, place) in state::MOMENTS.enumerate() {
                out[place] = w * (moments[i] - along.states[place]);
            }
        }
        let (moving, changes) = (self.moving(inputs, &forces), estimators(along.states));
        let moved = super::learning::moving(self.source, &observers(along.states), along.inputs, &force_changes);
        let rates = std::array::from_fn(|i| {
            self.inertia.of(i).derivative_change(&self.gains.filter, &self.priors[i], moving[i], &changes[i], moved[i])
        });
        put_estimators(&rates, out);
        let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
        let seen_by =
            self.seen_change(&now.at, &change.by, &change.outcome, along.inputs.measured.tip_shear, change.shear_rate);
        if let Some(networks) = &mut self.networks {
            let (first, weights) = out.split_at_mut(state::WEIGHTS);
            let direction = network_direction(networks.nodes(), along.states);
            let weights = weights_of(networks.nodes(), weights);
            let bounds = networks.derivative_changes(
                &self.gains.networks,
                (&seen, &now.sight),
                (&seen_by, &change.sight),
                &direction,
                held(regimes),
                weights,
            );
            first[state::BOUNDS].copy_from_slice(&bounds);
        }
    }

    #[inline]
    fn event_indicators(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        let now = self.present(inputs);
        let commands = now.commands();
        let forces = self.actuation.forces(&commands, inputs);
        out.fill(1.0);
        out[indicator::LIMITS].copy_from_slice(&self.actuation.distances(&commands));
        for (i, out) in out[indicator::ESTIMATORS].chunks_exact_mut(3).enumerate() {
            out.copy_from_slice(&self.inertia.of(i).distances(&self.priors[i]));
        }
        let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
        if let Some(networks) = &mut self.networks {
            let found = networks.indicators(&self.gains.networks, &seen, &now.sight, held(regimes));
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

    #[inline]
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
                let factor = self.observers.of(i).decide(&known, measured, forces[i], held, &mut decision);
                self.observers.disturbance[i] *= factor;
            }
        }
        decision
    }
}
