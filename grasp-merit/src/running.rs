//! Metrics of a run while it runs: each communication point is looked at once, and only the last twentieth of the forces is kept.

use std::collections::VecDeque;

use fmi2_cosim::record::Points;

use crate::metrics::{EffortMetrics, ForceMetrics, Limits, Metrics, REST};

/// The metrics up to now.
#[derive(Debug, Clone, Default)]
pub struct Running {
    /// The target, and the forces since its last change.
    forces: Option<(f64, [Force; 2])>,
    efforts: [Effort; 3],
}

impl Running {
    /// Of a run with these limits of the two motors and of the actuator at the object.
    #[must_use]
    pub fn new(limits: [Option<Limits>; 3]) -> Self {
        Self { forces: None, efforts: limits.map(Effort::new) }
    }

    /// The values of the [`SIGNALS`](crate::metrics::SIGNALS) at the next communication point.
    #[inline]
    pub fn push(&mut self, time: f64, [force1, force2, target, tau1, tau2, u]: [f64; 6]) {
        // Both contact forces shall become λ₂ᵈ = −λ₁ᵈ, since f_i = (−1)^i λ_i.
        match &mut self.forces {
            // A target that is not a number stays the target, too.
            Some((last, [one, two])) if *last == target || (last.is_nan() && target.is_nan()) => {
                *last = target;
                one.push(time, force1);
                two.push(time, force2);
            }
            forces => *forces = Some((target, [force1, force2].map(|force| Force::new(time, force, target)))),
        }
        for (effort, value) in self.efforts.iter_mut().zip([tau1, tau2, u]) {
            effort.push(time, value);
        }
    }

    /// The values at the next communication points, each of which has the [`SIGNALS`](crate::metrics::SIGNALS) at these places.
    pub fn extend(&mut self, points: &Points, places: [usize; 6]) {
        for (time, point) in points.iter() {
            self.push(time, places.map(|place| point[place]));
        }
    }

    /// The metrics; `None` if there were no communication points.
    #[must_use]
    pub fn metrics(&self) -> Option<Metrics> {
        let (target, [one, two]) = self.forces.as_ref()?;
        let [first, second, third] = &self.efforts;
        Some(Metrics {
            forces: [one.metrics(*target), two.metrics(*target)],
            efforts: [first.metrics()?, second.metrics()?, third.metrics()?],
        })
    }
}

/// One force.
#[derive(Debug, Clone)]
pub(crate) struct Force {
    target: f64,
    begin: f64,
    end: f64,
    /// From the first value to the target.
    way: f64,
    /// Its sign.
    direction: f64,
    beyond: f64,
    within_2: Settling,
    within_5: Settling,
    count: usize,
    /// The last twentieth of the values.
    tail: VecDeque<f64>,
}

impl Force {
    pub(crate) fn new(time: f64, value: f64, target: f64) -> Self {
        let way = target - value;
        let within = |fraction: f64| Settling { band: fraction * target.abs(), outside: None, next: None };
        let mut force = Self {
            target,
            begin: time,
            end: time,
            way,
            direction: way.signum(),
            beyond: 0.0,
            within_2: within(0.02),
            within_5: within(0.05),
            count: 0,
            tail: VecDeque::new(),
        };
        force.push(time, value);
        force
    }

    #[inline]
    pub(crate) fn push(&mut self, time: f64, value: f64) {
        let error = value - self.target;
        self.beyond = self.beyond.max(error * self.direction);
        self.within_2.push(time, error);
        self.within_5.push(time, error);
        self.end = time;
        self.count += 1;
        self.tail.push_back(value);
        if self.tail.len() > self.count.div_ceil(20) {
            self.tail.pop_front();
        }
    }

    pub(crate) fn metrics(&self, target: f64) -> ForceMetrics {
        let mean = self.tail.iter().sum::<f64>() / self.tail.len() as f64;
        ForceMetrics {
            target,
            settling_2: self.within_2.time(self.begin, self.end),
            settling_5: self.within_5.time(self.begin, self.end),
            overshoot: if self.way == 0.0 { 0.0 } else { 100.0 * self.beyond / self.way.abs() },
            steady_error: mean - target,
        }
    }
}

/// When a signal enters its band for the last time.
#[derive(Debug, Clone)]
struct Settling {
    band: f64,
    /// The last sample outside: time and error.
    outside: Option<(f64, f64)>,
    /// The one after it.
    next: Option<(f64, f64)>,
}

impl Settling {
    #[inline]
    fn push(&mut self, time: f64, error: f64) {
        // An error that is no number is outside.
        if error.abs() > self.band || error.is_nan() {
            (self.outside, self.next) = (Some((time, error)), None);
        } else if self.next.is_none() {
            // Before anything is outside, this is of no account.
            self.next = Some((time, error));
        }
    }

