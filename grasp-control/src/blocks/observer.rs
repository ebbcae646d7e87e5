//! Observers of a coordinate's rate and of what disturbs it.
//!
//! A hub or the object is a known inertia J under a known force (command after its limits, less the measured load) and
//! an unknown one, Δ: J ẍ = f + Δ. The observer carries Δ as a state, so its estimate has no error under a constant
//! force, and its rate has the phase of the model instead of the lag of a filter. All its poles are at −ω:
//!
//! ```text
//! from the rate:      v̂˙ = (f + Δ̂)/J + 2ω (v − v̂),   Δ̂˙ = J ω² (v − v̂)
//! from the position:  x̂˙ = v̂ + 3ω (x − x̂),  v̂˙ = (f + Δ̂)/J + 3ω² (x − x̂),  Δ̂˙ = J ω³ (x − x̂)
//! ```
//!
//! Both are linear with one multiple eigenvalue, so a step with held inputs is exact:
//! ξ(h) = ξ_p + e^{−ωh} (1 + N h + ½ N² h²)(ξ − ξ_p), where N is nilpotent and ξ_p the equilibrium.

// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]
// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

mod continuous;

pub(crate) use continuous::ObserverChange;

use super::exponential::exp;
use super::four::Number;
use serde::{Deserialize, Serialize};

/// Where a controller takes rates from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum RateSource {
    /// The rate inputs.
    #[default]
    Measured,
    /// Angles, position and strain alone.
    Estimated,
}

/// What is known about a coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Whether the rate or the position corrects the observer.
    pub source: RateSource,
    /// Poles ω \[rad/s\].
    pub bandwidth: f64,
    /// Inertia J \[kg or kg·m²\].
    pub inertia: f64,
    /// Largest |Δ̂| \[N or N·m\]: no more than the actuator could cancel.
    pub limit: f64,
}

/// Position and rate as measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Position \[m or rad\].
    pub position: f64,
    /// Rate \[m/s or rad/s\]; without meaning where it is estimated.
    pub rate: f64,
}

/// Estimates of one coordinate, or their time derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Observer {
    /// Estimated position; without meaning where the rate is measured.
    pub position: f64,
    /// Estimated rate v̂.
    pub rate: f64,
    /// Estimated disturbance Δ̂ \[N or N·m\].
    pub disturbance: f64,
}

impl Observer {
    /// At rest where nothing else is known, without disturbance.
    #[must_use]
    pub fn settled(source: RateSource, measured: Motion) -> Self {
        let rate = match source {
            RateSource::Measured => measured.rate,
            RateSource::Estimated => 0.0,
        };
        Self { position: measured.position, rate, disturbance: 0.0 }
    }

    /// Time derivatives under the known `force`.
    #[must_use]
    pub fn derivative(&self, known: &Known, measured: Motion, force: f64) -> Self {
        let free = self.free_derivative(known, measured, force);
        let at_limit = self.disturbance.abs() >= known.limit && self.disturbance * free.disturbance > 0.0;
        Self { disturbance: if at_limit { 0.0 } else { free.disturbance }, ..free }
    }

    /// Time derivatives as if the disturbance had no limit.
    fn free_derivative(&self, known: &Known, measured: Motion, force: f64) -> Self {
        let Known { source, bandwidth: w, inertia, .. } = *known;
        let model = (force + self.disturbance) / inertia;
        let (position, rate, disturbance) = match source {
            RateSource::Measured => {
                let error = measured.rate - self.rate;
                (0.0, model + 2.0 * w * error, inertia * w * w * error)
            }
            RateSource::Estimated => {
                let error = measured.position - self.position;
                (self.rate + 3.0 * w * error, model + 3.0 * w * w * error, inertia * w * w * w * error)
            }
        };
        Self { position, rate, disturbance }
    }

    /// Advances by `h` \[s\] with everything held.
    pub fn step(&mut self, h: f64, known: &Known, measured: Motion, force: f64) {
        self.step_decaying(h, Self::decay(known.bandwidth, h), known, measured, force);
    }

    /// e^{−ωh} of poles at −ω \[rad/s\].
    pub(crate) fn decay(bandwidth: f64, h: f64) -> f64 {
        exp(-bandwidth * h)
    }

    /// As [`step`](Self::step), for a caller that keeps the [`decay`](Self::decay).
    fn step_decaying(&mut self, h: f64, decay: f64, known: &Known, measured: Motion, force: f64) {
        let Known { source, bandwidth, inertia, limit } = *known;
        let observed = Observed {
            state: [self.position, self.rate, self.disturbance],
            measured: [measured.position, measured.rate],
            force,
        };
        [self.position, self.rate, self.disturbance] = observed.after(source, h, decay, bandwidth, inertia, limit);
    }
}

/// One observer, or several side by side, and what they see.
pub(crate) struct Observed<V> {
    /// Position, rate, disturbance.
    pub state: [V; 3],
    /// Position, rate.
    pub measured: [V; 2],
    pub force: V,
}

