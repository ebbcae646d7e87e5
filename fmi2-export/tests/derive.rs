//! What `derive(Declare)` writes is what one would write with the builder.

use fmi2_export::{Declare, Failure, Info, Model, Step, Variables, describe};
use serde::{Deserialize, Serialize};

fmi2_export::enumeration! {
    /// How to move
    pub enum Mode {
        #[default]
        Slow = "slow": "With care",
        Fast = "fast": "Without",
    }
}

/// Two motors.
///
/// What follows is for readers of the code.
#[fmi2_export::model(name = "Drive", copyright = "(c) me", stop_time = 2, step_size = 0.5, directional_derivatives)]
struct Motors {
    /// Voltage of motor {}
    #[input(unit = "V", ramp = slope, min = -24, max = 24, start = [1.0, 2.0])]
    voltage: [f64; 2],
    /// Load
    #[input(name = "load torque", unit = "N.m", nominal = 0.1)]
    load: f64,
    /// Set point of a sampled loop
    #[input(discrete)]
    set_point: f64,
    slope: [f64; 2],
    /// Current of motor {}
    #[output(name = "i{}", unit = "A", rate = current_rate, depends_on(voltage), depends_linearly_on(load))]
    current: [f64; 2],
    #[state]
    current_rate: [f64; 2],
    /// Power of both
    #[output(unit = "W", depends_on(voltage), starts_from(load))]
    power: f64,
    /// Angle
    #[local(unit = "rad", display_degrees)]
    angle: f64,
    /// Whether it turns
    #[output]
    turning: bool,
    /// Gain
    #[tunable(start = 3.0)]
    k: f64,
    /// Teeth
    #[parameter(min = 1, max = 100, start = 12)]
    teeth: u16,
    /// Label
    #[parameter(start = "left")]
    label: String,
    /// Mode
    #[parameter]
    mode: Mode,
    #[serde(skip)]
    #[state(start = 7.0)]
    cache: f64,
}

impl Model for Motors {
    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn outputs(&mut self) {
        self.current = self.voltage.map(|voltage| voltage - self.load);
        self.power = self.voltage.iter().sum();
    }

    fn rates(&mut self) {
        self.current_rate = self.slope;
    }
}

/// The same by hand.
#[derive(Clone, Default, Serialize, Deserialize)]
struct ByHand {
    like: Motors,
}

impl Declare for ByHand {
    const INFO: Info = Info { version: "1.0.0", ..Motors::INFO };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|_| ());
        let rates = variables.evaluation(|_| ());
        variables
            .input_array("voltage", |m| &mut m.like.voltage)
            .ramp_array(|m| &mut m.like.slope)
            .unit("V")
            .range(-24.0, 24.0)
            .description("Voltage of motor {}");
        variables.input("load torque", |m| &mut m.like.load).unit("N.m").nominal(0.1).description("Load");
        variables.input("set_point", |m| &mut m.like.set_point).discrete().description("Set point of a sampled loop");
        variables
            .output_array("i{}", outputs, |m| &mut m.like.current)
            .rate_array(rates, |m| &mut m.like.current_rate)
            .unit("A")
            .depends_on(["voltage[{}]"])
            .depends_linearly_on(["load torque"])
            .description("Current of motor {}");
        variables
            .output("power", outputs, |m| &mut m.like.power)
            .unit("W")
            .depends_on(["voltage[1]", "voltage[2]"])
            .starts_from(["load torque"])
            .description("Power of both");
        variables.local("angle", outputs, |m| &mut m.like.angle).unit("rad").display_degrees().description("Angle");
        variables.output("turning", outputs, |m| &mut m.like.turning).description("Whether it turns");
        variables.parameter("k", |m| &mut m.like.k).tunable().description("Gain");
        variables.parameter("teeth", |m| &mut m.like.teeth).range(1.0, 100.0).description("Teeth");
        variables.parameter("label", |m| &mut m.like.label).description("Label");
        variables.parameter("mode", |m| &mut m.like.mode).description("Mode");
    }
}

impl Model for ByHand {
    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

#[test]
fn the_description_is_that_of_the_builder() {
    let derived = describe::<Motors>().unwrap();
    assert_eq!(derived.xml, describe::<ByHand>().unwrap().xml);
    for part in [
        "modelName=\"Drive\"",
        "description=\"Two motors\"",
        "copyright=\"(c) me\"",
        "version=\"1.0.0\"",
        "stopTime=\"2.0\" stepSize=\"0.5\"",
        "name=\"voltage[2]\" valueReference=\"1\" description=\"Voltage of motor 2\"",
        "max=\"24.0\" start=\"2.0\"",
        "start=\"left\"",
    ] {
        assert!(derived.xml.contains(part), "{part}\n{}", derived.xml);
    }
}

#[test]
fn start_values_are_the_default_and_a_model_steps_without_more() {
    let mut motors = Motors::default();
    assert_eq!((motors.voltage, motors.k, motors.teeth, motors.cache), ([1.0, 2.0], 3.0, 12, 7.0));
    motors.load = 0.5;
    motors.step(&mut Step::new(0.0, 0.5, &mut |_| {})).unwrap();
    motors.outputs();
    motors.rates();
    assert_eq!((motors.current, motors.power, motors.current_rate), ([0.5, 1.5], 3.0, [0.0; 2]));
}
