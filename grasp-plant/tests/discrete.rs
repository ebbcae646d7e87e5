//! Steps against the motion of the same discrete plant to forty digits, from `tests/oracle/discrete.py`.
//!
//! Both use the same polynomials, so the differences are rounding: of the matrices as they are put together, of the modes, and
//! of the steps.

#![allow(clippy::doc_markdown)]

use grasp_plant::{ActuatorModel, Arm, Inputs, Parameters, Plant};
use serde_json::Value;
use std::collections::BTreeMap;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
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

/// The largest differences at the ends of the motion's parts, each made in `steps` equal steps, relative to the largest value of the
/// output there, by name.
fn errors(reference: &Value, motion: &Value, steps: u32) -> BTreeMap<&'static str, f64> {
    let mut plant = Plant::new(parameters(&reference["plant"])).expect("valid");
    let start = plant.measured().y_object;
    let mut extremes = BTreeMap::<&str, (f64, f64)>::new();
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
                let (error, size) = extremes.entry(name).or_default();
                (*error, *size) = (error.max((found - exact).abs()), size.max(exact.abs()));
            }
        }
    }
    extremes.into_iter().map(|(name, (error, size))| (name, error / size)).collect()
}

/// Measured errors, and what they are bounded by: a few rounding units for what is slow; the fastest modes turn by 10⁵ rad, and their
/// frequencies have the rounding of the matrices, so shears that vibrate undamped have 1e-13, their rates 5e-11. At order 24 these
/// rates are those of modes up to 10⁸ rad/s that have died, but for their rounding.
#[test]
fn steps_are_exact_to_rounding() {
    let references: Value = serde_json::from_str(include_str!("data/discrete.json")).expect("the file is JSON");
    for reference in references["plants"].as_array().expect("a list") {
        for steps in [1, 100] {
            let errors = errors(reference, &references["motion"], steps);
            println!("order {} in {steps} steps", reference["plant"]["order"]);
            for (name, error) in errors {
                println!("  {name} {error:.1e}");
                let bound = match name {
                    "tip_shear" => 3e-13,
                    "tip_shear_dot" => 3e-10,
                    "y_object_dot" => 3e-14,
                    _ => 1.5e-14,
                };
                // Viscous without uncertainties: by dense matrices, whose fastest motion has norms of 1e9/s.
                let dense = number(&reference["plant"]["kelvin_voigt"]) > 0.0
                    && number(&reference["plant"]["root_uncertainty"]) == 0.0;
                let bound = if dense { 1e4 * bound } else { bound };
                assert!(error < bound, "{name} in {steps}: {error:e}, {}", reference["plant"]);
            }
        }
    }
}
