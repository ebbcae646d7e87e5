//! The path of one command: inverse of the dead zone, sampling, delay, rate limit, lag.
//!
//! The inverse belongs to the control software, so it comes first. The later parts delay and smooth its jump at zero, as in
//! a real drive.

use parameter_table::{Owner, Parameter, Range, check_of, parameter};
use serde::{Deserialize, Serialize};

use crate::clock::SampleClock;
use crate::dead_zone::DeadZone;
use crate::delay::DelayLine;
use crate::drive::Drive;
use crate::sensor::{TIME, check_sampling};
use crate::setting::SettingError;

/// So many samples of a command are taken in one step at most; more of them would keep a host waiting.
pub const MOST_SAMPLES: u64 = 1_000_000;

/// The effects on a command. Zero switches each of them off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CommandSettings {
    /// Time between two samples \[s\]; without, commands go on at every moment.
    pub sample_time: f64,
    /// Time from a sample until it is sent \[s\]. Needs a sample time.
    pub delay: f64,
    /// Largest rate of the sent command \[unit of the command per second\].
    pub rate_limit: f64,
    /// Bandwidth of a first-order lag behind the rate limit \[rad/s\].
    pub bandwidth: f64,
    /// The dead zone whose inverse is applied first.
    pub inverse: Option<DeadZone>,
}

impl CommandSettings {
    /// The numbers that each [command](crate::actuation::Command) has of its own.
    pub const PARAMETERS: [Parameter<Self>; 3] = [
        parameter!("{}_delay", "s", TIME, "Time from a sample until it is sent of {}", delay),
        parameter!("{}_rate_limit", "{}/s", Range::new(0.0, 1e9), "Greatest rate (0: any) of {}", rate_limit),
        parameter!(
            "{}_bandwidth",
            "rad/s",
            Range::new(0.0, 1e9),
            "Bandwidth of the first-order lag (0: none) behind the rate limit of {}",
            bandwidth
        ),
    ];

    /// Checks the settings of the command of that name.
    ///
    /// # Errors
    /// The first setting that cannot be used, with what to do.
    pub fn check(&self, command: &str) -> Result<(), SettingError> {
        check_of(Owner::named(command), &Self::PARAMETERS, self)?;
        if self.sample_time > 0.0 {
            check_sampling(command, self.sample_time, self.delay)
        } else if self.delay > 0.0 {
            Err(SettingError::unfit(format!("{command}_delay"), self.delay, "it delays samples; set sample_time"))
        } else {
            Ok(())
        }
    }
}

/// Why a step cannot be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StepError {
    /// Too many samples.
    #[error(
        "the step takes {0} samples of a command, at most {MOST_SAMPLES} are possible; take shorter steps or a longer sample_time"
    )]
    Samples(u64),
    /// Too late.
    #[error("only 2^53 samples can be counted; take a longer sample_time")]
    Count,
    /// A number has left the range of doubles.
    #[error("a signal is no longer finite; its input is too large")]
    NotFinite,
}

/// The way of a command and its state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommandPath {
    inverse: Option<DeadZone>,
    samples: Option<Samples>,
    drive: Drive,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Samples {
    clock: SampleClock,
    delay: f64,
    line: DelayLine,
    /// The index that is being sent, and its value.
    sent: (u64, f64),
}

impl CommandPath {
    /// The path with [checked](CommandSettings::check) settings, whose input was constantly `command` until `start` \[s\].
    #[must_use]
    pub fn new(settings: &CommandSettings, start: f64, command: f64) -> Self {
        let first = settings.inverse.map_or(command, |zone| zone.inverse(command));
        let samples = (settings.sample_time > 0.0).then(|| Samples {
            clock: SampleClock { start, period: settings.sample_time },
            delay: settings.delay,
            line: DelayLine::new(settings.delay, settings.sample_time, first),
            sent: (0, first),
        });
        Self { inverse: settings.inverse, samples, drive: Drive::new(settings.rate_limit, settings.bandwidth, first) }
    }

    /// The present input of the actuator, while the controller commands `command`.
    #[must_use]
    pub fn output(&self, command: f64) -> f64 {
        if self.drive.is_on() { self.drive.output() } else { self.before_drive(command) }
    }

    /// Time derivative of [`output`](Self::output), while the command changes at `rate`, without jumps.
    #[must_use]
    pub fn output_rate(&self, command: f64, rate: f64) -> f64 {
        let rate = if self.samples.is_some() { 0.0 } else { rate * self.slope(command) };
        if self.drive.is_on() { self.drive.output_rate(self.before_drive(command), rate) } else { rate }
    }

