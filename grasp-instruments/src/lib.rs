//! Sensors for the signals of the grasp, and the paths of the commands to the actuators.
//!
//! A [`Sensor`] is a low-pass, a sampler that adds bias and noise, a quantiser and a delay; [`Instruments`] are one sensor
//! for each signal that a controller measures. A [`CommandPath`] is the inverse of a dead zone, a sampler, a delay, a rate
//! limit and a lag; an [`Actuation`] is one path for each command. With the default settings both pass every signal on bit
//! for bit.
//!
//! ```
//! use grasp_instruments::{Sensor, SensorSettings, Stream};
//! let settings = SensorSettings { sample_time: 1e-3, lsb: 0.01, ..SensorSettings::OFF };
//! let mut encoder = Sensor::new(settings, Stream { seed: 1, number: 0 }, 0.0, 0.123);
//! assert_eq!(encoder.output(0.987), 0.12); // holds what it sampled at the start
//! encoder.step(0.0, 1e-3, 0.987, 0.0);
//! assert_eq!(encoder.output(0.0), 0.99);
//! ```
//!
//! **Samples.** Sampling instants are t₀ + k T, whatever the steps: noise has the same spectrum, and the same values, for
//! every step size. A step from t to t + h takes the samples in (t, t + h], of inputs that are held or ramped over the
//! step.
//!
//! **Noise.** The k-th sample of a signal has the deviate Φ⁻¹(u), with u from the k-th block of a counter-based generator
//! ([`philox`]): a pure function of seed, signal and k. So k is the only random state, a repeated step repeats its noise,
//! and the noises of different signals are independent. The values do not depend on the machine: they use integers, and
//! IEEE arithmetic in a fixed order.

#![allow(clippy::float_cmp)]

pub mod actuation;
pub mod clock;
pub mod dead_zone;
mod delay;
mod drive;
pub mod instruments;
mod lag;
pub mod normal;
mod path;
pub mod philox;
pub mod profiles;
mod sensor;
mod setting;

pub use actuation::{Actuation, ActuationSettings};
pub use delay::LONGEST_LINE;
pub use instruments::{InstrumentSettings, Instruments, SIGNALS, Signal, Signals};
pub use normal::Stream;
pub use path::{CommandPath, CommandSettings, MOST_SAMPLES, StepError};
pub use sensor::{Sensor, SensorSettings};
pub use setting::SettingError;
