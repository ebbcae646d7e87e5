//! Equally spaced instants, found again whatever the steps that lead to them.

use serde::{Deserialize, Serialize};

/// The instants start + k · period, k = 0, 1, 2, …
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampleClock {
    /// The instant of k = 0 \[s\].
    pub start: f64,
    /// Time between two instants \[s\], positive.
    pub period: f64,
}

impl SampleClock {
    /// The least period \[s\].
    pub const SHORTEST: f64 = 1e-6;
    /// Instants can be counted up to here: all integers below are doubles.
    pub(crate) const MOST: u64 = 1 << 53;
    /// A host computes times as sums or products, so they miss an instant by some rounding errors. Deviations below this
    /// part of a period are ignored.
    const SLACK: f64 = 1e-6;

    /// The newest instant at `time`; the first one before the start.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // saturates, and negative numbers become 0
    pub fn newest(&self, time: f64) -> u64 {
        let rounding = 16.0 * f64::EPSILON * (time.abs() + self.start.abs()) / self.period;
        ((time - self.start) / self.period + Self::SLACK + rounding).floor() as u64
    }

    /// When that instant is \[s\].
    #[must_use]
    pub fn instant(&self, index: u64) -> f64 {
        self.start + index as f64 * self.period
    }

    /// Whether instants can still be counted at `time`.
    #[must_use]
    pub fn reaches(&self, time: f64) -> bool {
        (time - self.start) / self.period < Self::MOST as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// By products and by sums, in steps that divide the period or not.
        #[test]
        fn every_instant_is_found_at_its_time(start in -10.0..10.0_f64, period in 1e-5..1.0_f64, k in 0_u32..20_000) {
            let clock = SampleClock { start, period };
            let time = start + f64::from(k) * period;
            prop_assert_eq!(clock.newest(time), u64::from(k));
            prop_assert_eq!(clock.newest(time + 0.999 * period), u64::from(k));
            let sum = (0..k).fold(start, |time, _| time + period);
            prop_assert_eq!(clock.newest(sum), u64::from(k));
        }
    }

    #[test]
    fn before_the_start_there_is_only_the_first() {
        let clock = SampleClock { start: 5.0, period: 0.1 };
        assert_eq!((clock.newest(-3.0), clock.newest(5.05)), (0, 0));
        assert!(clock.reaches(1e9) && !clock.reaches(1e300));
    }
}
