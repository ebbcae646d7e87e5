//! Metrics of a run while it runs: each communication point is looked at once, and only the last twentieth of the forces is kept.

mod effort;

use crate::metrics::{ForceMetrics, Limits, Metrics, REST};
pub(crate) use effort::Effort;

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

    /// The next communication points: times, and the values of the [`SIGNALS`](crate::metrics::SIGNALS), as many of each.
    pub fn extend(&mut self, times: &[f64], [force1, force2, targets, tau1, tau2, u]: [&[f64]; 6]) {
        for (effort, values) in self.efforts.iter_mut().zip([tau1, tau2, u]) {
            effort.extend(times, values);
        }
        // Both contact forces shall become λ₂ᵈ = −λ₁ᵈ, since f_i = (−1)^i λ_i.
        let mut begin = 0;
        while let Some(&target) = targets.get(begin) {
            // A target that is not a number stays the target, too.
            let is_other = |value: f64| value != target && !(value.is_nan() && target.is_nan());
            // Most often it is the same to the end; without a branch, the compiler looks at several at once.
            let rest = &targets[begin..];
            let is_target = |value: &f64| *value == target;
            let is_one = rest.iter().fold(true, |all, value| all & is_target(value));
            let other = if is_one { None } else { rest.iter().position(|value| is_other(*value)) };
            let end = other.map_or(targets.len(), |more| begin + more);
            self.forces.take_if(|(last, _)| is_other(*last));
            let (last, forces) = self.forces.get_or_insert_with(|| {
                let force = |values: &[f64]| Force::new(times[begin], values[begin], target);
                let forces = [force(force1), force(force2)];
                begin += 1;
                (target, forces)
            });
            *last = targets[end - 1];
            for (force, values) in forces.iter_mut().zip([force1, force2]) {
                force.extend(&times[begin..end], &values[begin..end]);
            }
            begin = end;
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
    beyond: f64,
    within_2: Settling,
    within_5: Settling,
    count: usize,
    /// The last twentieth of the values, and some before them.
    tail: Vec<f64>,
}

impl Force {
    /// So many values that are of no account any more are kept.
    const SPARE: usize = 4096;

    pub(crate) fn new(time: f64, value: f64, target: f64) -> Self {
        let within = |fraction: f64| Settling { band: fraction * target.abs(), outside: None, next: None };
        let mut force = Self {
            target,
            begin: time,
            end: time,
            way: target - value,
            beyond: 0.0,
            within_2: within(0.02),
            within_5: within(0.05),
            count: 0,
            tail: Vec::new(),
        };
        force.extend(&[time], &[value]);
        force
    }

    pub(crate) fn extend(&mut self, times: &[f64], values: &[f64]) {
        let direction = self.way.signum();
        self.beyond = most(self.beyond, values, |value| (value - self.target) * direction);
        self.within_2.extend(times, values, self.target);
        self.within_5.extend(times, values, self.target);
        self.end = times.last().copied().unwrap_or(self.end);
        self.count += values.len();
        self.tail.extend_from_slice(values);
        let unneeded = self.tail.len() - self.needed();
        if unneeded > Self::SPARE {
            self.tail.drain(..unneeded);
        }
    }

    /// How many values the last twentieth are.
    fn needed(&self) -> usize {
        self.count.div_ceil(20)
    }

    pub(crate) fn metrics(&self, target: f64) -> ForceMetrics {
        let tail = &self.tail[self.tail.len() - self.needed()..];
        let mean = tail.iter().sum::<f64>() / tail.len() as f64;
        ForceMetrics {
            target,
            settling_2: self.within_2.time(self.begin, self.end),
            settling_5: self.within_5.time(self.begin, self.end),
            overshoot: if self.way == 0.0 { 0.0 } else { 100.0 * self.beyond / self.way.abs() },
            steady_error: mean - target,
        }
    }
}

/// The largest of a number and a figure of each value, of which those that are no numbers do not count.
fn most(so_far: f64, values: &[f64], figure: impl Fn(f64) -> f64) -> f64 {
    // In two lanes of two, since each takes as long as several values.
    const LANES: usize = 4;
    let mut lanes = [so_far; LANES];
    let (blocks, rest) = values.as_chunks::<LANES>();
    for block in blocks {
        for (lane, value) in lanes.iter_mut().zip(block) {
            *lane = larger(*lane, figure(*value));
        }
    }
    rest.iter().map(|value| figure(*value)).chain(lanes).fold(so_far, larger)
}

/// The larger one of two numbers, the first one if the other is no number.
#[inline]
fn larger(one: f64, other: f64) -> f64 {
    if other > one { other } else { one }
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
    fn extend(&mut self, times: &[f64], values: &[f64], target: f64) {
        // An error that is no number is outside.
        let is_within = |value: &f64| (value - target).abs() <= self.band;
        let sample = |index: usize| Some((*times.get(index)?, *values.get(index)? - target));
        // Most samples are within; without a branch, the compiler looks at several at once.
        let are_within = values.iter().fold(true, |all, value| all & is_within(value));
        let last = if are_within { None } else { values.iter().rposition(|value| !is_within(value)) };
        if let Some(last) = last {
            (self.outside, self.next) = (sample(last), sample(last + 1));
        } else if self.next.is_none() {
            // Before anything is outside, this is of no account.
            self.next = sample(0);
        }
    }

    /// The time after which the error stays within the band, counted from the first sample: the time at which the line
    /// between the last sample outside and the next one crosses the band. `None` if the last sample outside is within the
    /// last [`REST`] of the time.
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

    #[test]
    fn pieces_give_what_the_whole_gives() {
        let times: Vec<f64> = (0..30_000_u32).map(|index| f64::from(index) * 1e-3).collect();
        let wave = |rate: f64| times.iter().map(|time| 0.5 + (-time).exp() * (rate * time).sin()).collect::<Vec<_>>();
        // Two targets, the second of which begins within a piece, and one that is no number.
        let target = |time: &f64| {
            if *time < 0.2 {
                f64::NAN
            } else if *time < 3.333 {
                0.4
            } else {
                0.5
            }
        };
        let columns = [wave(9.0), wave(11.0), times.iter().map(target).collect(), wave(2.0), wave(3.0), wave(5.0)];
        let limits = [Some(Limits { low: -0.5, high: 0.9 }), None, Some(Limits { low: 0.4, high: 2.0 })];
        let whole = |from: usize, to: usize| [0, 1, 2, 3, 4, 5].map(|index| &columns[index][from..to]);
        let mut once = Running::new(limits);
        once.extend(&times, whole(0, times.len()));
        for size in [1, 7, 128, 9999] {
            let mut pieces = Running::new(limits);
            for begin in (0..times.len()).step_by(size) {
                let end = times.len().min(begin + size);
                pieces.extend(&times[begin..end], whole(begin, end));
            }
            assert_eq!(pieces.metrics(), once.metrics());
        }
        let metrics = once.metrics().unwrap();
        assert!(metrics.settling_2().is_some() && metrics.efforts[0].saturated.unwrap() > 0.0);
        assert_eq!(Running::new(limits).metrics(), None);
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
