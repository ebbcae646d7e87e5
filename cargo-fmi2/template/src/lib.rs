//! A heated body as an FMU: replace it by your model, and delete what you do not need.
//!
//! C·dT/dt = P − G·(T − T_ambient)

use fmi2_export::{Declare, DefaultExperiment, Experiment, Failure, Info, Model, Step, Variables};
use serde::{Deserialize, Serialize};

/// Everything the model has: inputs, outputs, parameters and state. Plain fields; what the outside sees of them is said
/// once, in `variables`.
#[derive(Clone, Serialize, Deserialize)]
pub struct MyModel {
    // Inputs.
    heating_power: f64,
    ambient_temperature: f64,
    // Outputs.
    temperature: f64,
    heat_loss: f64,
    // Parameters.
    heat_capacity: f64,
    conductance: f64,
    temperature_0: f64,
    insulation: Insulation,
    // State.
    body: f64,
}

fmi2_export::enumeration! {
    /// How well the body is insulated
    pub enum Insulation {
        #[default]
        Bare = "bare": "The conductance as the parameter says",
        Wrapped = "wrapped": "A tenth of it",
    }
}

/// The default values are the start values.
impl Default for MyModel {
    fn default() -> Self {
        Self {
            heating_power: 0.0,
            ambient_temperature: 293.15,
            temperature: 0.0,
            heat_loss: 0.0,
            heat_capacity: 500.0,
            conductance: 2.0,
            temperature_0: 293.15,
            insulation: Insulation::Bare,
            body: 0.0,
        }
    }
}

impl MyModel {
    /// W/K.
    fn conductance(&self) -> f64 {
        match self.insulation {
            Insulation::Bare => self.conductance,
            Insulation::Wrapped => 0.1 * self.conductance,
        }
    }

    /// Fills in the outputs. Called only when the host asks for one of them and something has changed.
    fn outputs(&mut self) {
        self.temperature = self.body;
        self.heat_loss = self.conductance() * (self.body - self.ambient_temperature);
    }
}

impl Declare for MyModel {
    const INFO: Info = Info {
        name: "MyModel",
        description: "A heated body that loses heat to its surroundings",
        version: env!("CARGO_PKG_VERSION"),
        license: env!("CARGO_PKG_LICENSE"),
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 1000.0, step_size: 1.0, tolerance: None },
        ..Info::new()
    };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(Self::outputs);
        variables.input("heating_power", |m| &mut m.heating_power).unit("W").description("Power of the heater");
        variables
            .input("ambient_temperature", |m| &mut m.ambient_temperature)
            .unit("K")
            .range(0.0, 1e4)
            .description("Temperature of the surroundings");
        variables
            .output("temperature", outputs, |m| &mut m.temperature)
            .unit("K")
            .nominal(300.0)
            .description("Temperature of the body");
        variables
            .output("heat_loss", outputs, |m| &mut m.heat_loss)
            .unit("W")
            // An output that changes with an input at once, without a step in between, has to say so.
            .depends_linearly_on(["ambient_temperature"])
            .description("Heat flow to the surroundings");
        variables
            .parameter("heat_capacity", |m| &mut m.heat_capacity)
            .unit("J/K")
            .range(1e-3, 1e9)
            .description("Heat capacity of the body");
        variables
            .parameter("conductance", |m| &mut m.conductance)
            .unit("W/K")
            .range(1e-6, 1e6)
            .description("Thermal conductance to the surroundings");
        variables.parameter("insulation", |m| &mut m.insulation).description("Whether the body is wrapped");
        variables
            .parameter("temperature_0", |m| &mut m.temperature_0)
            .unit("K")
            .range(0.0, 1e4)
            .description("Temperature of the body at the start");
    }
}

impl Model for MyModel {
    fn initialize(&mut self, _experiment: &Experiment) -> Result<(), Failure> {
        self.body = self.temperature_0;
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        // Exact while the inputs are held. Put your integration method here; an input that the step cannot be done with
        // is `Err(Failure::discard("why"))`.
        let conductance = self.conductance();
        let rest = self.ambient_temperature + self.heating_power / conductance;
        self.body = rest + (self.body - rest) * (-step.size * conductance / self.heat_capacity).exp();
        Ok(())
    }
}

fmi2_export::export!(MyModel);

#[cfg(test)]
mod tests {
    use super::*;

    fn heated() -> MyModel {
        let mut model = MyModel { heating_power: 100.0, ..MyModel::default() };
        model.initialize(&Experiment::default()).unwrap();
        model
    }

    /// The model is a plain struct: it can be stepped without any host.
    fn run(model: &mut MyModel, size: f64, steps: u32) {
        let mut warn = |message: std::fmt::Arguments<'_>| panic!("{message}");
        for i in 0..steps {
            model.step(&mut Step::new(f64::from(i) * size, size, &mut warn)).unwrap();
        }
        model.outputs();
    }

    #[test]
    fn all_heating_power_is_lost_in_the_end() {
        let mut model = heated();
        run(&mut model, 100.0, 100);
        assert!((model.heat_loss - 100.0).abs() < 1e-9);
    }

    #[test]
    fn the_step_size_does_not_matter() {
        let (mut coarse, mut fine) = (heated(), heated());
        run(&mut coarse, 50.0, 2);
        run(&mut fine, 1.0, 100);
        assert!((coarse.temperature - fine.temperature).abs() < 1e-9);
    }

    /// If the declarations contradict themselves, the error lists everything that is wrong.
    #[test]
    fn declarations_are_consistent() {
        FMUS.models()[0].description().unwrap();
    }
}
