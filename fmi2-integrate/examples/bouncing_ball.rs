//! Three models that only define their time derivatives. A host of model exchange reads these derivatives; in co-simulation
//! the built-in solver computes steps from them.
//!
//! * A ball that bounces: state events, states that jump, a discrete state.
//! * Van der Pol's oscillator: the Jacobian.
//! * Stairs: time events, a discrete input, no continuous states.

use fmi2_export::{Declare, EventUpdate, Experiment, Failure, Info, Model, ModelExchange, Moment, Step, Variables};
use fmi2_integrate::Integrate as _;
use serde::{Deserialize, Serialize};

/// ḧ = −g above the ground, ḣ → −e ḣ on it; at rest once it rises no more than a micrometre.
#[derive(Clone, Serialize, Deserialize)]
struct BouncingBall {
    /// Height and velocity.
    h: f64,
    v: f64,
    h_dot: f64,
    v_dot: f64,
    /// Restitution, gravity, height at the start.
    e: f64,
    g: f64,
    h_start: f64,
    bounces: i32,
    is_at_rest: bool,
    indicators: [f64; 1],
}

impl Default for BouncingBall {
    fn default() -> Self {
        Self {
            h: 1.0,
            v: 0.0,
            h_dot: 0.0,
            v_dot: 0.0,
            e: 0.7,
            g: 9.81,
            h_start: 1.0,
            bounces: 0,
            is_at_rest: false,
            indicators: [1.0],
        }
    }
}

impl BouncingBall {
    /// It comes to rest when it would rise less than this (m).
    const LEAST_RISE: f64 = 1e-6;

    fn rates(&mut self) {
        (self.h_dot, self.v_dot) = if self.is_at_rest { (0.0, 0.0) } else { (self.v, -self.g) };
    }

    fn indicators(&mut self) {
        // At rest nothing comes any more.
        self.indicators = [if self.is_at_rest { 1.0 } else { self.h }];
    }
}

impl Declare for BouncingBall {
    const INFO: Info =
        Info { name: "BouncingBall", description: "A ball that bounces", directional_derivatives: true, ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        // The states are where they are.
        let states = variables.evaluation(|_| {});
        let rates = variables.evaluation(Self::rates);
        let indicators = variables.evaluation(Self::indicators);
        variables.output("h", states, |m| &mut m.h).state().unit("m").description("Height");
        variables.output("v", states, |m| &mut m.v).state().unit("m/s").description("Velocity");
        variables
            .local("der(h)", rates, |m| &mut m.h_dot)
            .derivative_of("h")
            .depends_on_states(["v"])
            .unit("m/s")
            .description("Rate of the height");
        let nothing: [&str; 0] = [];
        variables
            .local("der(v)", rates, |m| &mut m.v_dot)
            .derivative_of("v")
            .depends_on_states(nothing)
            .unit("m/s2")
            .description("Rate of the velocity");
        variables
            .output("bounces", states, |m| &mut m.bounces)
            .depends_on_states(nothing)
            .description("How often it has bounced");
        variables.parameter("e", |m| &mut m.e).range(0.0, 1.0).tunable().description("Coefficient of restitution");
        variables.parameter("g", |m| &mut m.g).min(0.0).unit("m/s2").description("Gravity");
        variables.parameter("h_start", |m| &mut m.h_start).min(0.0).unit("m").description("Height at the start");
        variables.event_indicators(indicators, |m| &mut m.indicators);
    }
}

impl Model for BouncingBall {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        (self.h, self.v, self.bounces, self.is_at_rest) = (self.h_start, 0.0, 0, false);
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        step.integrate(self)
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        (direction.h_dot, direction.v_dot) = if self.is_at_rest { (0.0, 0.0) } else { (direction.v, 0.0) };
    }
}

impl ModelExchange for BouncingBall {
    fn new_discrete_states(&mut self, _: &mut Moment<'_>) -> Result<EventUpdate, Failure> {
        if self.h <= 0.0 && self.v < 0.0 {
            self.bounces += 1;
            self.v *= -self.e;
            if self.v * self.v < 2.0 * self.g * Self::LEAST_RISE {
                (self.h, self.v, self.is_at_rest) = (0.0, 0.0, true);
            }
        }
        Ok(EventUpdate::default())
    }
}

/// ẋ₀ = x₁, ẋ₁ = μ (1 − x₀²) x₁ − x₀.
#[derive(Clone, Serialize, Deserialize)]
struct VanDerPol {
    x: [f64; 2],
    x_dot: [f64; 2],
    mu: f64,
}

impl Default for VanDerPol {
    fn default() -> Self {
        Self { x: [2.0, 0.0], x_dot: [0.0; 2], mu: 1.0 }
    }
}

impl Declare for VanDerPol {
    const INFO: Info = Info {
        name: "VanDerPol",
        description: "Van der Pol's oscillator",
        directional_derivatives: true,
        ..Info::new()
    };

    fn variables(variables: &mut Variables<Self>) {
        let states = variables.evaluation(|_| {});
        let rates = variables.evaluation(|m| m.x_dot = [m.x[1], m.mu * (1.0 - m.x[0] * m.x[0]) * m.x[1] - m.x[0]]);
        variables.output_array("x", states, |m| &mut m.x).state().nominal(2.0).description("State {}");
        variables
            .local_array("der(x[{}])", rates, |m| &mut m.x_dot)
            .derivative_of("x[{}]")
            .description("Rate of state {}");
        variables.parameter("mu", |m| &mut m.mu).range(0.0, 1e3).description("Strength of the damping");
    }
}

impl Model for VanDerPol {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        self.x = [2.0, 0.0];
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        step.integrate(self)
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        let (x, d) = (self.x, direction.x);
        direction.x_dot = [d[1], self.mu * ((1.0 - x[0] * x[0]) * d[1] - 2.0 * x[0] * x[1] * d[0]) - d[0]];
    }
}

impl ModelExchange for VanDerPol {}

/// A number that rises by a certain height every second, and ends the simulation at a certain value.
#[derive(Clone, Serialize, Deserialize)]
struct Stairs {
    rise: i32,
    last: i32,
    y: i32,
    next: f64,
}

impl Default for Stairs {
    fn default() -> Self {
        Self { rise: 1, last: 1000, y: 0, next: 1.0 }
    }
}

impl Declare for Stairs {
    const INFO: Info = Info { name: "Stairs", description: "A step every second", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|_| {});
        variables.input("rise", |m| &mut m.rise).range(0.0, 100.0).description("Height of a step");
        variables.parameter("last", |m| &mut m.last).description("Height at which it ends");
        variables.output("y", outputs, |m| &mut m.y).description("Height");
        variables.model_exchange();
    }
}

impl Model for Stairs {
    fn initialize(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        (self.y, self.next) = (0, experiment.start_time + 1.0);
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        step.integrate(self)
    }
}

impl ModelExchange for Stairs {
    fn new_discrete_states(&mut self, moment: &mut Moment<'_>) -> Result<EventUpdate, Failure> {
        while moment.time >= self.next && self.y < self.last {
            self.y = self.y.saturating_add(self.rise);
            self.next += 1.0;
        }
        Ok(EventUpdate { next_time: Some(self.next), terminate: self.y >= self.last, again: false })
    }
}

fmi2_export::export!(BouncingBall, VanDerPol, Stairs);
