//! A first-order lag, T·ẏ + y = k·u, as an FMU: the whole of it.
//!
//! The input may be a ramp over a step; the step is exact either way.

use fmi2_export::{Declare, DefaultExperiment, Experiment, Failure, Info, Model, Step, Variables};
use serde::{Deserialize, Serialize};

#[derive(Clone, Serialize, Deserialize)]
struct FirstOrderLag {
    // Inputs, and the slope the host may give to them.
    u: f64,
    u_rate: f64,
    // Outputs.
    y: f64,
    y_rate: f64,
    // Parameters.
    gain: f64,
    time_constant: f64,
    y_start: f64,
    // State.
    x: f64,
}

impl Default for FirstOrderLag {
    fn default() -> Self {
        Self { u: 0.0, u_rate: 0.0, y: 0.0, y_rate: 0.0, gain: 1.0, time_constant: 1.0, y_start: 0.0, x: 0.0 }
    }
}

impl FirstOrderLag {
    fn outputs(&mut self) {
        self.y = self.x;
    }

    fn rates(&mut self) {
        self.y_rate = (self.gain * self.u - self.x) / self.time_constant;
    }
}

impl Declare for FirstOrderLag {
    const INFO: Info = Info {
        name: "FirstOrderLag",
        description: "First-order lag T*der(y) + y = k*u",
        version: "1.0.0",
        license: "MIT",
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 5.0, step_size: 0.1, tolerance: None },
        directional_derivatives: true,
        ..Info::new()
    };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(Self::outputs);
        let rates = variables.evaluation(Self::rates);
        variables.input("u", |m| &mut m.u).ramp(|m| &mut m.u_rate).description("Input");
        variables.output("y", outputs, |m| &mut m.y).rate(rates, |m| &mut m.y_rate).description("Output");
        variables
            .local("der(y)", rates, |m| &mut m.y_rate)
            .depends_on(["u"])
            .description("Time derivative of the output");
        variables.tunable("k", |m| &mut m.gain).description("Gain");
        variables.parameter("T", |m| &mut m.time_constant).unit("s").range(1e-9, 1e9).description("Time constant");
        variables.parameter("y_start", |m| &mut m.y_start).description("Output at the start");
    }
}

impl Model for FirstOrderLag {
    fn initialize(&mut self, _experiment: &Experiment) -> Result<(), Failure> {
        self.x = self.y_start;
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        // Exact for u(t) = u + u_rate·t: the particular solution is k·(u + u_rate·(t − T)).
        let (t, k) = (self.time_constant, self.gain);
        let particular = |time: f64| k * (self.u + self.u_rate * (time - t));
        self.x = particular(step.size) + (self.x - particular(0.0)) * (-step.size / t).exp();
        Ok(())
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        // y is a state: it does not depend on u directly.
        direction.y = 0.0;
        direction.y_rate = self.gain * direction.u / self.time_constant;
    }
}

fmi2_export::export!(FirstOrderLag);
