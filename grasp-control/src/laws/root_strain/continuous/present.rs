//! The law at one instant, and how it changes along a direction of states and inputs.

use super::super::RootStrain;
use super::super::inertia::Estimator;
use super::super::loops::{Outcome, Point};
use super::super::networks::{NetworkDirection, Seen, Sight, SightChange};
use super::super::signals::{loads, motions};
use crate::blocks::observer::RateSource;
use crate::continuous::{Direction, state};
use crate::laws::encoders::observers;
use crate::laws::nabfc::{Estimates, Surfaces};
use crate::signals::{Commands, Inputs};

/// Everything at one instant.
pub(super) struct Present {
    pub at: Point,
    pub outcome: Outcome,
    pub shear_rate: [f64; 2],
    pub sight: [Sight; 3],
}

/// How everything changes along a direction.
pub(super) struct Change {
    pub by: Point,
    pub outcome: Outcome,
    pub shear_rate: [f64; 2],
    pub sight: [SightChange; 3],
}

impl Present {
    #[inline]
    pub(super) fn commands(&self) -> Commands {
        self.outcome.into()
    }
}

impl RootStrain {
    /// Whether the low-passes are in use.
    #[inline]
    pub(super) fn filters(&self) -> bool {
        self.source == RateSource::Measured && self.root_moment_rate.is_on()
    }

    #[inline]
    pub(super) fn present(&mut self, inputs: &Inputs) -> Present {
        let mut at = self.point(inputs);
        let (_, shear_rate) = self.strain_rates(inputs);
        let (known, measured) = (self.known(), motions(inputs));
        let mut sight: [Sight; 3] =
            std::array::from_fn(|i| Sight { known: known[i], observer: self.observers.of(i), measured: measured[i] });
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

    #[inline]
    pub(super) fn change(&mut self, inputs: &Inputs, now: &Present, along: Direction<'_>) -> Change {
        let states = along.states;
        let mut by = self.direction(along.inputs);
        let mut moving = observers(states);
        by.omega = [moving[0].rate, moving[1].rate];
        by.v = moving[2].rate;
        by.unknown = moving.map(|observer| observer.disturbance);
        let [inertia1, inertia2, mass] = self.inertia_changes(states);
        (by.inertia, by.mass) = ([inertia1, inertia2], mass);
        let pair = |first: usize| [states[first], states[first + 1]];
        if self.root_moment.is_on() {
            let filtered = pair(state::MOMENTS.start);
            (0..2).for_each(|i| by.moment[i] += filtered[i]);
        }
        let (moment_rate, shear_rate) = match self.source {
            RateSource::Estimated => self.quasi_static(by.omega, by.v),
            RateSource::Measured => {
                let (moments, shears) = loads(along.inputs);
                let slow = |first: usize| if self.filters() { pair(first) } else { [0.0; 2] };
                (
                    self.root_moment_rate.output_change(moments, slow(state::SLOW_MOMENTS.start)),
                    self.tip_shear_rate.output_change(shears, slow(state::SLOW_SHEARS.start)),
                )
            }
        };
        (by.moment_rate, by.shear_rate) = (moment_rate, shear_rate[0] + shear_rate[1]);
        let measured = motions(along.inputs);
        let mut outcome = self.loops().change(&now.at, &by);
        let mut sight: [SightChange; 3] = std::array::from_fn(|i| SightChange {
            inertia: [inertia1, inertia2, mass][i],
            observer: moving[i],
            measured: measured[i],
        });
        if self.networks.is_some() {
            let seen = self.seen(&now.at, &now.outcome, inputs.measured.tip_shear, now.shear_rate);
            let seen_by = self.seen_change(&now.at, &by, &outcome, along.inputs.measured.tip_shear, shear_rate);
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

    /// Changes of Ĵ₁, Ĵ₂, m̂.
    #[inline]
    fn inertia_changes(&self, states: &[f64]) -> [f64; 3] {
        let changes = estimators(states);
        std::array::from_fn(|i| self.inertia.of(i).inertia_changes(&self.priors[i], &changes[i]))
    }

    /// Change of what the networks see for a change `by` of the point and `outcome` of the surfaces.
    #[inline]
    pub(super) fn seen_change<'a>(
        &self,
        at: &Point,
        by: &'a Point,
        outcome: &Outcome,
        shear: [f64; 2],
        shear_rate: [f64; 2],
    ) -> Seen<'a> {
        let (scaled, loops) = (&self.scaled, self.loops());
        let tip = loops.tip(at);
        Seen {
            at: by,
            surface: outcome.object,
            posture: outcome.posture,
            alpha_rate: -scaled.slope * by.v - tip * (by.shear_rate - 0.5 * at.shear_rate * by.mass / at.mass),
            posture_alpha_rate: std::array::from_fn(|i| {
                let moment_rate = by.moment_rate[i] - at.moment_rate[i] * by.inertia[i] / at.inertia[i];
                let slope = loops.hub_slope(i, at.inertia[i]) * by.omega[i]
                    + loops.hub_slope_change(i, at.inertia[i], by.inertia[i]) * at.omega[i];
                -slope - scaled.hub_strain[i] * moment_rate / at.inertia[i]
            }),
            shear,
            shear_rate,
        }
    }

    /// Change of the surfaces along a direction.
    #[inline]
    pub fn surface_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Surfaces {
        let now = self.present(inputs);
        self.change(inputs, &now, along).outcome.into()
    }

    /// Change of the estimates along a direction of the states.
    #[must_use]
    #[inline]
    pub fn estimate_change(&self, states: &[f64]) -> Estimates {
        let [inertia1, inertia2, m_hat] = self.inertia_changes(states);
        let ([u1, u2, w], [pi1, pi2, epsilon]) = if let Some(networks) = &self.networks {
            let direction = network_direction(networks.nodes(), states);
            (networks.norm_changes(direction.weights), direction.bounds)
        } else {
            let changes = observers(states);
            let change = |i: usize| changes[i].disturbance * self.observers.disturbance[i].signum();
            ([change(0), change(1), change(2)], [0.0; 3])
        };
        Estimates {
            m_hat,
            j_hat: [inertia1, inertia2],
            epsilon_hat: epsilon,
            pi_hat: [pi1, pi2],
            w_norm: w,
            u_norm: [u1, u2],
        }
    }
}

/// Û₁, Û₂, Ŵ and the robust terms of a vector of states.
#[inline]
pub(super) fn network_direction(nodes: [usize; 3], states: &[f64]) -> NetworkDirection<'_> {
    let (u1, rest) = states[state::WEIGHTS..].split_at(nodes[0]);
    let (u2, rest) = rest.split_at(nodes[1]);
    NetworkDirection {
        weights: [u1, u2, &rest[..nodes[2]]],
        bounds: std::array::from_fn(|i| states[state::BOUNDS.start + i]),
    }
}

/// The estimators of a vector of states, or of a direction.
#[inline]
pub(super) fn estimators(states: &[f64]) -> [Estimator; 3] {
    std::array::from_fn(|i| {
        let first = state::ESTIMATORS.start + i * Estimator::<f64>::STATES;
        Estimator::from_array(std::array::from_fn(|j| states[first + j]))
    })
}

/// Puts estimators, or their rates, into a vector of states.
#[inline]
pub(super) fn put_estimators(estimators: &[Estimator; 3], out: &mut [f64]) {
    for (estimator, out) in estimators.iter().zip(out[state::ESTIMATORS].chunks_exact_mut(Estimator::<f64>::STATES)) {
        out.copy_from_slice(&estimator.to_array());
    }
}
