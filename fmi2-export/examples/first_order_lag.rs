//! A first-order lag, T·ẏ + y = k·u, as an FMU: the whole of it.
//!
//! The input may be a ramp over a step; the step is exact either way.

use fmi2_export::{Experiment, Failure, Model, Step};

/// First-order lag T*der(y) + y = k*u
#[fmi2_export::model(stop_time = 5.0, step_size = 0.1, directional_derivatives)]
struct FirstOrderLag {
    /// Input
    #[input(ramp = u_rate)]
    u: f64,
    /// The slope that the host may give to it.
    #[state]
    u_rate: f64,
    /// Output
    #[output(rate = y_rate)]
    y: f64,
    /// Time derivative of the output
    #[local(name = "der(y)", depends_on(u))]
    y_rate: f64,
    /// Gain
    #[tunable(name = "k", start = 1.0)]
    gain: f64,
    /// Time constant
    #[parameter(name = "T", unit = "s", start = 1.0, min = 1e-9, max = 1e9)]
    time_constant: f64,
    /// Output at the start
    #[parameter]
    y_start: f64,
    #[state]
    x: f64,
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

    fn outputs(&mut self) {
        self.y = self.x;
        self.rates();
    }

    fn rates(&mut self) {
        self.y_rate = (self.gain * self.u - self.x) / self.time_constant;
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        // y is a state: it does not depend on u directly.
        direction.y = 0.0;
        direction.y_rate = self.gain * direction.u / self.time_constant;
    }
}

fmi2_export::export!(FirstOrderLag);
