//! The actuator's own dynamics: a rate limit, followed by a first-order lag. Both are exact for commands that are held or
//! ramped: the output of the limiter is piecewise linear, and the lag is solved exactly for it.

use serde::{Deserialize, Serialize};

use crate::lag::lag;

/// A rate limit and a lag. Zero switches each off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Drive {
    /// Greatest rate \[unit of the command per second\].
    pub rate_limit: f64,
    /// Bandwidth of the lag \[rad/s\].
    pub bandwidth: f64,
    /// Where the limiter is.
    limited: f64,
    /// Where the lag is.
    lagged: f64,
}

impl Drive {
    /// A drive that has settled at this command.
    pub fn new(rate_limit: f64, bandwidth: f64, command: f64) -> Self {
        Self { rate_limit, bandwidth, limited: command, lagged: command }
    }

    /// Whether it does anything.
    pub fn is_on(&self) -> bool {
        self.rate_limit > 0.0 || self.bandwidth > 0.0
    }

    /// The present output.
    pub fn output(&self) -> f64 {
        if self.bandwidth > 0.0 { self.lagged } else { self.limited }
    }

    /// Time derivative of the output, for a command that changes at `rate`.
    pub fn output_rate(&self, command: f64, rate: f64) -> f64 {
        if self.bandwidth > 0.0 {
            let input = if self.rate_limit > 0.0 { self.limited } else { command };
            self.bandwidth * (input - self.lagged)
        } else if command == self.limited {
            rate.clamp(-self.rate_limit, self.rate_limit)
        } else {
            self.rate_limit.copysign(command - self.limited)
        }
    }

    /// Follows a command that starts at `command` and changes at `rate`, for `time` \[s\].
    pub fn follow(&mut self, command: f64, rate: f64, time: f64) {
        if self.rate_limit == 0.0 {
            self.limited = command;
            return self.go(rate, time);
        }
        let gap = command - self.limited;
        let mut rest = time;
        if gap != 0.0 {
            let speed = self.rate_limit.copysign(gap);
            let meeting = gap / (speed - rate);
            // Negative or infinite: the command runs away.
            if !(meeting > 0.0 && meeting < time) {
                return self.go(speed, time);
            }
            self.go(speed, meeting);
            self.limited = command + rate * meeting;
            rest -= meeting;
        }
        self.go(rate.clamp(-self.rate_limit, self.rate_limit), rest);
    }

    /// Moves the limiter at `rate` for `time`, and the lag behind it.
    fn go(&mut self, rate: f64, time: f64) {
        if self.bandwidth > 0.0 {
            self.lagged = lag(self.bandwidth, self.lagged, self.limited, rate, time);
        }
        // Adding zero would turn −0 into +0.
        if rate != 0.0 {
            self.limited += rate * time;
        }
    }

    /// Whether it has the settings of another one, and numbers that are finite.
    pub fn is_sound(&self, like: &Self) -> bool {
        let settings = (self.rate_limit, self.bandwidth) == (like.rate_limit, like.bandwidth);
        settings && self.is_finite()
    }

    /// Whether its numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.limited.is_finite() && self.lagged.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_limiter_meets_a_held_command_and_stays() {
        let mut drive = Drive::new(2.0, 0.0, 0.0);
        drive.follow(1.0, 0.0, 0.25);
        assert_eq!((drive.output(), drive.output_rate(1.0, 0.0)), (0.5, 2.0));
        drive.follow(1.0, 0.0, 10.0);
        assert_eq!((drive.output(), drive.output_rate(1.0, 0.0)), (1.0, 0.0));
        drive.follow(-1.0, 0.0, 0.5);
        assert_eq!((drive.output(), drive.output_rate(-1.0, 0.0)), (0.0, -2.0));
    }

    #[test]
    fn a_command_that_is_too_fast_runs_away() {
        let mut drive = Drive::new(2.0, 0.0, 0.0);
        drive.follow(0.0, 5.0, 0.1);
        assert_eq!(drive.output(), 0.2);
        // Towards the limiter it is met: 0.5 − 5 t = 0.2 + 2 t.
        drive.follow(0.5, -5.0, 0.1);
        let meeting = 0.2 + 2.0 * 0.3 / 7.0;
        assert!((drive.output() - (meeting - 2.0 * (0.1 - 0.3 / 7.0))).abs() < 1e-15);
    }

    proptest! {
        /// However a step is divided, the drive is where it was: limiter and lag are exact.
        #[test]
        fn two_parts_are_one_step(
            limit in 0.1..50.0_f64, bandwidth in prop_oneof![Just(0.0), 1.0..500.0_f64], start in -1.0..1.0_f64,
            command in -1.0..1.0_f64, rate in prop_oneof![Just(0.0), -20.0..20.0_f64], time in 1e-3..0.2_f64, part in 0.05..0.95_f64,
        ) {
            let mut once = Drive::new(limit, bandwidth, start);
            let mut twice = once;
            once.follow(command, rate, time);
            twice.follow(command, rate, part * time);
            twice.follow(command + rate * part * time, rate, time - part * time);
            prop_assert!((once.output() - twice.output()).abs() < 1e-12);
        }

        /// Comparison with ten thousand Euler steps, whose error is of first order.
        #[test]
        fn the_lag_follows_the_limiter(limit in 0.5..20.0_f64, bandwidth in 1.0..100.0_f64, command in -1.0..1.0_f64) {
            let mut drive = Drive::new(limit, bandwidth, 0.0);
            drive.follow(command, 0.0, 0.1);
            let (mut limited, mut lagged, h) = (0.0_f64, 0.0, 1e-5);
            for _ in 0..10_000 {
                lagged += h * bandwidth * (limited - lagged);
                limited += (command - limited).clamp(-limit * h, limit * h);
            }
            prop_assert!((drive.output() - lagged).abs() < bandwidth * limit * 0.1 * h + 1e-12);
        }
    }
}
