//! The rate of a measured signal, behind a low-pass.
//!
//! ω/(p + ω) ẋ = ω (x − x̄) with ẋ̄ = ω (x − x̄), so behind the low-pass the rate is the distance of the signal from its own filtered
//! value: the same equation, without the measured rate. Sampled it is better. When rigid bodies chatter, rates of strain change by hundreds
//! of N·m/s within a sample, and a filter of samples integrates whatever it happens to see; the signal itself has the
//! integral. It also answers a sample earlier.

use super::lowpass::LowPass;
use serde::{Deserialize, Serialize};

/// Rates of two signals, one per arm, behind a first-order low-pass; bandwidth 0 passes the measured rates through.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    filter: LowPass,
    /// The bandwidth from the next step on.
    following: f64,
}

/// Two signals with their measured rates, or the change of that.
#[derive(Debug, Clone, Copy)]
pub struct Signals {
    /// The signals.
    pub value: [f64; 2],
    /// Their rates \[1/s\].
    pub rate: [f64; 2],
}

impl Slope {
    /// Filters of `bandwidth` ω \[rad/s\], ≥ 0, of signals that rest at zero.
    #[must_use]
    pub const fn new(bandwidth: f64) -> Self {
        Self { filter: LowPass::new(bandwidth), following: bandwidth }
    }

    /// Changes the bandwidth with the next step. The rates do not jump: x̄ moves to where the new bandwidth gives the same ones, and that
    /// takes the signals, which a step knows.
    pub fn set_bandwidth(&mut self, bandwidth: f64) {
        self.following = bandwidth;
    }

    fn adopt(&mut self) {
        self.filter.set_bandwidth(self.following);
    }

    /// Adopts the new bandwidth, for signals that are at `value`. Filters that were off begin without a rate.
    #[cold]
    fn change(&mut self, value: [f64; 2]) {
        let kept = if self.is_on() && self.following > 0.0 { self.filter.bandwidth() / self.following } else { 0.0 };
        let filtered = self.filtered();
        self.adopt();
        self.filter.settle(std::array::from_fn(|i| value[i] - kept * (value[i] - filtered[i])));
    }

    /// Whether measured rates are replaced.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.filter.is_on()
    }

    /// Puts the filters where the rates are the measured ones.
    pub fn settle(&mut self, signals: Signals) {
        self.adopt();
        let Signals { value, rate } = signals;
        let lag = if self.is_on() { self.filter.bandwidth().recip() } else { 0.0 };
        self.filter.settle(std::array::from_fn(|i| value[i] - lag * rate[i]));
    }

    /// The rates now.
    #[must_use]
    #[inline]
    pub fn output(&self, signals: Signals) -> [f64; 2] {
        self.filter.output_rate(signals.value, signals.rate)
    }

    /// Change of the rates for a change of signals, and of filtered signals by `filtered`.
    #[must_use]
    pub fn output_change(&self, by: Signals, filtered: [f64; 2]) -> [f64; 2] {
        if self.is_on() {
            std::array::from_fn(|i| self.filter.bandwidth() * (by.value[i] - filtered[i]))
        } else {
            by.rate
        }
    }

    /// Time derivative of the filtered signals; 0 where they are not in use.
    #[must_use]
    pub fn filtered_rate(&self, value: [f64; 2]) -> [f64; 2] {
        self.filter.output_rate(value, [0.0; 2])
    }

    /// The filtered signals.
    #[must_use]
    pub fn filtered(&self) -> [f64; 2] {
        self.filter.output([0.0; 2])
    }

    /// Puts the filtered signals at `filtered`. They belong to somebody who integrates them, so a new bandwidth holds at once.
    pub fn take(&mut self, filtered: [f64; 2]) {
        if self.following != self.filter.bandwidth() {
            self.adopt();
        }
        self.filter.settle(filtered);
    }

    /// Advances the filters by `h` \[s\] for signals that start at `value` and change at `ramp`.
    #[inline]
    pub fn step(&mut self, h: f64, value: [f64; 2], ramp: [f64; 2]) {
        if self.following != self.filter.bandwidth() {
            self.change(value);
        }
        self.filter.step(h, value, ramp);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp's rate is found with the time constant, from a filter that knew it from the start without any delay.
    #[test]
    fn a_ramp_has_its_rate() {
        let (mut slope, mut ready) = (Slope::new(50.0), Slope::new(50.0));
        slope.settle(Signals { value: [1.0; 2], rate: [0.0; 2] });
        ready.settle(Signals { value: [1.0; 2], rate: [3.0, -2.0] });
        for step in 0..200 {
            let value = [1.0 + 3.0 * 1e-3 * f64::from(step), 1.0 - 2.0 * 1e-3 * f64::from(step)];
            let signals = Signals { value, rate: [9e9; 2] };
            let grown = 1.0 - (-50.0 * 1e-3 * f64::from(step)).exp();
            for (found, exact) in slope.output(signals).into_iter().zip([3.0 * grown, -2.0 * grown]) {
                assert!((found - exact).abs() < 1e-11, "{found} for {exact} in step {step}");
            }
            for (found, exact) in ready.output(signals).into_iter().zip([3.0, -2.0]) {
                assert!((found - exact).abs() < 1e-11, "{found} for {exact} in step {step}");
            }
            slope.step(1e-3, value, [3.0, -2.0]);
            ready.step(1e-3, value, [3.0, -2.0]);
        }
    }

    /// A new bandwidth changes how the rates go on, not what they are.
    #[test]
    fn rates_do_not_jump_with_the_bandwidth() {
        for bandwidth in [5.0, 500.0] {
            let mut slope = Slope::new(50.0);
            slope.settle(Signals { value: [0.3, 0.1], rate: [3.0, -2.0] });
            slope.step(1e-3, [0.4, 0.2], [0.0; 2]);
            let signals = Signals { value: [0.35, 0.25], rate: [9e9; 2] };
            let before = slope.output(signals);
            slope.set_bandwidth(bandwidth);
            assert_eq!(slope.output(signals), before);
            slope.step(1e-9, signals.value, [0.0; 2]);
            for (now, before) in slope.output(signals).into_iter().zip(before) {
                // It decays at the new bandwidth.
                assert!((now - before * (1.0 - 1e-9 * bandwidth)).abs() < 1e-12 * before.abs(), "{now} {before}");
            }
        }
    }

    #[test]
    fn bandwidth_zero_passes_rates_through() {
        let mut slope = Slope::new(0.0);
        slope.step(1e-3, [5.0; 2], [0.0; 2]);
        let signals = Signals { value: [1.0, 2.0], rate: [3.0, 4.0] };
        assert_eq!(slope.output(signals), [3.0, 4.0]);
        assert_eq!(slope.output_change(signals, [7.0; 2]), [3.0, 4.0]);
        assert!(!slope.is_on());
    }
}