    /// Derivative of [`output`](Self::output) by the command.
    #[must_use]
    pub fn feedthrough(&self, command: f64) -> f64 {
        if self.samples.is_some() || self.drive.is_on() { 0.0 } else { self.slope(command) }
    }

    fn slope(&self, command: f64) -> f64 {
        self.inverse.map_or(1.0, |zone| zone.inverse_slope(command))
    }

    fn before_drive(&self, command: f64) -> f64 {
        self.samples.as_ref().map_or_else(|| self.inverted(command), |samples| samples.sent.1)
    }

    fn inverted(&self, command: f64) -> f64 {
        self.inverse.map_or(command, |zone| zone.inverse(command))
    }

    /// Advances by `size` from `time` \[s\], for a command that starts at `command` and changes at `rate`.
    ///
    /// # Errors
    /// When a number leaves its range. The state is then invalid.
    pub fn step(&mut self, time: f64, size: f64, command: f64, rate: f64) -> Result<(), StepError> {
        if self.samples.is_some() {
            self.step_sampled(time, size, command, rate)?;
        } else if self.drive.is_on() {
            self.step_continuous(size, command, rate);
        }
        if self.is_finite() { Ok(()) } else { Err(StepError::NotFinite) }
    }

    fn step_continuous(&mut self, size: f64, command: f64, rate: f64) {
        let Some(zone) = self.inverse.filter(|_| rate != 0.0) else {
            return self.drive.follow(self.inverted(command), rate, size);
        };
        let mut rest = size;
        let crossing = -command / rate;
        let mut from = self.inverted(command);
        if command == 0.0 || (0.0 < crossing && crossing < size) {
            let before = crossing.max(0.0);
            self.drive.follow(from, rate * zone.inverse_slope(command), before);
            rest -= before;
            from = zone.beside_zero(rate > 0.0);
            self.drive.follow(from, rate * zone.inverse_slope(rate), rest);
        } else {
            self.drive.follow(from, rate * zone.inverse_slope(command), rest);
        }
    }

    fn step_sampled(&mut self, time: f64, size: f64, command: f64, rate: f64) -> Result<(), StepError> {
        let (inverse, Some(samples)) = (self.inverse, &mut self.samples) else { return Ok(()) };
        let (clock, delay, end) = (samples.clock, samples.delay, time + size);
        if !clock.reaches(end) {
            return Err(StepError::Count);
        }
        let newest = clock.newest(end);
        let count = newest.saturating_sub(samples.line.newest());
        if count > MOST_SAMPLES {
            return Err(StepError::Samples(count));
        }
        let take = |samples: &mut Samples, index: u64| {
            let since = (clock.instant(index) - time).clamp(0.0, size);
            let value = if rate == 0.0 { command } else { command + rate * since };
            samples.line.push(index, inverse.map_or(value, |zone| zone.inverse(value)));
        };
        // Between two arrivals the drive sees one command; a sample is taken before it arrives.
        let mut done = 0.0;
        for index in samples.sent.0 + 1..=clock.newest(end - delay) {
            while samples.line.newest() < index {
                let next = samples.line.newest() + 1;
                take(samples, next);
            }
            let arrival = (clock.instant(index) + delay - time).clamp(done, size);
            self.drive.follow(samples.sent.1, 0.0, arrival - done);
            done = arrival;
            samples.sent = (index, samples.line.get(index));
        }
        self.drive.follow(samples.sent.1, 0.0, size - done);
        for index in samples.line.newest() + 1..=newest {
            take(samples, index);
        }
        Ok(())
    }

    fn is_finite(&self) -> bool {
        self.drive.is_finite() && self.samples.as_ref().is_none_or(|samples| samples.sent.1.is_finite())
    }

    /// Whether a way that was read from somewhere is in a state this one can get into.
    #[must_use]
    pub fn is_sound(&self, like: &Self) -> bool {
        let samples = match (&self.samples, &like.samples) {
            (None, None) => true,
            (Some(samples), Some(other)) => {
                (samples.clock, samples.delay) == (other.clock, other.delay)
                    && samples.line.is_sound(&other.line)
                    && samples.sent.0 <= samples.line.newest()
            }
            _ => false,
        };
        samples && self.inverse == like.inverse && self.drive.is_sound(&like.drive) && self.is_finite()
    }
}
