//! A hub's loop as differential equations.

use super::PostureLoop;
use crate::blocks::sat::sat_slope;
use crate::continuous::Decision;
use crate::laws::nabfc::estimator::{Drive, EstimatorChange, Scalars};

impl PostureLoop {
    /// Time derivatives of the estimates at (e, ė); those of the weights into `weights`.
    #[inline]
    pub fn derivatives(&mut self, (e, e_dot): (f64, f64), held: bool, weights: &mut [f64]) -> Scalars {
        let drive = self.at(e, e_dot).drive();
        self.estimator.derivatives(&drive, held, weights)
    }

    /// Normalised input of the network for a change of (e, ė, s).
    #[inline]
    fn input_change(&self, (e, e_dot): (f64, f64), s: f64) -> [f64; 3] {
        let [angle, surface, alpha] = self.settings.inverse_scales;
        [e * angle, s * surface, -self.settings.gains.c3 * e_dot * alpha]
    }

    /// Exact change of [`derivatives`](Self::derivatives) for a change `by` of (e, ė) and of the estimates.
    #[inline]
    pub fn derivative_change(
        &mut self,
        (e, e_dot): (f64, f64),
        held: bool,
        by: (f64, f64),
        (scalars, weights): (Scalars, &[f64]),
        out: &mut [f64],
    ) -> Scalars {
        let point = self.at(e, e_dot);
        // The surface is linear.
        let ds = self.surface(by.0, by.1);
        let tanh_slope = (1.0 - point.tanh * point.tanh) / self.settings.gains.epsilon2;
        let drive = Drive {
            s: ds,
            bound: ds * (point.tanh + point.s * tanh_slope),
            inertia: ds * point.regressor + point.s * by.1 * self.slope(),
        };
        let change = EstimatorChange { scalars, weights, drive, x: self.input_change(by, ds) };
        self.estimator.derivative_change(&point.drive(), held, &change, out)
    }

    /// Exact change of the torque for a change `by` of (e, ė) and of the estimates, without that of the root moment.
    #[inline]
    pub fn command_change(
        &mut self,
        (e, e_dot): (f64, f64),
        by: (f64, f64),
        (scalars, weights): (Scalars, &[f64]),
    ) -> f64 {
        let point = self.at(e, e_dot);
        let ds = self.surface(by.0, by.1);
        let gains = &self.settings.gains;
        let tanh_change = (1.0 - point.tanh * point.tanh) * ds / gains.epsilon2;
        -gains.xi * sat_slope(point.s, self.settings.sat_limit) * ds
            - gains.k * ds
            - by.0
            - self.estimator.output_change(weights, self.input_change(by, ds))
            - scalars.bound * point.tanh
            - self.estimator.bound * tanh_change
            - scalars.inertia * point.regressor
            - self.estimator.inertia * by.1 * self.slope()
    }

    /// Distance of s from the corners of sat, and what the ball of the weights tells.
    #[inline]
    pub fn indicators(&mut self, (e, e_dot): (f64, f64), held: bool) -> [f64; 2] {
        let point = self.at(e, e_dot);
        let (limit, switched) = (self.settings.sat_limit, self.settings.gains.xi > 0.0);
        let corner = if switched && limit > 0.0 { limit - point.s.abs() } else { 1.0 };
        [corner, self.estimator.indicator(&point.drive(), held)]
    }

    /// Whether the ball holds the weights.
    #[inline]
    pub fn decide(&mut self, (e, e_dot): (f64, f64), held: &mut bool, decision: &mut Decision) {
        let drive = self.at(e, e_dot).drive();
        self.estimator.decide(&drive, held, decision);
    }
}
