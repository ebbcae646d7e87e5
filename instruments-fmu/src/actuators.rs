//! `GraspActuators.fmu`.

use fmi2_export::{Declare, DefaultExperiment, Experiment, Failure, Info, Model, Step, Variables, field};
use grasp_instruments::actuation::{COMMANDS, Commands};
use grasp_instruments::dead_zone::DeadZone;
use grasp_instruments::{Actuation, ActuationSettings, CommandSettings, profiles};
use serde::{Deserialize, Serialize};

fmi2_export::enumeration! {
    /// What happens to the commands
    pub enum ActuatorProfile {
        #[default]
        Parameters = "parameters": "As the parameters of each command say; with their start values nothing happens",
        Off = "off": "Every command as it is, whatever the parameters say",
        Delay = "delay": "Commands are sampled at 1 kHz and come 2 ms late",
    }
}

/// The ways of all commands from a controller to the plant.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct GraspActuators {
    profile: ActuatorProfile,
    settings: ActuationSettings,
    inputs: Commands,
    /// Slopes of the inputs over the next step.
    slopes: Commands,
    /// Start time \[s\].
    start: f64,
    /// The ways, once there is a start.
    actuation: Option<Actuation>,
    #[serde(skip)]
    outputs: Commands,
    #[serde(skip)]
    rates: Commands,
}

impl GraspActuators {
    /// The settings that result from the profile and the parameters.
    fn settings(&self) -> ActuationSettings {
        match self.profile {
            ActuatorProfile::Parameters => self.settings,
            ActuatorProfile::Off => ActuationSettings::default(),
            ActuatorProfile::Delay => {
                ActuationSettings { commands: profiles::delay(), ..self.settings }.sampled(profiles::SAMPLE_TIME)
            }
        }
    }

    fn actuation(&self) -> Result<Actuation, Failure> {
        Actuation::new(&self.settings(), self.start, &self.inputs).map_err(Failure::error)
    }

    fn outputs(&mut self) {
        if let Some(actuation) = &self.actuation {
            self.outputs = actuation.outputs(&self.inputs);
        }
    }

    fn rates(&mut self) {
        if let Some(actuation) = &self.actuation {
            self.rates = actuation.output_rates(&self.inputs, &self.slopes);
        }
    }
}

impl Declare for GraspActuators {
    const INFO: Info = Info {
        name: "GraspActuators",
        description: "Way of the commands from a controller to the dual-arm plant: inverse dead zone, delay, rate limit, lag",
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 2.0, step_size: 1e-4, tolerance: None },
        directional_derivatives: true,
        ..fmi2_export::cargo_info!()
    };

    fn variables(variables: &mut Variables<Self>) {
        for (i, command) in COMMANDS.iter().enumerate() {
            variables
                .input_field(command.name, field!(Self, inputs).element(i))
                .ramp(move |m| &mut m.slopes[i])
                .unit(command.unit)
                .description(&format!("What the controller commands: {}", command.description));
        }
        let (outputs, rates) = (variables.evaluation(Self::outputs), variables.evaluation(Self::rates));
        for (i, command) in COMMANDS.iter().enumerate() {
            variables
                .output_field(&format!("{}_sent", command.name), outputs, field!(Self, outputs).element(i))
                .rate(rates, move |m| &mut m.rates[i])
                .unit(command.unit)
                .depends_on([command.name])
                .description(&format!("What the plant gets as {}", command.name));
        }
        variables.parameter("actuator_profile", |m| &mut m.profile).description("What happens to the commands");
        variables.parameters(&[ActuationSettings::SAMPLE_TIME], |m| &mut m.settings);
        for row in CommandSettings::PARAMETERS {
            for (i, command) in COMMANDS.iter().enumerate() {
                variables.parameters_of(command.owner(), &[row], move |m| &mut m.settings.commands[i]);
            }
        }
        variables
            .parameter("dead_zone_inverse", |m| &mut m.settings.dead_zone_inverse)
            .description("Whether commands go through the inverse of a dead zone, eq. (18), first");
        // Under the names that the plant's own ones have.
        for (i, channel) in DeadZone::CHANNELS.into_iter().enumerate() {
            variables.parameters_of(channel, &DeadZone::PARAMETERS, move |m| &mut m.settings.dead_zones[i]);
        }
    }
}

impl Model for GraspActuators {
    fn initialize(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        self.start = experiment.start_time;
        self.actuation = Some(self.actuation()?);
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        let actuation = self.actuation.as_mut().ok_or_else(|| Failure::error("the actuators have no start yet"))?;
        actuation.step(step.time, step.size, &self.inputs, &self.slopes).map_err(Failure::discard)
    }

    fn restored(&mut self) -> Result<(), Failure> {
        // Before and in initialization mode the parameters may have changed, even to an invalid combination; a state is
        // then created again.
        let like_new = self.actuation().ok();
        self.actuation.take_if(|state| like_new.as_ref().is_none_or(|like_new| !state.is_sound(like_new)));
        Ok(())
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        let Some(actuation) = &self.actuation else { return };
        let gains = actuation.feedthrough(&self.inputs);
        for ((output, gain), input) in direction.outputs.iter_mut().zip(gains).zip(&direction.inputs) {
            *output = gain * input;
        }
    }
}
