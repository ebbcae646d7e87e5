//! `GraspInstruments.fmu`.

use fmi2_export::{
    Declare, DefaultExperiment, Evaluation, Experiment, Failure, Info, Model, Step, VariableBuilder, Variables, field,
};
use grasp_instruments::{InstrumentSettings, Instruments, SIGNALS, SensorSettings, Signal, Signals, profiles};
use serde::{Deserialize, Serialize};

fmi2_export::enumeration! {
    /// What the sensors are like
    pub enum SensorProfile {
        #[default]
        Parameters = "parameters": "As the parameters of each signal say; with their start values nothing happens",
        Off = "off": "Every signal as it is, whatever the parameters say",
        Noise = "noise": "White noise of about one percent in each sample, at 1 kHz",
        Encoders = "encoders": "16-bit encoders, a scale and strain gauges, quantised, at 1 kHz; no rates",
    }
}

/// The sensors of all signals that a controller measures.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct GraspInstruments {
    profile: SensorProfile,
    settings: InstrumentSettings,
    inputs: Signals,
    /// Slopes of the inputs over the next step.
    slopes: Signals,
    /// Start time \[s\].
    start: f64,
    /// The sensors, once there is a start.
    instruments: Option<Instruments>,
    #[serde(skip)]
    outputs: Signals,
    #[serde(skip)]
    rates: Signals,
    #[serde(skip)]
    measures_rates: bool,
}

impl GraspInstruments {
    /// The settings that result from the profile and the parameters.
    fn settings(&self) -> InstrumentSettings {
        let with = |sensors| InstrumentSettings { sensors, ..self.settings }.sampled(profiles::SAMPLE_TIME);
        match self.profile {
            SensorProfile::Parameters => self.settings,
            SensorProfile::Off => InstrumentSettings::default(),
            SensorProfile::Noise => with(profiles::noise()),
            SensorProfile::Encoders => with(profiles::encoders()),
        }
    }

    fn instruments(&self) -> Result<Instruments, Failure> {
        Instruments::new(&self.settings(), self.start, &self.inputs).map_err(Failure::error)
    }

    /// Whether any of the sensors that there are measures a rate.
    fn measures_rates(&self) -> bool {
        let settings = self.settings();
        let measured = |(signal, sensor): (&Signal, &SensorSettings)| signal.is_rate && !sensor.absent;
        !settings.no_rates && SIGNALS.iter().zip(&settings.sensors).any(measured)
    }

    fn outputs(&mut self) {
        if let Some(instruments) = &self.instruments {
            self.outputs = instruments.outputs(&self.inputs);
        }
    }

    fn rates(&mut self) {
        if let Some(instruments) = &self.instruments {
            self.rates = instruments.output_rates(&self.inputs, &self.slopes);
        }
    }
}

impl Declare for GraspInstruments {
    const INFO: Info = Info {
        name: "GraspInstruments",
        description: "Sensors between the dual-arm plant and its controller: noise, bias, quantisation, low-pass, delay",
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 2.0, step_size: 1e-4, tolerance: None },
        directional_derivatives: true,
        ..fmi2_export::cargo_info!()
    };

    fn variables(variables: &mut Variables<Self>) {
        for (i, signal) in SIGNALS.iter().enumerate() {
            in_degrees(variables.input_field(signal.name, field!(Self, inputs).element(i)).unit(signal.unit), signal)
                .ramp(move |m| &mut m.slopes[i])
                .nominal(signal.nominal)
                .description(&format!("True {}", signal.description));
        }
        let (outputs, rates) = (variables.evaluation(Self::outputs), variables.evaluation(Self::rates));
        declare_outputs(variables, outputs, rates);
        variables.parameter("sensor_profile", |m| &mut m.profile).description("What the sensors are like");
        variables.parameters(&[InstrumentSettings::SAMPLE_TIME], |m| &mut m.settings);
        variables
            .parameter("seed", |m| &mut m.settings.seed)
            .range(0.0, f64::from(i32::MAX))
            .description("Chooses among independent sequences of noise");
        variables.parameters(&[InstrumentSettings::NOISE_SCALE], |m| &mut m.settings);
        variables
            .parameter("no_rates", |m| &mut m.settings.no_rates)
            .description("Nothing measures rates: the outputs of all _dot signals are 0");
        for row in SensorSettings::PARAMETERS {
            for (i, signal) in SIGNALS.iter().enumerate() {
                let parameter = variables.parameters_of(signal.owner(), &[row], move |m| &mut m.settings.sensors[i]);
                if row.unit == "{}" {
                    in_degrees(parameter, signal);
                }
            }
        }
    }
}

impl Model for GraspInstruments {
    fn initialize(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        self.start = experiment.start_time;
        self.instruments = Some(self.instruments()?);
        self.measures_rates = self.measures_rates();
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        let instruments = self.instruments.as_mut().ok_or_else(|| Failure::error("the sensors have no start yet"))?;
        instruments.step(step.time, step.size, &self.inputs, &self.slopes).map_err(Failure::discard)
    }

    fn restored(&mut self) -> Result<(), Failure> {
        // Before and in initialization mode the parameters may have changed, even to an invalid combination; a state is
        // then created again.
        let like_new = self.instruments().ok();
        self.instruments.take_if(|state| like_new.as_ref().is_none_or(|like_new| !state.is_sound(like_new)));
        self.measures_rates = self.measures_rates();
        Ok(())
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        let Some(instruments) = &self.instruments else { return };
        for ((output, gain), input) in
            direction.outputs.iter_mut().zip(instruments.feedthrough()).zip(&direction.inputs)
        {
            *output = gain * input;
        }
    }
}

/// Angles and their rates are shown in degrees.
fn in_degrees<'a>(
    builder: VariableBuilder<'a, GraspInstruments>,
    signal: &Signal,
) -> VariableBuilder<'a, GraspInstruments> {
    if signal.unit.starts_with("rad") { builder.display_degrees() } else { builder }
}

fn declare_outputs(variables: &mut Variables<GraspInstruments>, outputs: Evaluation, rates: Evaluation) {
    for (i, signal) in SIGNALS.iter().enumerate() {
        let name = format!("{}_measured", signal.name);
        in_degrees(
            variables.output_field(&name, outputs, field!(GraspInstruments, outputs).element(i)).unit(signal.unit),
            signal,
        )
        .rate(rates, move |m| &mut m.rates[i])
        .nominal(signal.nominal)
        .depends_on([signal.name])
        .description(&format!("What a controller gets as {}", signal.name));
    }
    variables
        .output_field("measures_rates", outputs, field!(GraspInstruments, measures_rates))
        .description("Whether any rate is measured; if not, the controller has to estimate them");
}