    /// The time after which the error stays within the band, counted from the first sample: the time at which the line between the last
    /// sample outside and the next one crosses the band. `None` if the last sample outside is within the last [`REST`] of the
    /// time.
    fn time(&self, begin: f64, end: f64) -> Option<f64> {
        let Some((last, error)) = self.outside else { return Some(0.0) };
        if last > end - REST * (end - begin) {
            return None;
        }
        let (next, next_error) = self.next?;
        let edge = self.band.copysign(error);
        let share = (error - edge) / (error - next_error);
        let crossing = last + share * (next - last);
        Some(crossing - begin)
    }
}

/// One actuator's output; between samples it is a straight line.
#[derive(Debug, Clone, Default)]
pub(crate) struct Effort {
    peak: f64,
    energy: f64,
    at_limits: f64,
    /// From where on it counts as being at a limit.
    limits: Option<Limits>,
    first: Option<(f64, f64)>,
    time: f64,
    last: f64,
    is_at_limit: bool,
}

impl Effort {
    pub(crate) fn new(limits: Option<Limits>) -> Self {
        let limits = limits.map(|Limits { low, high }| {
            let slack = 1e-9 * (high - low);
            Limits { low: low + slack, high: high - slack }
        });
        // A sum of nothing is −0.
        let (energy, at_limits) = (-0.0, -0.0);
        Self { peak: 0.0, energy, at_limits, limits, first: None, time: 0.0, last: 0.0, is_at_limit: false }
    }

    #[inline]
    pub(crate) fn push(&mut self, time: f64, value: f64) {
        let is_at_limit = self.limits.is_some_and(|Limits { low, high }| value >= high || value <= low);
        if self.first.is_some() {
            let (dt, a, b) = (time - self.time, self.last, value);
            // ∫ of the square of a straight line from a to b: (a² + ab + b²)/3.
            self.energy += dt * (a * a + a * b + b * b) / 3.0;
            self.at_limits += dt * 0.5 * f64::from(u8::from(self.is_at_limit) + u8::from(is_at_limit));
        } else {
            self.first = Some((time, value));
        }
        self.peak = value.abs().max(self.peak);
        (self.time, self.last, self.is_at_limit) = (time, value, is_at_limit);
    }

    pub(crate) fn metrics(&self) -> Option<EffortMetrics> {
        let (begin, first) = self.first?;
        let duration = self.time - begin;
        Some(EffortMetrics {
            peak: self.peak,
            rms: if duration > 0.0 { (self.energy / duration).sqrt() } else { first.abs() },
            saturated: self.limits.map(|_| self.at_limits),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definitions, from all values at once: overshoot in %, steady error, settling time.
    fn of_whole(times: &[f64], values: &[f64], target: f64) -> (f64, f64, Option<f64>) {
        let way = target - values[0];
        let beyond = values.iter().map(|value| (value - target) * way.signum()).fold(0.0, f64::max);
        let tail = &values[values.len() - values.len().div_ceil(20)..];
        let steady_error = tail.iter().sum::<f64>() / tail.len() as f64 - target;
        let band = 0.02 * target.abs();
        let last = values.iter().rposition(|value| (value - target).abs() > band || value.is_nan());
        let settling = match last {
            None => Some(0.0),
            Some(last) if last + 1 == values.len() || times[last] > 0.95 * times[times.len() - 1] => None,
            Some(last) => {
                let error = |index: usize| values[index] - target;
                let share = (error(last) - band.copysign(error(last))) / (error(last) - error(last + 1));
                Some(times[last] + share * (times[last + 1] - times[last]))
            }
        };
        (100.0 * beyond / way.abs(), steady_error, settling)
    }

    #[test]
    fn what_is_seen_once_gives_what_the_whole_gives() {
        // A decaying oscillation, seen for ever longer; now and then it is no number.
        let (times, values): (Vec<f64>, Vec<f64>) = (0..700_u32)
            .map(|index| {
                let time = f64::from(index) * 0.01;
                (time, if index == 150 { f64::NAN } else { 0.5 - (-2.0 * time).exp() * (9.0 * time).cos() })
            })
            .unzip();
        let mut settled = 0;
        for count in 1..=values.len() {
            let (times, values) = (&times[..count], &values[..count]);
            let found = ForceMetrics::of(times, values, 0.5);
            assert_eq!(
                (found.overshoot, found.steady_error, found.settling_2).to_bits(),
                of_whole(times, values, 0.5).to_bits()
            );
            settled += usize::from(found.settling_2.is_some());
        }
        assert!((100..600).contains(&settled), "{settled} of 700");
    }

    trait Bits {
        fn to_bits(&self) -> (u64, u64, Option<u64>);
    }

    impl Bits for (f64, f64, Option<f64>) {
        fn to_bits(&self) -> (u64, u64, Option<u64>) {
            (self.0.to_bits(), self.1.to_bits(), self.2.map(f64::to_bits))
        }
    }
}
