//! Steps against the motion of the same discrete plant to forty digits, from `tests/oracle/discrete.py`.
//!
//! Both use the same polynomials, so the differences are rounding: of the matrices as they are put together, of the modes, and
//! of the steps.

#![allow(clippy::doc_markdown)]

use grasp_plant::{ActuatorModel, Arm, Inputs, Parameters, Plant};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

fn references() -> Value {
    serde_json::from_str(include_str!("data/discrete.json")).expect("the file is JSON")
}

fn parameters(plant: &Value) -> Parameters {
    let arm = |i: usize| Arm {
        ei: number(&plant["arms"][i]["ei"]),
        rho: number(&plant["arms"][i]["rho"]),
        hub_inertia: number(&plant["arms"][i]["hub_inertia"]),
        tip_mass: number(&plant["arms"][i]["tip_mass"]),
    };
    Parameters {
        arms: [arm(0), arm(1)],
        length: number(&plant["length"]),
        object_mass: number(&plant["object_mass"]),
        root_uncertainty: number(&plant["root_uncertainty"]),
        tip_uncertainty: number(&plant["tip_uncertainty"]),
        kelvin_voigt: number(&plant["kelvin_voigt"]),
        order: usize::try_from(plant["order"].as_u64().expect("an order")).expect("small"),
        actuator_model: ActuatorModel::Ideal,
        ..Parameters::default()
    }
}

fn inputs(forces: &Value) -> Inputs {
    let [first, second, object]: [f64; 3] = numbers(forces).try_into().expect("three forces");
    Inputs { torque_command: [first, second], force_command: object, ..Inputs::ZERO }
}

/// The largest difference of any output at the ends of the motion's parts, each made in `steps` equal steps, relative to the
/// output's largest value there.
fn error(reference: &Value, motion: &Value, steps: u32) -> f64 {
    let parameters = parameters(&reference["plant"]);
    let mut plant = Plant::new(parameters).expect("valid");
    let start = plant.measured().y_object;
    let mut sizes = std::collections::BTreeMap::<&str, f64>::new();
    let mut errors = std::collections::BTreeMap::<&str, f64>::new();
    let parts = motion.as_array().expect("a list").iter().zip(reference["ends"].as_array().expect("a list"));
    for (part, end) in parts {
        let (first, rates) = (inputs(&part["forces"]), inputs(&part["rates"]));
        let h = number(&part["duration"]) / f64::from(steps);
        for i in 0..steps {
            let t = f64::from(i) * h;
            let now = Inputs {
                torque_command: [0, 1].map(|a| first.torque_command[a] + t * rates.torque_command[a]),
                force_command: first.force_command + t * rates.force_command,
                ..Inputs::ZERO
            };
            plant.step(h, &now, &rates).expect("a step");
        }
        let m = plant.measured();
        let found: [(&str, &[f64]); 10] = [
            ("theta", &m.theta),
            ("theta_dot", &m.theta_dot),
            ("y_object", &[m.y_object - start]),
            ("y_object_dot", &[m.y_object_dot]),
            ("root_moment", &m.root_moment),
            ("tip_shear", &m.tip_shear),
            ("tip_shear_dot", &m.tip_shear_dot),
            ("tip_deflection", &plant.tip_deflection()),
            ("energy", &[plant.energy()]),
            ("supplied_energy", &[plant.supplied_energy()]),
        ];
        for (name, found) in found {
            for (found, exact) in found.iter().zip(numbers(&end[name])) {
                let (size, error) = (sizes.entry(name).or_default(), errors.entry(name).or_default());
                *size = size.max(exact.abs());
                *error = error.max((found - exact).abs());
            }
        }
    }
    for (name, error) in &errors {
        print!("{name} {:.1e}  ", error / sizes[name]);
    }
    println!();
    errors.iter().map(|(name, error)| error / sizes[name]).fold(0.0, f64::max)
}

#[test]
fn steps_are_exact_to_rounding() {
    let references = references();
    for reference in references["plants"].as_array().expect("a list") {
        for steps in [1, 100] {
            println!("{} in {steps}", reference["plant"]);
            let error = error(reference, &references["motion"], steps);
            println!("  worst {error:.1e}");
        }
    }
}
