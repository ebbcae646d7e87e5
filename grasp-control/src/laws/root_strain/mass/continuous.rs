//! The estimate as differential equations.

use super::{MassEstimator, MassGains};

impl MassEstimator {
    /// Number of states.
    pub const STATES: usize = 6;

    pub fn to_array(self) -> [f64; Self::STATES] {
        let Self { velocity, force, slow_acceleration, slow_force, force_force, acceleration_force } = self;
        [velocity, force, slow_acceleration, slow_force, force_force, acceleration_force]
    }

    pub fn from_array(states: [f64; Self::STATES]) -> Self {
        let [velocity, force, slow_acceleration, slow_force, force_force, acceleration_force] = states;
        Self { velocity, force, slow_acceleration, slow_force, force_force, acceleration_force }
    }

    /// Time derivatives.
    pub fn derivative(&self, gains: &MassGains, velocity: f64, force: f64) -> Self {
        let (a, f) = self.regressors(gains, velocity);
        Self {
            velocity: gains.filter * (velocity - self.velocity),
            force: gains.filter * (force - self.force),
            slow_acceleration: gains.high_pass * a,
            slow_force: gains.high_pass * f,
            force_force: f * f * (1.0 - self.force_force / gains.memory),
            acceleration_force: a * f - f * f * self.acceleration_force / gains.memory,
        }
    }

    /// Exact change of [`derivative`](Self::derivative) for a change `by` of the state, and of velocity and force.
    pub fn derivative_change(&self, gains: &MassGains, velocity: f64, by: &Self, (dv, df): (f64, f64)) -> Self {
        let (a, f) = self.regressors(gains, velocity);
        // Linear.
        let (a_change, f_change) = by.regressors(gains, dv);
        let square_change = 2.0 * f * f_change;
        Self {
            velocity: gains.filter * (dv - by.velocity),
            force: gains.filter * (df - by.force),
            slow_acceleration: gains.high_pass * a_change,
            slow_force: gains.high_pass * f_change,
            force_force: square_change * (1.0 - self.force_force / gains.memory)
                - f * f * by.force_force / gains.memory,
            acceleration_force: a_change * f + a * f_change
                - (square_change * self.acceleration_force + f * f * by.acceleration_force) / gains.memory,
        }
    }

    /// How far 1/m̂ is inside its limits \[1/kg\]: from that of the largest mass, from that of the smallest. Limits that are the
    /// same leave nothing to happen.
    pub fn distances(&self, gains: &MassGains) -> [f64; 2] {
        if gains.largest <= gains.smallest {
            return [1.0; 2];
        }
        let mobility = self.mobility(gains);
        [mobility - gains.largest.recip(), gains.smallest.recip() - mobility]
    }

    /// Change of m̂.
    pub fn mass_change(&self, gains: &MassGains, by: &Self) -> f64 {
        let mobility = self.mobility(gains);
        if gains.largest <= gains.smallest || self.distances(gains).iter().any(|distance| *distance < 0.0) {
            return 0.0;
        }
        let change = (by.acceleration_force - mobility * by.force_force) / (self.force_force + gains.prior);
        -change / mobility.powi(2)
    }
}
