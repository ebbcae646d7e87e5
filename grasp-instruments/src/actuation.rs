//! The ways of the three commands.

use parameter_table::{Owner, Parameter, check, check_of, parameter};
use serde::{Deserialize, Serialize};

use crate::dead_zone::DeadZone;
use crate::path::{CommandPath, CommandSettings, StepError};
use crate::sensor::TIME;
use crate::setting::SettingError;

/// Number of commands.
pub const COUNT: usize = 3;

/// Values of the commands: torque on hub 1, torque on hub 2 \[N·m\], force on the object \[N\].
pub type Commands = [f64; COUNT];

/// A command.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// Name in the interfaces of plant and controllers.
    pub name: &'static str,
    /// SI unit in FMI's notation.
    pub unit: &'static str,
    /// Its description.
    pub description: &'static str,
    /// Index of the plant's channel that takes it: 0 for torques, 1 for the force.
    pub channel: usize,
}

impl Command {
    /// The texts for it in the [table of its path](CommandSettings::PARAMETERS).
    #[must_use]
    pub const fn owner(&self) -> Owner<'static> {
        Owner { name: self.name, unit: self.unit, called: self.name }
    }
}

/// The commands, in the order of the controllers' outputs.
pub const COMMANDS: [Command; COUNT] = [
    Command { name: "tau1_cmd", unit: "N.m", description: "torque on hub 1", channel: 0 },
    Command { name: "tau2_cmd", unit: "N.m", description: "torque on hub 2", channel: 0 },
    Command { name: "u_cmd", unit: "N", description: "force on the object", channel: 1 },
];

/// Settings of all commands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActuationSettings {
    /// Settings of each command; sample time and inverse come from the common settings.
    pub commands: [CommandSettings; COUNT],
    /// Sample time of all commands \[s\]; 0: none.
    pub sample_time: f64,
    /// Whether commands go through the inverse of a dead zone.
    pub dead_zone_inverse: bool,
    /// The dead zones that are believed in: that of the torques and that of the force.
    pub dead_zones: [DeadZone; 2],
}

impl Default for ActuationSettings {
    fn default() -> Self {
        Self {
            commands: [CommandSettings::default(); COUNT],
            sample_time: 0.0,
            dead_zone_inverse: false,
            dead_zones: [DeadZone::TORQUE, DeadZone::FORCE],
        }
    }
}

impl ActuationSettings {
    /// The sample time as a parameter.
    pub const SAMPLE_TIME: Parameter<Self> = parameter!(
        "sample_time",
        "s",
        TIME,
        "Time between two samples of the commands; 0: none, or 1 ms where the profile samples",
        sample_time
    );

    /// The same settings, with this sample time if they have none.
    #[must_use]
    pub fn sampled(self, sample_time: f64) -> Self {
        Self { sample_time: if self.sample_time == 0.0 { sample_time } else { self.sample_time }, ..self }
    }

    fn complete(&self) -> Result<[CommandSettings; COUNT], SettingError> {
        check(&[Self::SAMPLE_TIME], self)?;
        for (channel, zone) in DeadZone::CHANNELS.into_iter().zip(&self.dead_zones) {
            check_of(channel, &DeadZone::PARAMETERS, zone)?;
        }
        let mut commands = self.commands;
        for (settings, command) in commands.iter_mut().zip(&COMMANDS) {
            if self.sample_time > 0.0 {
                settings.sample_time = self.sample_time;
            }
            settings.inverse = self.dead_zone_inverse.then(|| self.dead_zones[command.channel]);
            settings.check(command.name)?;
        }
        Ok(commands)
    }
}

/// The ways of all commands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuation {
    paths: [CommandPath; COUNT],
}

impl Actuation {
    /// Paths whose input was constantly `commands` until `start` \[s\].
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn new(settings: &ActuationSettings, start: f64, commands: &Commands) -> Result<Self, SettingError> {
        let complete = settings.complete()?;
        Ok(Self { paths: std::array::from_fn(|i| CommandPath::new(&complete[i], start, commands[i])) })
    }

    /// The inputs of the actuators.
    #[must_use]
    pub fn outputs(&self, commands: &Commands) -> Commands {
        std::array::from_fn(|i| self.paths[i].output(commands[i]))
    }

    /// Time derivatives of the actuators' inputs, while the commands change at `rates`.
    #[must_use]
    pub fn output_rates(&self, commands: &Commands, rates: &Commands) -> Commands {
        std::array::from_fn(|i| self.paths[i].output_rate(commands[i], rates[i]))
    }

    /// Derivative of each actuator's input with respect to its command.
    #[must_use]
    pub fn feedthrough(&self, commands: &Commands) -> Commands {
        std::array::from_fn(|i| self.paths[i].feedthrough(commands[i]))
    }

    /// Advances by `size` from `time` \[s\], for commands that start at `commands` and change at `rates`.
    ///
    /// # Errors
    /// When a number leaves its range. The state is then invalid.
    pub fn step(&mut self, time: f64, size: f64, commands: &Commands, rates: &Commands) -> Result<(), StepError> {
        self.paths.iter_mut().enumerate().try_for_each(|(i, path)| path.step(time, size, commands[i], rates[i]))
    }

    /// Whether ways that were read from somewhere are in a state these can get into.
    #[must_use]
    pub fn is_sound(&self, like: &Self) -> bool {
        self.paths.iter().zip(&like.paths).all(|(path, like)| path.is_sound(like))
    }
}