impl<V: Number> Observed<V> {
    /// The state after a step of `h` \[s\] with everything held; `decay` is that of the poles `w`.
    #[inline(always)]
    pub fn after(self, source: RateSource, h: V, decay: V, w: V, inertia: V, limit: V) -> [V; 3] {
        let Self { state: [position, rate, disturbance], measured, force } = self;
        let acceleration = force / inertia;
        let driven = disturbance / inertia + acceleration;
        let (position, rate, driven) = match source {
            RateSource::Measured => {
                let error = rate - measured[1];
                let slope = [driven - w * error, w * (driven - w * error)];
                (measured[0], measured[1] + decay * (error + h * slope[0]), decay * (driven + h * slope[1]))
            }
            RateSource::Estimated => {
                let (two, three) = (V::splat(2.0), V::splat(3.0));
                let start = [position - measured[0], rate, driven];
                let [x, v, d] = start;
                let first = [v - two * w * x, d + w * v - three * w * w * x, w * d - w * w * w * x];
                let [x, v, d] = first;
                let second = [v - two * w * x, d + w * v - three * w * w * x, w * d - w * w * w * x];
                let mut end = start;
                for i in 0..3 {
                    end[i] = decay * (start[i] + h * (first[i] + V::splat(0.5) * h * second[i]));
                }
                (measured[0] + end[0], end[1], end[2])
            }
        };
        let disturbance = inertia * (driven - acceleration);
        let least = V::splat(0.0) - limit;
        [position, rate, limit.smaller(least.larger(disturbance))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn known(source: RateSource, bandwidth: f64) -> Known {
        Known { source, bandwidth, inertia: 0.4, limit: 1e3 }
    }

    fn add(x: &Observer, dx: &Observer, h: f64) -> Observer {
        Observer {
            position: x.position + h * dx.position,
            rate: x.rate + h * dx.rate,
            disturbance: x.disturbance + h * dx.disturbance,
        }
    }

    proptest! {
        /// Against RK4 in 400 steps, whose error at ωh ≤ 2 is below 1e-9.
        #[test]
        fn steps_solve_the_equations(
            bandwidth in 5.0..200.0, h in 1e-4..1e-2, rate in -1.0..1.0_f64, disturbance in -1.0..1.0_f64,
            force in -1.0..1.0_f64, seen in -0.1..0.1_f64,
        ) {
            for source in [RateSource::Measured, RateSource::Estimated] {
                let known = known(source, bandwidth);
                let measured = Motion { position: seen, rate: 3.0 * seen };
                let start = Observer { position: 0.01, rate, disturbance };
                let mut exact = start;
                let dt = h / 400.0;
                for _ in 0..400 {
                    let k1 = exact.derivative(&known, measured, force);
                    let k2 = add(&exact, &k1, 0.5 * dt).derivative(&known, measured, force);
                    let k3 = add(&exact, &k2, 0.5 * dt).derivative(&known, measured, force);
                    let k4 = add(&exact, &k3, dt).derivative(&known, measured, force);
                    for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                        exact = add(&exact, &k, dt * weight / 6.0);
                    }
                }
                let mut stepped = start;
                stepped.step(h, &known, measured, force);
                prop_assert!((stepped.rate - exact.rate).abs() < 1e-8 * (1.0 + exact.rate.abs()));
                prop_assert!((stepped.disturbance - exact.disturbance).abs() < 1e-7 * (1.0 + exact.disturbance.abs()));
                if source == RateSource::Estimated {
                    prop_assert!((stepped.position - exact.position).abs() < 1e-9);
                }
            }
        }
    }

    /// An inertia under a constant unknown force: rate and force are found without error, whatever the source. The
    /// transient, e^{−ωt} times a polynomial, is below 1e-9 after 40/ω.
    #[test]
    fn a_constant_disturbance_is_found() {
        let (h, delta, j) = (1e-4, 0.3, 0.4);
        for source in [RateSource::Measured, RateSource::Estimated] {
            let known = known(source, 100.0);
            let motion = |t: f64| Motion { position: 0.5 * delta / j * t * t, rate: delta / j * t };
            let mut observer = Observer::settled(source, motion(0.0));
            let steps = 4000;
            for step in 0..steps {
                // Held measurements are those of the middle of the step: no lag.
                observer.step(h, &known, motion((f64::from(step) + 0.5) * h), 0.0);
            }
            // Holding the measurement over a step leaves a share of the order (ωh)² = 1e-4 of the force.
            assert!((observer.disturbance - delta).abs() < 5e-4 * delta, "{source:?} {observer:?}");
            let rate = motion(f64::from(steps) * h).rate;
            assert!((observer.rate - rate).abs() < 2e-4, "{source:?} {observer:?} {rate}");
        }
    }

    #[test]
    fn the_disturbance_stays_within_its_limit() {
        let known = Known { limit: 0.2, ..known(RateSource::Measured, 300.0) };
        let mut observer = Observer::default();
        for _ in 0..1000 {
            observer.step(1e-3, &known, Motion { position: 0.0, rate: 5.0 }, -1.0);
            assert!(observer.disturbance.abs() <= 0.2);
        }
    }
}
