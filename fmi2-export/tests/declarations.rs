//! Arrays, tables of parameters and what else declares several variables at once.

use fmi2_export::{Declare, Experiment, Failure, Info, Model, ModelExchange, Owner, Parameter, Range, Step, Variables};
use fmi2_export::{describe, parameter};
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Arm {
    rigidity: f64,
    mass: f64,
}

const ARM: [Parameter<Arm>; 2] = [
    parameter!("EI{}", "N.m2", Range::new(0.0, f64::INFINITY), "Flexural rigidity of arm {}", rigidity),
    parameter!("m{}", "", Range::new(-1.0, 1e9), "Mass of arm {}", mass),
];

/// In whose texts `{}` is not a number.
const SHARE: [Parameter<Arm>; 1] = [parameter!("{}_share", "{}/s", Range::ANY, "What {} loses", mass)];

#[derive(Clone, Serialize, Deserialize)]
struct Arms {
    command: [f64; 2],
    slope: [f64; 2],
    torque: [f64; 2],
    torque_rate: [f64; 2],
    closed: [bool; 2],
    turns: i64,
    pair: [Arm; 2],
    object: Arm,
    gains: [f64; 3],
    start: [f64; 2],
    sampled: f64,
    wrong: [f64; 3],
}

impl Default for Arms {
    fn default() -> Self {
        Self {
            command: [0.0; 2],
            slope: [0.0; 2],
            torque: [0.0; 2],
            torque_rate: [0.0; 2],
            closed: [false; 2],
            turns: 7,
            pair: [Arm { rigidity: 0.1, mass: 0.2 }, Arm { rigidity: 0.3, mass: 0.4 }],
            object: Arm { rigidity: 0.5, mass: 0.6 },
            gains: [1.0, 2.0, 3.0],
            start: [0.0, 1.5],
            sampled: 0.0,
            wrong: [0.0; 3],
        }
    }
}

impl Declare for Arms {
    const INFO: Info = Info { name: "Arms", description: "Two of everything", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|m| m.torque = m.command);
        variables
            .input_array("tau{}_cmd", |m| &mut m.command)
            .ramp_array(|m| &mut m.slope)
            .unit("N.m")
            .description("Command {}");
        variables.input("sampled", |m| &mut m.sampled).discrete().description("Changes at communication points");
        variables.input_array("closed", |m| &mut m.closed).description("Whether gripper {} is closed");
        variables
            .output_array("tau{}", outputs, |m| &mut m.torque)
            .rate_array(outputs, |m| &mut m.torque_rate)
            .depends_on(["tau{}_cmd"])
            .description("Torque {}");
        variables.output("turns", outputs, |m| &mut m.turns).description("A text with {} in it");
        variables.parameter_family(&ARM, |m| &mut m.pair);
        variables.parameters(&ARM, |m| &mut m.object);
        let object = Owner { name: "object", unit: "kg", called: "the object" };
        variables.parameters_of(object, &SHARE, |m| &mut m.object).tunable();
        variables.parameter_array("k", |m| &mut m.gains).tunable().range(0.0, 9.0).description("Gain {}");
        variables.parameter_array("theta{}_0", |m| &mut m.start).unit("rad").display_degrees().description("Start {}");
    }
}

