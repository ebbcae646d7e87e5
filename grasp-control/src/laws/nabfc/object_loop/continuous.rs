//! The object's loop as differential equations.

use super::{ObjectInputs, ObjectLoop, Point};
use crate::continuous::Decision;
use crate::laws::nabfc::estimator::{Drive, EstimatorChange, Scalars};

impl ObjectLoop {
    /// Time derivatives of the estimates; those of the weights into `weights`.
    pub fn derivatives(&mut self, inputs: &ObjectInputs, held: bool, weights: &mut [f64]) -> Scalars {
        let drive = self.at(inputs).drive();
        self.estimator.derivatives(&drive, held, weights)
    }

    /// Exact change of [`derivatives`](Self::derivatives) for a change `by` of the inputs and of the estimates.
    pub fn derivative_change(
        &mut self,
        inputs: &ObjectInputs,
        held: bool,
        by: &ObjectInputs,
        (scalars, weights): (Scalars, &[f64]),
        out: &mut [f64],
    ) -> Scalars {
        let Point { s, tanh, regressor, .. } = self.at(inputs);
        let drive = self.at(inputs).drive();
        let [c1, c2] = self.settings.compliance;
        let gains = &self.settings.gains;
        // The surface is linear in the inputs.
        let ds = self.surface(by);
        let w_dot = [by.shear_dot[0] * c1, by.shear_dot[1] * c2];
        let shear_rate = w_dot[0] + w_dot[1];
        let alpha_dot = -gains.c1 * by.z1_dot - shear_rate;
        let x = [by.z1, ds, alpha_dot, by.shear[0] * c1, by.shear[1] * c2, w_dot[0], w_dot[1]];
        let change = EstimatorChange {
            scalars,
            weights,
            drive: Drive {
                s: ds,
                bound: ds * (tanh + s * (1.0 - tanh * tanh) / gains.epsilon1),
                inertia: ds * regressor + s * (self.slope() * by.z1_dot + shear_rate),
            },
            x: std::array::from_fn(|axis| x[axis] * self.settings.inverse_scales[axis]),
        };
        self.estimator.derivative_change(&drive, held, &change, out)
    }

    /// Exact change of the force for a change `by` of the inputs and of the estimates.
    pub fn command_change(
        &mut self,
        inputs: &ObjectInputs,
        by: &ObjectInputs,
        (scalars, weights): (Scalars, &[f64]),
    ) -> f64 {
        let partials = self.partials(inputs);
        let Point { tanh, regressor, .. } = self.at(inputs);
        let arms: f64 = (0..2).map(|i| partials.shear[i] * by.shear[i] + partials.shear_dot[i] * by.shear_dot[i]).sum();
        partials.z1 * by.z1 + partials.z1_dot * by.z1_dot + partials.lambda1 * by.lambda1 + arms
            - self.estimator.output_change(weights)
            - scalars.bound * tanh
            - scalars.inertia * regressor
    }

    /// Distance of s from the corners of sat, and what the ball of the weights tells.
    pub fn indicators(&mut self, inputs: &ObjectInputs, held: bool) -> [f64; 2] {
        let point = self.at(inputs);
        let (limit, switched) = (self.settings.sat_limit, self.settings.gains.eta > 0.0);
        let corner = if switched && limit > 0.0 { limit - point.s.abs() } else { 1.0 };
        [corner, self.estimator.indicator(&point.drive(), held)]
    }

    /// Whether the ball holds the weights.
    pub fn decide(&mut self, inputs: &ObjectInputs, held: &mut bool, decision: &mut Decision) {
        let drive = self.at(inputs).drive();
        self.estimator.decide(&drive, held, decision);
    }
}
