//! Ready-made settings.

use crate::actuation;
use crate::instruments::{COUNT, SIGNALS};
use crate::path::CommandSettings;
use crate::sensor::SensorSettings;

/// Sample time of the profiles \[s\], unless the user sets another one: a control computer at 1 kHz.
pub const SAMPLE_TIME: f64 = 1e-3;

/// Delay of the commands in the profile of that name \[s\].
pub const DELAY: f64 = 2e-3;

/// Number of steps of a turn that an encoder of 16 bits resolves.
const ENCODER_STEPS: f64 = 65_536.0;

/// White noise of about one percent of the signals in the paper's case, in each sample.
#[must_use]
pub fn noise() -> [SensorSettings; COUNT] {
    sensors(|name| {
        let noise = match name {
            "theta" => 1e-4,
            "theta_dot" => 1e-2,
            "y_object" => 1e-5,
            "root_moment" | "y_object_dot" => 1e-3,
            "tip_shear" => 5e-3,
            // A moment's rate has the noise of a shear's at the paper's arm length of 0.2 m.
            "root_moment_dot" => 0.1,
            _ => 0.5,
        };
        SensorSettings { noise, ..SensorSettings::OFF }
    })
}

/// Encoders of 16 bits at the hubs, a scale of 10 µm at the object, strain gauges whose converters resolve 0.5 mN·m at the
/// roots and 2.5 mN at the tips; no sensors of rates.
#[must_use]
pub fn encoders() -> [SensorSettings; COUNT] {
    sensors(|name| {
        let lsb = match name {
            "theta" => std::f64::consts::TAU / ENCODER_STEPS,
            "y_object" => 1e-5,
            "root_moment" => 5e-4,
            "tip_shear" => 2.5e-3,
            _ => return SensorSettings { absent: true, ..SensorSettings::OFF },
        };
        SensorSettings { lsb, ..SensorSettings::OFF }
    })
}

/// Settings of all sensors, from a signal's name without the number of its arm.
fn sensors(of: impl Fn(&str) -> SensorSettings) -> [SensorSettings; COUNT] {
    SIGNALS.map(|signal| {
        let name = signal.name.replace(['1', '2'], "");
        of(&name)
    })
}

/// Commands that come 2 ms late.
#[must_use]
pub fn delay() -> [CommandSettings; actuation::COUNT] {
    [CommandSettings { delay: DELAY, ..CommandSettings::default() }; actuation::COUNT]
}