impl Model for Arms {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

/// The variables as XML has them, a line each.
fn variables(xml: &str) -> Vec<String> {
    let (_, rest) = xml.split_once("<ModelVariables>").unwrap();
    let (list, _) = rest.split_once("</ModelVariables>").unwrap();
    list.split("</ScalarVariable>").map(|v| v.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

#[test]
fn arrays_and_tables_become_variables_with_their_numbers_in_their_texts() {
    let xml = describe::<Arms>().unwrap().xml;
    let variables = variables(&xml);
    let name = |text: &String| text.split('"').nth(1).map(str::to_owned);
    let names: Vec<String> = variables.iter().filter_map(name).collect();
    assert_eq!(
        names.join(" "),
        "tau1_cmd tau2_cmd sampled closed[1] closed[2] tau1 tau2 turns EI1 m1 EI2 m2 EI{} m{} object_share k[1] \
         k[2] k[3] theta1_0 theta2_0"
    );
    let of = |name: &str| variables.iter().find(|v| v.contains(&format!("name=\"{name}\" "))).unwrap();
    assert!(of("tau2_cmd").contains("description=\"Command 2\" causality=\"input\" variability=\"continuous\""));
    assert!(of("sampled").contains("variability=\"discrete\""));
    assert!(of("closed[1]").contains("variability=\"discrete\"> <Boolean start=\"false\""));
    assert!(of("turns").contains("description=\"A text with {} in it\""), "only arrays have numbers");
    assert!(of("EI2").contains("description=\"Flexural rigidity of arm 2\" causality=\"parameter\""));
    assert!(of("EI2").contains("<Real unit=\"N.m2\" min=\"0.0\" start=\"0.3\"/>"));
    assert!(of("m1").contains("<Real min=\"-1.0\" max=\"1000000000.0\" start=\"0.2\"/>"));
    assert!(of("object_share").contains("description=\"What the object loses\" causality=\"parameter\""));
    assert!(
        of("object_share").contains("variability=\"tunable\" initial=\"exact\"> <Real unit=\"kg/s\" start=\"0.6\"/>")
    );
    assert!(of("k[3]").contains("variability=\"tunable\"") && of("k[3]").contains("start=\"3.0\""));
    assert!(of("theta2_0").contains("unit=\"rad\" displayUnit=\"deg\" start=\"1.5\""));
    // Each output depends on the input of its own number.
    assert!(xml.contains("<Unknown index=\"6\" dependencies=\"1\"/>\n      <Unknown index=\"7\" dependencies=\"2\"/>"));
}

/// Declarations that contradict themselves.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Wrong(Arms);

impl Declare for Wrong {
    const INFO: Info = Info { name: "Wrong", description: "Contradicts itself", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|_| ());
        variables.input_array("u", |m| &mut m.0.command).ramp_array(|m| &mut m.0.wrong).description("Input");
        variables
            .output("y", outputs, |m| &mut m.0.sampled)
            .rate(outputs, |m| &mut m.0.slope[0])
            .discrete()
            .tunable()
            .description("Output");
        variables.parameter("p", |m| &mut m.0.gains[0]).discrete().description("Parameter");
        variables.parameter("q", |m| &mut m.0.gains[1]).unit("N.m/rad").display_degrees().description("Stiffness");
        variables.parameter("r", |m| &mut m.0.gains[2]).unit("furlong").description("Length");
    }
}

impl Model for Wrong {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

#[test]
fn what_contradicts_itself_is_listed() {
    let problems = describe::<Wrong>().unwrap_err().problems;
    let expected = [
        "variable u[1]: it is one of 2, but there are 3 slopes",
        "variable u[2]: it is one of 2, but there are 3 slopes",
        "variable y is discrete: it can have no ramp or rate",
        "variable y: only a parameter is tunable",
        "variable p: a parameter is fixed or tunable, not discrete",
        "variable q: degrees are shown of angles and their rates, so say a unit such as rad/s before",
        "variable r: unit \"furlong\": \"furlong\" is not understood; write e.g. \"kg.m2/s\", or spell the unit out with Unit::new",
    ];
    assert_eq!(problems, expected);
}

/// States and time derivatives that do not belong together.
#[derive(Clone, Default, Serialize, Deserialize)]
struct WrongStates(Arms);

impl Declare for WrongStates {
    const INFO: Info = Info { name: "WrongStates", description: "Contradicts itself", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|_| ());
        variables.output_array("x", outputs, |m| &mut m.0.torque).state().unit("m").description("State");
        variables
            .local_array("v[{}]", outputs, |m| &mut m.0.torque_rate)
            .derivative_of("x[{}]")
            .unit("m")
            .depends_on_states(["w"])
            .description("Rate");
        variables.local("v", outputs, |m| &mut m.0.start[0]).derivative_of("x[1]").description("Rate");
        variables.local("a", outputs, |m| &mut m.0.start[1]).derivative_of("v").description("Rate");
        variables.input("u", |m| &mut m.0.command[0]).state().description("Input");
        variables.output("s", outputs, |m| &mut m.0.sampled).discrete().state().description("Sampled");
    }
}

impl Model for WrongStates {
    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

impl ModelExchange for WrongStates {}

#[test]
fn states_without_derivatives_and_derivatives_of_nothing_are_listed() {
    let mut problems = describe::<WrongStates>().unwrap_err().problems;
    problems.sort();
    let expected = [
        "state s has no derivative",
        "state u has no derivative",
        "the unit m of v[1] is not that of x[1], m, per second",
        "the unit m of v[2] is not that of x[2], m, per second",
        "variable a is the derivative of v, which is not a state",
        "variable s is no continuous output or local variable: it can be no state and no derivative of one",
        "variable u is no continuous output or local variable: it can be no state and no derivative of one",
        "variable v[1] depends on w, which is not a state",
        "variable v[2] depends on w, which is not a state",
        "variables v[1] and v are both the derivative of x[1]",
    ];
    assert_eq!(problems, expected);
}
