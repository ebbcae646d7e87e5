//! What an actuator did: its largest output, the root mean square, and the time at its limits.

use super::{larger, most};
use crate::metrics::{EffortMetrics, Limits};

/// One actuator's output; between samples it is a straight line.
#[derive(Debug, Clone)]
pub(crate) struct Effort {
    has_limits: bool,
    /// From where on it counts as being at a limit.
    limits: Limits,
    seen: Option<Seen>,
}

/// What an [`Effort`] has seen.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// The first sample: time and value.
    begin: (f64, f64),
    sums: Sums,
    /// The last sample.
    last: (f64, f64),
}

/// So many samples are looked at together: the compiler does the same for two of them at once.
const SAMPLES: usize = 16;

/// The sums from the first sample to the last one.
#[derive(Debug, Clone, Copy)]
struct Sums {
    peak: f64,
    energy: f64,
    at_limits: f64,
}

impl Sums {
    /// Adds the lines from the last sample over the next ones. The terms of a sum are made together, and added in their order.
    #[inline]
    fn add<const N: usize>(
        &mut self,
        Limits { low, high }: Limits,
        last: &mut (f64, f64),
        times: &[f64; N],
        values: &[f64; N],
    ) {
        // Numbers instead of truth values, and arrays that begin a sample earlier: then the compiler looks at two samples at once.
        let is = |truth: bool| if truth { 1.0 } else { 0.0 };
        let is_at_limit = |value: f64| larger(is(value >= high), is(value <= low));
        let (mut from, mut a, mut was) = ([last.0; N], [last.1; N], [is_at_limit(last.1); N]);
        let now = values.map(is_at_limit);
        from[1..].copy_from_slice(&times[..N - 1]);
        a[1..].copy_from_slice(&values[..N - 1]);
        was[1..].copy_from_slice(&now[..N - 1]);
        let (mut energy, mut at_limits) = ([0.0; N], [0.0; N]);
        for index in 0..N {
            let (dt, a, b) = (times[index] - from[index], a[index], values[index]);
            // ∫ of the square of a straight line from a to b: (a² + ab + b²)/3.
            energy[index] = dt * (a * a + a * b + b * b) / 3.0;
            at_limits[index] = dt * 0.5 * (was[index] + now[index]);
        }
        for (energy, at_limits) in energy.into_iter().zip(at_limits) {
            self.energy += energy;
            self.at_limits += at_limits;
        }
        *last = (times[N - 1], values[N - 1]);
    }
}

impl Default for Effort {
    fn default() -> Self {
        Self::new(None)
    }
}

impl Effort {
    pub(crate) fn new(limits: Option<Limits>) -> Self {
        let slack = limits.map_or(0.0, |Limits { low, high }| 1e-9 * (high - low));
        let Limits { low, high } = limits.unwrap_or(Limits { low: f64::NEG_INFINITY, high: f64::INFINITY });
        Self { has_limits: limits.is_some(), limits: Limits { low: low + slack, high: high - slack }, seen: None }
    }

    pub(crate) fn extend(&mut self, times: &[f64], values: &[f64]) {
        let (Some(time), Some(value)) = (times.first(), values.first()) else { return };
        // A sum of nothing is −0.
        let nothing = Sums { peak: 0.0, energy: -0.0, at_limits: -0.0 };
        let begin = Seen { begin: (*time, *value), sums: nothing, last: (*time, *value) };
        let is_first = usize::from(self.seen.is_none());
        let Seen { sums, last, .. } = self.seen.get_or_insert(begin);
        sums.peak = most(sums.peak, values, f64::abs);
        let (times, values) = (&times[is_first..], &values[is_first..]);
        let ((time_blocks, other_times), (value_blocks, other_values)) = (times.as_chunks(), values.as_chunks());
        for (times, values) in time_blocks.iter().zip(value_blocks) {
            sums.add::<SAMPLES>(self.limits, last, times, values);
        }
        for (time, value) in other_times.iter().zip(other_values) {
            sums.add(self.limits, last, &[*time], &[*value]);
        }
    }

    pub(crate) fn metrics(&self) -> Option<EffortMetrics> {
        let Seen { begin: (begin, first), sums, last: (end, _) } = self.seen?;
        let duration = end - begin;
        Some(EffortMetrics {
            peak: sums.peak,
            rms: if duration > 0.0 { (sums.energy / duration).sqrt() } else { first.abs() },
            saturated: self.has_limits.then_some(sums.at_limits),
        })
    }
}
