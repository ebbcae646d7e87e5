//! Two FMUs served by one library: an integrator, and a counter of every type of variable FMI 2.0 has.

use fmi2_export::{Declare, Experiment, Failure, Info, Model, Step, Variables, field};
use serde::{Deserialize, Serialize};

#[derive(Clone, Default, Serialize, Deserialize)]
struct Integrator {
    u: f64,
    y: f64,
    x: f64,
}

impl Declare for Integrator {
    const INFO: Info = Info { name: "Integrator", description: "der(y) = u", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|m| m.y = m.x);
        variables.input_field("u", field!(Self, u)).description("Input");
        variables.output_field("y", outputs, field!(Self, y)).description("Integral of the input");
    }
}

impl Model for Integrator {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        self.x = 0.0;
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        self.x += self.u * step.size;
        Ok(())
    }
}

fmi2_export::enumeration! {
    /// Which way to count
    enum Direction {
        #[default]
        Up = "up": "Add one at every step",
        Down = "down": "Subtract one at every step",
    }
}

#[derive(Clone, Default, Serialize, Deserialize)]
struct Counter {
    enabled: bool,
    direction: Direction,
    limit: i32,
    label: String,
    count: i32,
    at_limit: bool,
    text: String,
    history: [f64; 3],
}

impl Counter {
    fn outputs(&mut self) {
        self.at_limit = self.count == self.limit;
        self.text = format!("{}: {}", self.label, self.count);
    }
}

impl Declare for Counter {
    const INFO: Info = Info { name: "Counter", description: "Counts its steps", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(Self::outputs);
        variables.input("enabled", |m| &mut m.enabled).description("Whether to count");
        variables.input("direction", |m| &mut m.direction).description("Which way to count");
        variables.parameter("limit", |m| &mut m.limit).range(0.0, 100.0).description("Count that is reported");
        variables.parameter("label", |m| &mut m.label).tunable().description("Put before the count in `text`");
        variables.output("count", outputs, |m| &mut m.count).description("Number of steps");
        variables.output("at_limit", outputs, |m| &mut m.at_limit).description("Whether the limit is reached");
        variables.output("text", outputs, |m| &mut m.text).description("The count in words");
        variables
            .output_array("history", outputs, |m| &mut m.history)
            .descriptions(|i| format!("Start time of the step {} ago", i + 1));
    }
}

impl Model for Counter {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        self.count = 0;
        self.history = [0.0; 3];
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        if self.enabled {
            self.count += if self.direction == Direction::Up { 1 } else { -1 };
        }
        if self.count == self.limit + 1 {
            step.warn(format_args!("{} is past its limit", self.label));
        }
        if self.count < 0 {
            return Err(Failure::error("the count is negative"));
        }
        self.history.rotate_right(1);
        self.history[0] = step.time;
        Ok(())
    }
}

fmi2_export::export!(Integrator, Counter);
