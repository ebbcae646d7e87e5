//! One sensor: low-pass, sampling with bias and noise, quantisation, delay.

use parameter_table::{Owner, Parameter, Range, check_of, parameter};
use serde::{Deserialize, Serialize};

use crate::clock::SampleClock;
use crate::delay::{DelayLine, LONGEST_LINE};
use crate::lag::lag;
use crate::normal::Stream;
use crate::setting::SettingError;

/// Beyond so many steps of a quantiser, a double is coarser than they are.
const FINEST: f64 = (1_u64 << 52) as f64;

/// Admissible numbers of a signal, and times [s].
const NUMBER: Range = Range::new(0.0, 1e9);
pub(crate) const TIME: Range = Range::new(0.0, 1e6);

/// The effects of a sensor on its signal. Zero switches each of them off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorSettings {
    /// Standard deviation of the white noise in each sample \[unit of the signal\]. Needs a sample time.
    pub noise: f64,
    /// Constant added to the signal \[unit of the signal\].
    pub bias: f64,
    /// Distance of the values that can be shown, multiples of this one \[unit of the signal\].
    pub lsb: f64,
    /// Bandwidth of a first-order low-pass before the sampler \[rad/s\].
    pub bandwidth: f64,
    /// Time from a sample until it is shown \[s\]. Needs a sample time.
    pub delay: f64,
    /// Time between two samples \[s\]; without, the signal is shown at every moment.
    pub sample_time: f64,
    /// There is no such sensor: it shows 0.
    pub absent: bool,
}

impl Default for SensorSettings {
    fn default() -> Self {
        Self::OFF
    }
}

impl SensorSettings {
    /// A sensor that shows its signal as it is.
    pub const OFF: Self =
        Self { noise: 0.0, bias: 0.0, lsb: 0.0, bandwidth: 0.0, delay: 0.0, sample_time: 0.0, absent: false };

    /// The numbers among them, each of a [`Signal`](crate::Signal).
    pub const PARAMETERS: [Parameter<Self>; 6] = [
        parameter!("{}_noise", "{}", NUMBER, "Standard deviation of the white noise in each sample of {}", noise),
        parameter!("{}_bias", "{}", Range::new(-1e9, 1e9), "What is added to {}", bias),
        parameter!("{}_lsb", "{}", NUMBER, "Distance of the values that can be shown (0: all) of {}", lsb),
        parameter!(
            "{}_bandwidth",
            "rad/s",
            NUMBER,
            "Bandwidth of the first-order low-pass (0: none) before the sampler of {}",
            bandwidth
        ),
        parameter!("{}_delay", "s", TIME, "Time from a sample until it is shown of {}", delay),
        parameter!("{}_sample_time", "s", TIME, "Time between two samples (0: sample_time) of {}", sample_time),
    ];

    /// Checks the settings of the signal of that name.
    ///
    /// # Errors
    /// The first setting that cannot be used, with what to do.
    pub fn check(&self, signal: &str) -> Result<(), SettingError> {
        check_of(Owner::named(signal), &Self::PARAMETERS, self)?;
        let Self { noise, delay, sample_time, .. } = *self;
        if sample_time == 0.0 {
            let needy = [
                ("_noise", noise, "white noise has a standard deviation only at a rate"),
                ("_delay", delay, "it delays samples"),
            ];
            return match needy.into_iter().find(|(_, value, _)| *value > 0.0) {
                None => Ok(()),
                Some((suffix, value, why)) => {
                    let reason = format_args!("{why}; set sample_time or {signal}_sample_time");
                    Err(SettingError::unfit(format!("{signal}{suffix}"), value, reason))
                }
            };
        }
        check_sampling(signal, sample_time, delay)
    }
}

/// Checks a positive sample time, and a delay with it.
pub(crate) fn check_sampling(signal: &str, sample_time: f64, delay: f64) -> Result<(), SettingError> {
    if sample_time < SampleClock::SHORTEST {
        let reason = format_args!("it must be 0 or at least {:e} s", SampleClock::SHORTEST);
        return Err(SettingError::unfit(format!("{signal}_sample_time"), sample_time, reason));
    }
    if delay / sample_time > LONGEST_LINE as f64 {
        let reason = format_args!("it must be at most {LONGEST_LINE} sample times of {sample_time} s");
        return Err(SettingError::unfit(format!("{signal}_delay"), delay, reason));
    }
    Ok(())
}

/// A sensor and its state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensor {
    settings: SensorSettings,
    stream: Stream,
    /// The low-pass; without one, nothing.
    filtered: f64,
    samples: Option<Samples>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Samples {
    clock: SampleClock,
    line: DelayLine,
    shown: f64,
}

