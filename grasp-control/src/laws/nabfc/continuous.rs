//! The paper's law as differential equations: the update laws (37)–(39), (55)–(57) and the low-pass as they stand.

use super::estimator::Scalars;
use super::{Estimates, Known, LoopInputs, Nabfc, ObjectInputs, Surfaces};
use crate::continuous::{Continuous, Decision, Direction, Regimes, indicator, state};
use crate::law::inner;
use crate::signals::{Commands, Inputs};

/// Hub 1, hub 2, object.
const OBJECT: usize = 2;

impl Nabfc {
    /// Inputs of the loops, with the low-pass as it is.
    #[inline]
    fn present(&self, inputs: &Inputs) -> LoopInputs {
        self.loop_inputs(inputs, self.shear_rate.output(inputs.measured.tip_shear_dot))
    }

    /// Change of the loops' inputs along a direction: they are linear, but for the constant L/2.
    #[inline]
    fn present_change(&self, along: Direction<'_>) -> LoopInputs {
        let (rows, values) = (self.arms.error_jacobian(), along.inputs.to_array());
        let measured = &along.inputs.measured;
        let filtered = std::array::from_fn(|i| along.states[state::SHEAR_RATES.start + i]);
        LoopInputs {
            object: ObjectInputs {
                z1: inner(&rows.p, &values),
                z1_dot: measured.y_object_dot,
                shear: measured.tip_shear,
                shear_dot: if self.shear_rate.is_on() { filtered } else { measured.tip_shear_dot },
                lambda1: along.inputs.reference.lambda1_ref,
            },
            posture: std::array::from_fn(|i| (inner(&rows.e[i], &values), measured.theta_dot[i])),
        }
    }

    /// Change of the surfaces along a direction.
    #[must_use]
    #[inline]
    pub fn surface_change(&self, along: Direction<'_>) -> Surfaces {
        let change = self.present_change(along);
        Surfaces {
            object: self.object.surface(&change.object),
            posture: std::array::from_fn(|i| self.posture[i].surface(change.posture[i].0, change.posture[i].1)),
        }
    }

    /// Change of the estimates along a direction of the states.
    #[must_use]
    #[inline]
    pub fn estimate_change(&self, states: &[f64]) -> Estimates {
        let [arm1, arm2] = [0, 1].map(|i| scalars(states, i));
        let object = scalars(states, OBJECT);
        let [u1, u2, w] = self.split(&states[state::WEIGHTS..]);
        Estimates {
            m_hat: object.inertia,
            j_hat: [arm1.inertia, arm2.inertia],
            epsilon_hat: object.bound,
            pi_hat: [arm1.bound, arm2.bound],
            w_norm: self.object.estimator.network.norm_change(w),
            u_norm: [
                self.posture[0].estimator.network.norm_change(u1),
                self.posture[1].estimator.network.norm_change(u2),
            ],
        }
    }

    /// Û₁, Û₂, Ŵ.
    #[inline]
    fn split<'a>(&self, weights: &'a [f64]) -> [&'a [f64]; 3] {
        let (u1, rest) = weights.split_at(self.posture[0].estimator.nodes());
        let (u2, rest) = rest.split_at(self.posture[1].estimator.nodes());
        [u1, u2, &rest[..self.object.estimator.nodes()]]
    }

    #[inline]
    fn split_mut<'a>(&self, weights: &'a mut [f64]) -> [&'a mut [f64]; 3] {
        let (u1, rest) = weights.split_at_mut(self.posture[0].estimator.nodes());
        let (u2, rest) = rest.split_at_mut(self.posture[1].estimator.nodes());
        [u1, u2, &mut rest[..self.object.estimator.nodes()]]
    }
}

/// Estimates of a vector of states, or of a direction.
#[inline]
fn scalars(states: &[f64], index: usize) -> Scalars {
    Scalars { inertia: states[state::INERTIAS.start + index], bound: states[state::BOUNDS.start + index] }
}

#[inline]
fn put_scalars(scalars: [Scalars; 3], states: &mut [f64]) {
    for (i, Scalars { inertia, bound }) in scalars.into_iter().enumerate() {
        states[state::INERTIAS.start + i] = inertia;
        states[state::BOUNDS.start + i] = bound;
    }
}

impl Continuous for Nabfc {
    #[inline]
    fn continuous_states(&self, out: &mut [f64]) {
        let (first, weights) = out.split_at_mut(state::WEIGHTS);
        first.fill(0.0);
        if self.shear_rate.is_on() {
            first[state::SHEAR_RATES].copy_from_slice(&self.shear_rate.output([0.0; 2]));
        }
        let [u1, u2, w] = self.split_mut(weights);
        let [arm1, arm2] = &self.posture;
        put_scalars([arm1.estimator.put(u1), arm2.estimator.put(u2), self.object.estimator.put(w)], first);
    }

