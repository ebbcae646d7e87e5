//! The sensors of the grasp.

use parameter_table::{Owner, Parameter, Range, check, parameter};
use serde::{Deserialize, Serialize};

use crate::normal::Stream;
use crate::path::StepError;
use crate::sensor::{Sensor, SensorSettings, TIME};
use crate::setting::SettingError;

/// Number of measured signals.
pub const COUNT: usize = 14;

/// Values of all measured signals, in the order of [`SIGNALS`].
pub type Signals = [f64; COUNT];

/// A measured signal.
#[derive(Clone, Copy, Debug)]
pub struct Signal {
    /// Name in the interfaces of plant and controllers.
    pub name: &'static str,
    /// SI unit in FMI's notation.
    pub unit: &'static str,
    /// Order of magnitude.
    pub nominal: f64,
    /// Its description.
    pub description: &'static str,
    /// Whether it is the time derivative of another one, which few machines measure.
    pub is_rate: bool,
}

impl Signal {
    /// The texts for it in the [table of its sensor](SensorSettings::PARAMETERS).
    #[must_use]
    pub const fn owner(&self) -> Owner<'static> {
        Owner { name: self.name, unit: self.unit, called: self.name }
    }
}

/// The measured signals, in the order of the plant's outputs. A signal's place is the number of its noise.
pub const SIGNALS: [Signal; COUNT] = [
    signal("theta1", "rad", 0.1, "angle of hub 1", false),
    signal("theta2", "rad", 0.1, "angle of hub 2", false),
    signal("theta1_dot", "rad/s", 1.0, "angular velocity of hub 1", true),
    signal("theta2_dot", "rad/s", 1.0, "angular velocity of hub 2", true),
    signal("y_object", "m", 0.05, "position of the object", false),
    signal("y_object_dot", "m/s", 0.1, "velocity of the object", true),
    signal("root_moment1", "N.m", 0.1, "bending moment at the root of arm 1", false),
    signal("root_moment2", "N.m", 0.1, "bending moment at the root of arm 2", false),
    signal("tip_shear1", "N", 1.0, "shear force at the tip of arm 1", false),
    signal("tip_shear2", "N", 1.0, "shear force at the tip of arm 2", false),
    signal("tip_shear1_dot", "N/s", 10.0, "rate of the shear force at the tip of arm 1", true),
    signal("tip_shear2_dot", "N/s", 10.0, "rate of the shear force at the tip of arm 2", true),
    signal("root_moment1_dot", "N.m/s", 10.0, "rate of the bending moment at the root of arm 1", true),
    signal("root_moment2_dot", "N.m/s", 10.0, "rate of the bending moment at the root of arm 2", true),
];

const fn signal(
    name: &'static str,
    unit: &'static str,
    nominal: f64,
    description: &'static str,
    is_rate: bool,
) -> Signal {
    Signal { name, unit, nominal, description, is_rate }
}

/// Settings of all sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstrumentSettings {
    /// Of each.
    pub sensors: [SensorSettings; COUNT],
    /// Sample time of the sensors without a sample time of their own \[s\]; 0: none.
    pub sample_time: f64,
    /// Factor on all standard deviations.
    pub noise_scale: f64,
    /// Chooses among independent sequences of noise.
    pub seed: u32,
    /// Rates are not measured: their sensors show 0.
    pub no_rates: bool,
}

impl Default for InstrumentSettings {
    fn default() -> Self {
        Self { sensors: [SensorSettings::OFF; COUNT], sample_time: 0.0, noise_scale: 1.0, seed: 1, no_rates: false }
    }
}

impl InstrumentSettings {
    /// The common sample time as a parameter.
    pub const SAMPLE_TIME: Parameter<Self> = parameter!(
        "sample_time",
        "s",
        TIME,
        "Time between two samples of every signal without one of its own; 0: none, or 1 ms where the profile samples",
        sample_time
    );
    /// The factor on the noise as a parameter.
    pub const NOISE_SCALE: Parameter<Self> = parameter!(
        "noise_scale",
        "",
        Range::new(0.0, 1e6),
        "Factor on the standard deviations of all noise, also that of the profile",
        noise_scale
    );

    /// The same settings, with this sample time if they have none.
    #[must_use]
    pub fn sampled(self, sample_time: f64) -> Self {
        Self { sample_time: if self.sample_time == 0.0 { sample_time } else { self.sample_time }, ..self }
    }

    /// The complete and checked settings of each sensor.
    fn complete(&self) -> Result<[SensorSettings; COUNT], SettingError> {
        check(&[Self::SAMPLE_TIME, Self::NOISE_SCALE], self)?;
        let mut sensors = self.sensors;
        for (sensor, signal) in sensors.iter_mut().zip(&SIGNALS) {
            if sensor.sample_time == 0.0 {
                sensor.sample_time = self.sample_time;
            }
            sensor.absent |= self.no_rates && signal.is_rate;
            sensor.check(signal.name)?;
            sensor.noise *= self.noise_scale;
        }
        Ok(sensors)
    }
}

/// All sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instruments {
    sensors: [Sensor; COUNT],
}

impl Instruments {
    /// Sensors whose inputs were constantly `inputs` until `start` \[s\].
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn new(settings: &InstrumentSettings, start: f64, inputs: &Signals) -> Result<Self, SettingError> {
        let complete = settings.complete()?;
        let stream = |number: usize| Stream { seed: settings.seed, number: u32::try_from(number).unwrap_or(u32::MAX) };
        let sensors = std::array::from_fn(|i| Sensor::new(complete[i], stream(i), start, inputs[i]));
        Ok(Self { sensors })
    }

    /// The outputs of the sensors.
    #[must_use]
    pub fn outputs(&self, inputs: &Signals) -> Signals {
        std::array::from_fn(|i| self.sensors[i].output(inputs[i]))
    }

    /// Time derivatives of the outputs, while the inputs change at `rates`.
    #[must_use]
    pub fn output_rates(&self, inputs: &Signals, rates: &Signals) -> Signals {
        std::array::from_fn(|i| self.sensors[i].output_rate(inputs[i], rates[i]))
    }

    /// Derivative of each output with respect to its input.
    #[must_use]
    pub fn feedthrough(&self) -> Signals {
        std::array::from_fn(|i| self.sensors[i].feedthrough())
    }

    /// Advances by `size` from `time` \[s\], for inputs that start at `inputs` and change at `rates`.
    ///
    /// # Errors
    /// When a number leaves its range. The state is then invalid.
    pub fn step(&mut self, time: f64, size: f64, inputs: &Signals, rates: &Signals) -> Result<(), StepError> {
        for (i, sensor) in self.sensors.iter_mut().enumerate() {
            if !sensor.reaches(time + size) {
                return Err(StepError::Count);
            }
            sensor.step(time, size, inputs[i], rates[i]);
            if !sensor.is_finite() {
                return Err(StepError::NotFinite);
            }
        }
        Ok(())
    }

    /// Whether sensors that were read from somewhere are in a state these can get into.
    #[must_use]
    pub fn is_sound(&self, like: &Self) -> bool {
        self.sensors.iter().zip(&like.sensors).all(|(sensor, like)| sensor.is_sound(like))
    }
}