impl Sensor {
    /// A sensor with [checked](SensorSettings::check) settings, whose input was constantly `input` until `start` \[s\]. Its
    /// noise comes from `stream`.
    #[must_use]
    pub fn new(settings: SensorSettings, stream: Stream, start: f64, input: f64) -> Self {
        let mut sensor = Self { settings, stream, filtered: input, samples: None };
        if settings.sample_time > 0.0 && !settings.absent {
            let first = sensor.reading(0, input);
            let line = DelayLine::new(settings.delay, settings.sample_time, first);
            let clock = SampleClock { start, period: settings.sample_time };
            sensor.samples = Some(Samples { clock, line, shown: first });
        }
        sensor
    }

    /// The present output of the sensor for the input `input`.
    #[must_use]
    pub fn output(&self, input: f64) -> f64 {
        match &self.samples {
            _ if self.settings.absent => 0.0,
            Some(samples) => samples.shown,
            None if self.settings.bandwidth > 0.0 => self.quantised(self.biased(self.filtered)),
            None => self.quantised(self.biased(input)),
        }
    }

    /// Time derivative of [`output`](Self::output), while the input changes at `rate`, without steps.
    #[must_use]
    pub fn output_rate(&self, input: f64, rate: f64) -> f64 {
        let SensorSettings { absent, lsb, bandwidth, .. } = self.settings;
        if absent || self.samples.is_some() || lsb > 0.0 {
            0.0
        } else if bandwidth > 0.0 {
            bandwidth * (input - self.filtered)
        } else {
            rate
        }
    }

    /// Derivative of [`output`](Self::output) by the input, 1 or 0.
    #[must_use]
    pub fn feedthrough(&self) -> f64 {
        let SensorSettings { absent, lsb, bandwidth, .. } = self.settings;
        f64::from(u8::from(!absent && self.samples.is_none() && lsb == 0.0 && bandwidth == 0.0))
    }

    /// Goes on by `size` from `time` \[s\], for an input that starts at `input` and changes at `rate`.
    pub fn step(&mut self, time: f64, size: f64, input: f64, rate: f64) {
        if let Some(samples) = &self.samples {
            let newest = samples.clock.newest(time + size);
            for index in samples.line.first_to_take(newest)..=newest {
                self.sample(index, time, size, input, rate);
            }
            if let Some(Samples { clock, line, shown }) = &mut self.samples {
                *shown = line.get(clock.newest(time + size - self.settings.delay));
            }
        }
        if self.settings.bandwidth > 0.0 {
            self.filtered = lag(self.settings.bandwidth, self.filtered, input, rate, size);
        }
    }

    /// Takes the sample of that index, in a step.
    fn sample(&mut self, index: u64, time: f64, size: f64, input: f64, rate: f64) {
        let Some(samples) = &self.samples else { return };
        let since = (samples.clock.instant(index) - time).clamp(0.0, size);
        let signal = if self.settings.bandwidth > 0.0 {
            lag(self.settings.bandwidth, self.filtered, input, rate, since)
        } else if rate == 0.0 {
            input
        } else {
            input + rate * since
        };
        let reading = self.reading(index, signal);
        if let Some(samples) = &mut self.samples {
            samples.line.push(index, reading);
        }
    }

    /// The signal with bias, noise and quantisation, as sampled.
    fn reading(&self, index: u64, signal: f64) -> f64 {
        let noise = self.settings.noise;
        let biased = self.biased(signal);
        self.quantised(if noise > 0.0 { biased + noise * self.stream.deviate(index) } else { biased })
    }

    fn biased(&self, signal: f64) -> f64 {
        // Adding zero would turn −0 into +0.
        if self.settings.bias == 0.0 { signal } else { signal + self.settings.bias }
    }

    fn quantised(&self, value: f64) -> f64 {
        let lsb = self.settings.lsb;
        let steps = value / lsb;
        if lsb > 0.0 && steps.abs() < FINEST { lsb * steps.round() } else { value }
    }

    /// Whether time can go on to `time` \[s\]: samples are counted in whole numbers.
    #[must_use]
    pub fn reaches(&self, time: f64) -> bool {
        self.samples.as_ref().is_none_or(|samples| samples.clock.reaches(time))
    }

    /// Whether its numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.filtered.is_finite() && self.samples.as_ref().is_none_or(|samples| samples.shown.is_finite())
    }

    /// Whether a sensor that was read from somewhere is in a state this one can get into.
    #[must_use]
    pub fn is_sound(&self, like: &Self) -> bool {
        let samples = match (&self.samples, &like.samples) {
            (None, None) => true,
            (Some(samples), Some(other)) => samples.clock == other.clock && samples.line.is_sound(&other.line),
            _ => false,
        };
        samples && self.settings == like.settings && self.stream == like.stream && self.is_finite()
    }
}