    #[inline]
    fn take_states(&mut self, states: &[f64]) {
        self.keep.known = Known::Nothing;
        if self.shear_rate.is_on() {
            self.shear_rate.settle(std::array::from_fn(|i| states[state::SHEAR_RATES.start + i]));
        }
        let [u1, u2, w] = self.split(&states[state::WEIGHTS..]);
        self.posture[0].estimator.take(scalars(states, 0), u1);
        self.posture[1].estimator.take(scalars(states, 1), u2);
        self.object.estimator.take(scalars(states, OBJECT), w);
    }

    #[inline]
    fn command_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Commands {
        let (at, by) = (self.present(inputs), self.present_change(along));
        let [u1, u2, w] = self.split(&along.states[state::WEIGHTS..]);
        let tau = std::array::from_fn(|i| {
            let estimates = (scalars(along.states, i), [u1, u2][i]);
            self.posture[i].command_change(at.posture[i], by.posture[i], estimates)
                + along.inputs.measured.root_moment[i]
        });
        Commands { tau, u: self.object.command_change(&at.object, &by.object, (scalars(along.states, OBJECT), w)) }
    }

    #[inline]
    fn derivatives(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        let at = self.present(inputs);
        let (first, weights) = out.split_at_mut(state::WEIGHTS);
        first.fill(0.0);
        if self.shear_rate.is_on() {
            let rates = self.shear_rate.output_rate(inputs.measured.tip_shear_dot, [0.0; 2]);
            first[state::SHEAR_RATES].copy_from_slice(&rates);
        }
        let [u1, u2, w] = self.split_mut(weights);
        let [arm1, arm2] = &mut self.posture;
        let rates = [
            arm1.derivatives(at.posture[0], regimes.weights[0], u1),
            arm2.derivatives(at.posture[1], regimes.weights[1], u2),
            self.object.derivatives(&at.object, regimes.weights[OBJECT], w),
        ];
        put_scalars(rates, first);
    }

    #[inline]
    fn derivative_change(&mut self, inputs: &Inputs, regimes: &Regimes, along: Direction<'_>, out: &mut [f64]) {
        let (at, by) = (self.present(inputs), self.present_change(along));
        let (first, weights) = out.split_at_mut(state::WEIGHTS);
        first.fill(0.0);
        if self.shear_rate.is_on() {
            for i in 0..2 {
                let place = state::SHEAR_RATES.start + i;
                first[place] =
                    self.gains.shear_rate_bandwidth * (along.inputs.measured.tip_shear_dot[i] - along.states[place]);
            }
        }
        let [du1, du2, dw] = self.split(&along.states[state::WEIGHTS..]);
        let [u1, u2, w] = self.split_mut(weights);
        let estimates = |i: usize| scalars(along.states, i);
        let held = regimes.weights;
        let [arm1, arm2] = &mut self.posture;
        let rates = [
            arm1.derivative_change(at.posture[0], held[0], by.posture[0], (estimates(0), du1), u1),
            arm2.derivative_change(at.posture[1], held[1], by.posture[1], (estimates(1), du2), u2),
            self.object.derivative_change(&at.object, held[OBJECT], &by.object, (estimates(OBJECT), dw), w),
        ];
        put_scalars(rates, first);
    }

    #[inline]
    fn event_indicators(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        let at = self.present(inputs);
        out.fill(1.0);
        let [arm1, arm2] = &mut self.posture;
        let pairs = [
            arm1.indicators(at.posture[0], regimes.weights[0]),
            arm2.indicators(at.posture[1], regimes.weights[1]),
            self.object.indicators(&at.object, regimes.weights[OBJECT]),
        ];
        for (i, [corner, ball]) in pairs.into_iter().enumerate() {
            out[indicator::SATURATIONS.start + i] = corner;
            out[indicator::WEIGHTS.start + i] = ball;
        }
    }

    #[inline]
    fn decide(&mut self, inputs: &Inputs, regimes: &mut Regimes) -> Decision {
        let at = self.present(inputs);
        let mut decision = Decision::default();
        for i in 0..2 {
            self.posture[i].decide(at.posture[i], &mut regimes.weights[i], &mut decision);
        }
        self.object.decide(&at.object, &mut regimes.weights[OBJECT], &mut decision);
        decision
    }
}
