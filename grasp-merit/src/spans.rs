//! How long a signal is what it should not be.

use crate::metrics::REST;

/// Length in s of the windows of [`quiet`]: fifty samples at 1 kHz.
pub const WINDOW: f64 = 0.05;

/// Time in s after which the rms error of the next [`WINDOW`] stays below a band; `None` if this lasts for less than [`REST`] of
/// the run.
#[must_use]
pub fn quiet(times: &[f64], values: &[f64], target: f64, band: f64) -> Option<f64> {
    let mut sums = Vec::with_capacity(values.len() + 1);
    sums.push(0.0);
    for value in values {
        sums.push(sums[sums.len() - 1] + (value - target).powi(2));
    }
    let end = *times.last()?;
    let mut after = times.len();
    for first in (0..times.len()).rev() {
        while after > first + 1 && times[after - 1] > times[first] + WINDOW {
            after -= 1;
        }
        let rms = ((sums[after] - sums[first]) / (after - first) as f64).sqrt();
        if rms > band || rms.is_nan() {
            let settled = times[first] <= end - (REST * (end - times[0])).max(WINDOW);
            return settled.then_some(times[first] - times[0]);
        }
    }
    Some(0.0)
}

/// How long in s a force is below `-limit`.
#[must_use]
pub fn pulling(times: &[f64], force: &[f64], limit: f64) -> f64 {
    let pulls = |value: f64| 0.5 * f64::from(u8::from(value < -limit));
    times.windows(2).zip(force.windows(2)).map(|(t, f)| (t[1] - t[0]) * (pulls(f[0]) + pulls(f[1]))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rings_below_the_band_is_quiet_although_it_crosses_it() {
        let times: Vec<f64> = (0..=4000).map(|index| f64::from(index) * 1e-3).collect();
        // Decays by e every 0.2 s, and noise of rms 0.007 that sometimes exceeds the band of 0.01.
        let noise = |t: f64| 0.01 * (1000.0 * t).sin();
        let values: Vec<f64> = times.iter().map(|t| 0.5 * (1.0 - (-t / 0.2).exp()) + noise(*t)).collect();
        let settled = quiet(&times, &values, 0.5, 0.01).unwrap();
        // 0.5·exp(−t/0.2) and noise have an rms of 0.01 where the first is 0.00707: at 0.2·ln(0.5/0.00707) = 0.852 s; the
        // window looks 50 ms ahead.
        assert!((0.80..0.86).contains(&settled), "{settled}");
        assert_eq!(quiet(&times, &values, 0.4, 0.01), None);
        assert_eq!(pulling(&times, &vec![-1.0; times.len()], 0.5), 4.0);
    }
}
