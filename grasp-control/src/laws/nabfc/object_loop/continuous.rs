//! The object's loop as differential equations.

use super::{ObjectInputs, ObjectLoop};
use crate::blocks::sat::sat_slope;
use crate::continuous::Decision;
use crate::laws::nabfc::estimator::{Drive, EstimatorChange, Scalars};

/// Change of what the loop computes from its inputs.
struct SignalChange {
    s: f64,
    regressor: f64,
    /// Normalised input of the network.
    x: [f64; 7],
}

impl ObjectLoop {
    /// Time derivatives of the estimates; those of the weights into `weights`.
    #[inline]
    pub fn derivatives(&mut self, inputs: &ObjectInputs, held: bool, weights: &mut [f64]) -> Scalars {
        let drive = self.at(inputs).drive();
        self.estimator.derivatives(&drive, held, weights)
    }

    /// Change of the signals for a change of the inputs: they are linear.
    #[inline]
    fn signal_change(&self, by: &ObjectInputs) -> SignalChange {
        let [c1, c2] = self.settings.compliance;
        let s = self.surface(by);
        let w_dot = [by.shear_dot[0] * c1, by.shear_dot[1] * c2];
        let shear_rate = w_dot[0] + w_dot[1];
        let alpha_dot = -self.settings.gains.c1 * by.z1_dot - shear_rate;
        let x = [by.z1, s, alpha_dot, by.shear[0] * c1, by.shear[1] * c2, w_dot[0], w_dot[1]];
        SignalChange {
            s,
            regressor: self.slope() * by.z1_dot + shear_rate,
            x: std::array::from_fn(|axis| x[axis] * self.settings.inverse_scales[axis]),
        }
    }

    /// Exact change of [`derivatives`](Self::derivatives) for a change `by` of the inputs and of the estimates.
    #[inline]
    pub fn derivative_change(
        &mut self,
        inputs: &ObjectInputs,
        held: bool,
        by: &ObjectInputs,
        (scalars, weights): (Scalars, &[f64]),
        out: &mut [f64],
    ) -> Scalars {
        let point = self.at(inputs);
        let SignalChange { s: ds, regressor, x } = self.signal_change(by);
        let tanh_slope = (1.0 - point.tanh * point.tanh) / self.settings.gains.epsilon1;
        let drive = Drive {
            s: ds,
            bound: ds * (point.tanh + point.s * tanh_slope),
            inertia: ds * point.regressor + point.s * regressor,
        };
        self.estimator.derivative_change(&point.drive(), held, &EstimatorChange { scalars, weights, drive, x }, out)
    }

    /// Exact change of the force for a change `by` of the inputs and of the estimates.
    #[inline]
    pub fn command_change(
        &mut self,
        inputs: &ObjectInputs,
        by: &ObjectInputs,
        (scalars, weights): (Scalars, &[f64]),
    ) -> f64 {
        let point = self.at(inputs);
        let SignalChange { s: ds, regressor, x } = self.signal_change(by);
        let gains = &self.settings.gains;
        let tanh_change = (1.0 - point.tanh * point.tanh) * ds / gains.epsilon1;
        -gains.eta * sat_slope(point.s, self.settings.sat_limit) * ds - gains.k * ds - by.z1 + by.shear[0] + by.shear[1]
            - self.estimator.output_change(weights, x)
            - scalars.bound * point.tanh
            - self.estimator.bound * tanh_change
            - scalars.inertia * point.regressor
            - self.estimator.inertia * regressor
    }

    /// Distance of s from the corners of sat, and what the ball of the weights tells.
    #[inline]
    pub fn indicators(&mut self, inputs: &ObjectInputs, held: bool) -> [f64; 2] {
        let point = self.at(inputs);
        let (limit, switched) = (self.settings.sat_limit, self.settings.gains.eta > 0.0);
        let corner = if switched && limit > 0.0 { limit - point.s.abs() } else { 1.0 };
        [corner, self.estimator.indicator(&point.drive(), held)]
    }

    /// Whether the ball holds the weights.
    #[inline]
    pub fn decide(&mut self, inputs: &ObjectInputs, held: &mut bool, decision: &mut Decision) {
        let drive = self.at(inputs).drive();
        self.estimator.decide(&drive, held, decision);
    }
}
