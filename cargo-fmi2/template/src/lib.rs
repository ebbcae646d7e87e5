//! A heated body as an FMU: replace it by your model, and delete what you do not need.
//!
//! C·dT/dt = P − G·(T − T_ambient)

use fmi2_export::{Experiment, Failure, Model, Step};

/// A heated body that loses heat to its surroundings
//
// Everything the model has: inputs, outputs, parameters and state. Each field says what the outside sees of it; its comment is
// the variable's description.
#[fmi2_export::model(stop_time = 1000.0, step_size = 1.0)]
pub struct MyModel {
    /// Power of the heater
    #[input(unit = "W")]
    heating_power: f64,
    /// Temperature of the surroundings
    #[input(unit = "K", start = 293.15, min = 0.0, max = 1e4)]
    ambient_temperature: f64,
    /// Temperature of the body
    #[output(unit = "K", nominal = 300.0)]
    temperature: f64,
    // An output that changes with an input at once, without a step in between, has to say so.
    /// Heat flow to the surroundings
    #[output(unit = "W", depends_linearly_on(ambient_temperature))]
    heat_loss: f64,
    /// Heat capacity of the body
    #[parameter(unit = "J/K", start = 500.0, min = 1e-3, max = 1e9)]
    heat_capacity: f64,
    /// Thermal conductance to the surroundings
    #[parameter(unit = "W/K", start = 2.0, min = 1e-6, max = 1e6)]
    conductance: f64,
    /// Whether the body is wrapped
    #[parameter]
    insulation: Insulation,
    /// Temperature of the body at the start
    #[parameter(unit = "K", start = 293.15, min = 0.0, max = 1e4)]
    temperature_0: f64,
    /// The temperature as the step leaves it.
    #[state]
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

impl MyModel {
    /// W/K.
    fn conductance(&self) -> f64 {
        match self.insulation {
            Insulation::Bare => self.conductance,
            Insulation::Wrapped => 0.1 * self.conductance,
        }
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

    /// Fills in the outputs. Called only when the host asks for one of them and something has changed.
    fn outputs(&mut self) {
        self.temperature = self.body;
        self.heat_loss = self.conductance() * (self.body - self.ambient_temperature);
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
