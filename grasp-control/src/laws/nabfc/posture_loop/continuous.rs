//! A hub's loop as differential equations.

use super::{Point, PostureLoop};
use crate::continuous::Decision;
use crate::laws::nabfc::estimator::{Drive, EstimatorChange, Scalars};

impl PostureLoop {
    /// Time derivatives of the estimates at (e, ė); those of the weights into `weights`.
    pub fn derivatives(&mut self, (e, e_dot): (f64, f64), held: bool, weights: &mut [f64]) -> Scalars {
        let drive = self.at(e, e_dot).drive();
        self.estimator.derivatives(&drive, held, weights)
    }

    /// Exact change of [`derivatives`](Self::derivatives) for a change `by` of (e, ė) and of the estimates.
    pub fn derivative_change(
        &mut self,
        (e, e_dot): (f64, f64),
        held: bool,
        by: (f64, f64),
        (scalars, weights): (Scalars, &[f64]),
        out: &mut [f64],
    ) -> Scalars {
        let point = self.at(e, e_dot);
        let Point { s, tanh, regressor, .. } = point;
        let gains = &self.settings.gains;
        let [angle, surface, alpha] = self.settings.inverse_scales;
        // The surface is linear.
        let ds = self.surface(by.0, by.1);
        let change = EstimatorChange {
            scalars,
            weights,
            drive: Drive {
                s: ds,
                bound: ds * (tanh + s * (1.0 - tanh * tanh) / gains.epsilon2),
                inertia: ds * regressor + s * by.1 * self.slope(),
            },
            x: [by.0 * angle, ds * surface, -gains.c3 * by.1 * alpha],
        };
        self.estimator.derivative_change(&point.drive(), held, &change, out)
    }

    /// Exact change of the torque for a change `by` of (e, ė) and of the estimates, without that of the root moment.
    pub fn command_change(
        &mut self,
        (e, e_dot): (f64, f64),
        by: (f64, f64),
        (scalars, weights): (Scalars, &[f64]),
    ) -> f64 {
        let partials = self.partials(e, e_dot);
        let Point { tanh, regressor, .. } = self.at(e, e_dot);
        partials.e * by.0 + partials.e_dot * by.1
            - self.estimator.output_change(weights)
            - scalars.bound * tanh
            - scalars.inertia * regressor
    }

    /// Distance of s from the corners of sat, and what the ball of the weights tells.
    pub fn indicators(&mut self, (e, e_dot): (f64, f64), held: bool) -> [f64; 2] {
        let point = self.at(e, e_dot);
        let (limit, switched) = (self.settings.sat_limit, self.settings.gains.xi > 0.0);
        let corner = if switched && limit > 0.0 { limit - point.s.abs() } else { 1.0 };
        [corner, self.estimator.indicator(&point.drive(), held)]
    }

    /// Whether the ball holds the weights.
    pub fn decide(&mut self, (e, e_dot): (f64, f64), held: &mut bool, decision: &mut Decision) {
        let drive = self.at(e, e_dot).drive();
        self.estimator.decide(&drive, held, decision);
    }
}
