//! The plant as differential equations: the same plant as its exact steps, its derivatives, and where they break.

#![allow(clippy::doc_markdown)]

use crate::equations::{derivatives, flat, outputs, states};
use crate::integrator::{System, integrate};
use grasp_plant::{ActuatorModel, Arm, Inputs, Parameters, Plant, Start, StateError};
use proptest::prelude::*;

/// Every branch of the set-up: damped and skew, equal and unequal arms, every actuator.
fn plants() -> [Parameters; 4] {
    let conservative = Parameters { root_uncertainty: 0.0, tip_uncertainty: 0.0, ..Parameters::default() };
    let stiff = Arm { ei: 0.4, hub_inertia: 0.01, ..Arm::default() };
    let start = Start { theta: [0.02, -0.01], theta_dot: [0.3, -0.2], y_object: 0.051, y_object_dot: 0.02 };
    [
        Parameters { start, ..Parameters::default() },
        Parameters { order: 4, actuator_model: ActuatorModel::Ideal, ..conservative.clone() },
        Parameters {
            order: 6,
            arms: [Arm::default(), stiff],
            start,
            actuator_model: ActuatorModel::Raw,
            ..conservative
        },
        Parameters { order: 5, kelvin_voigt: 1e-4, length: 0.3, start, ..Parameters::default() },
    ]
}

const INPUTS: Inputs = Inputs {
    torque_command: [0.35, 2.7],
    force_command: -0.2,
    hub_disturbance: [0.01, -0.02],
    object_disturbance: 0.03,
};

/// A plant somewhere in its motion.
fn moving(parameters: Parameters) -> Plant {
    let mut plant = Plant::new(parameters).unwrap();
    plant.step(0.01, &INPUTS, &Inputs::ZERO).unwrap();
    plant
}

/// The plant with inputs that ramp.
struct Ramped {
    plant: Plant,
    inputs: Inputs,
    rates: Inputs,
}

fn along(inputs: &Inputs, rates: &Inputs, t: f64) -> Inputs {
    let pair = |a: [f64; 2], b: [f64; 2]| [a[0] + t * b[0], a[1] + t * b[1]];
    Inputs {
        torque_command: pair(inputs.torque_command, rates.torque_command),
        force_command: inputs.force_command + t * rates.force_command,
        hub_disturbance: pair(inputs.hub_disturbance, rates.hub_disturbance),
        object_disturbance: inputs.object_disturbance + t * rates.object_disturbance,
    }
}

impl System for Ramped {
    fn rates(&mut self, time: f64, x: &[f64], out: &mut [f64]) {
        self.plant.set_continuous_states(x).unwrap();
        self.plant.derivatives(&along(&self.inputs, &self.rates, time), out);
    }

    fn scales(&self) -> Vec<f64> {
        Plant::state_variables(self.plant.parameters().order).iter().map(|state| state.nominal).collect()
    }

    fn indicators(&mut self, time: f64, x: &[f64]) -> Vec<f64> {
        self.plant.set_continuous_states(x).unwrap();
        let mut out = vec![0.0; Plant::EVENT_INDICATORS];
        self.plant.event_indicators(&along(&self.inputs, &self.rates, time), &mut out);
        // Contact changes nothing in the motion.
        out.truncate(Plant::EVENT_INDICATORS - 2);
        out
    }
}

/// 20 ms of held inputs, and of ramps through the kinks of the actuators: the exact step and the integrated derivatives agree to
/// 1e-12 (steps to 2e-13 of the states' scales by an estimate of lower order).
#[test]
fn integrated_derivatives_are_the_exact_step() {
    let ramps =
        Inputs { torque_command: [-40.0, 25.0], force_command: 40.0, hub_disturbance: [1.0, 0.0], ..Inputs::ZERO };
    for parameters in plants() {
        for rates in [Inputs::ZERO, ramps] {
            let mut exact = Plant::new(parameters.clone()).unwrap();
            let mut x = states(&exact);
            let mut system = Ramped { plant: exact.clone(), inputs: INPUTS, rates };
            let events = integrate(&mut system, &mut x, 0.0, 0.02, 2e-13);
            exact.step(0.02, &INPUTS, &rates).unwrap();
            for (x, exact) in x.iter().zip(states(&exact)) {
                assert!((x - exact).abs() < 1e-12, "order {}: {:e}", parameters.order, x - exact);
            }
            system.plant.set_continuous_states(&x).unwrap();
            for (found, exact) in system.plant.measured().theta.iter().zip(exact.measured().theta) {
                assert!((found - exact).abs() < 1e-13);
            }
            // The force reaches its limit, and the first torque crosses the bare dead zone.
            assert_eq!(events.is_empty(), rates == Inputs::ZERO || parameters.actuator_model == ActuatorModel::Ideal);
        }
    }
}

/// A ramp meets a limit when arithmetic says.
#[test]
fn limits_are_met_to_rounding() {
    let plant = Plant::new(Parameters::default()).unwrap();
    let mut x = states(&plant);
    let rates = Inputs { torque_command: [130.0, 0.0], ..Inputs::ZERO };
    let mut system = Ramped { plant, inputs: Inputs::ZERO, rates };
    let events = integrate(&mut system, &mut x, 0.0, 0.02, 1e-12);
    assert_eq!(events.len(), 1);
    assert!((events[0] - 2.0 / 130.0).abs() < 1e-15, "{events:?}");
}

#[test]
fn states_come_back_and_give_the_angles() {
    for parameters in plants() {
        let plant = moving(parameters.clone());
        let mut other = Plant::new(parameters.clone()).unwrap();
        assert_eq!(plant.state_count(), Plant::state_variables(parameters.order).len());
        other.set_continuous_states(&states(&plant)).unwrap();
        assert_eq!(states(&other), states(&plant));
        for (one, two) in plant.measured().theta.iter().zip(other.measured().theta) {
            // The exact steps keep (12) to rounding, too.
            assert!((one - two).abs() < 1e-15);
        }
        assert!(other.constraint().iter().all(|residual| residual.abs() < 1e-17));
    }
}

#[test]
fn unusable_states_are_refused_and_change_nothing() {
    let mut plant = moving(Parameters::default());
    let good = states(&plant);
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        for place in [0, 20, good.len() - 2, good.len() - 1] {
            let mut states = good.clone();
            states[place] = bad;
            assert_eq!(plant.set_continuous_states(&states), Err(StateError::NotFinite), "{bad:e} at {place}");
        }
    }
    assert_eq!(plant.set_continuous_states(&good[1..]), Err(StateError::Length { found: 34, expected: 35 }));
    assert_eq!(states(&plant), good);
}

/// The time derivative of every output is its change along the states' derivatives.
#[test]
fn outputs_move_with_the_states() {
    let ramps = Inputs { torque_command: [3.0, 2.0], object_disturbance: 0.7, ..Inputs::ZERO };
    for parameters in plants() {
        let plant = moving(parameters);
        let change = flat(&plant.output_change(&INPUTS, &derivatives(&plant, &INPUTS), &ramps));
        for (change, rate) in change.iter().zip(flat(&plant.rates(&INPUTS, &ramps))) {
            assert!((change - rate).abs() <= 1e-12 * (1.0 + rate.abs()), "{change:e} {rate:e}");
        }
    }
}

#[test]
fn indicators_are_distances_from_kinks_and_contact() {
    let plant = Plant::new(Parameters { actuator_model: ActuatorModel::Raw, ..Parameters::default() }).unwrap();
    let mut found = [0.0; Plant::EVENT_INDICATORS];
    plant.event_indicators(&Inputs { torque_command: [0.1, -2.1], ..Inputs::ZERO }, &mut found);
    let first = [0.1 + 2.1, 0.1 + 0.1, 0.0, 0.1 - 2.1];
    assert_eq!(found[..4], first);
    assert_eq!(found[4], 0.0);
    assert_eq!(found[8..12], [0.31, 0.01, -0.01, -0.31]);
    // At rest the tips only touch.
    assert_eq!(found[12..], [0.0, 0.0]);
    let plant = Plant::new(Parameters { actuator_model: ActuatorModel::Ideal, ..Parameters::default() }).unwrap();
    plant.event_indicators(&INPUTS, &mut found);
    assert_eq!(found[..12], [1.0; 12]);
}

/// How large the terms are of which each derivative is the sum: rounding is a part of them, and not of the sum.
fn term_sizes(plant: &Plant) -> Vec<f64> {
    let x = states(plant);
    let mut sizes: Vec<f64> = derivatives(plant, &INPUTS).iter().map(|rate| 1.0 + rate.abs()).collect();
    let (mut unit, mut column) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    for j in 0..x.len() {
        unit[j] = 1.0;
        plant.derivative_change(&INPUTS, &unit, &Inputs::ZERO, &mut column);
        unit[j] = 0.0;
        for (size, entry) in sizes.iter_mut().zip(&column) {
            *size += (entry * x[j]).abs();
        }
    }
    sizes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Everything is at most quadratic in states and inputs, so central differences with any step are exact up to rounding.
    #[test]
    fn changes_are_differences(which in 0..4_usize, seed in prop::collection::vec(-1.0..1.0_f64, 35 + 6)) {
        let plant = moving(plants()[which].clone());
        let n = plant.state_count();
        let direction: Vec<f64> = seed[..n].iter().map(|x| 0.1 * x).collect();
        let change = Inputs {
            torque_command: [seed[35], seed[36]],
            force_command: seed[37],
            hub_disturbance: [seed[38], seed[39]],
            object_disturbance: seed[40],
        };
        let mut exact = vec![0.0; n];
        plant.derivative_change(&INPUTS, &direction, &change, &mut exact);
        let exact_outputs = flat(&plant.output_change(&INPUTS, &direction, &change));
        // Short enough to stay on one side of every kink.
        let step = 1e-3;
        let at = |sign: f64| {
            let mut moved = plant.clone();
            let x: Vec<f64> = states(&plant).iter().zip(&direction).map(|(x, dx)| x + sign * step * dx).collect();
            moved.set_continuous_states(&x).unwrap();
            let inputs = along(&INPUTS, &change, sign * step);
            (derivatives(&moved, &inputs), outputs(&moved, &inputs))
        };
        let (forward, backward) = (at(1.0), at(-1.0));
        let sizes = term_sizes(&plant);
        for (((plus, minus), exact), size) in forward.0.iter().zip(&backward.0).zip(&exact).zip(&sizes) {
            let difference = (plus - minus) / (2.0 * step);
            let rounding = 32.0 * f64::EPSILON * size / step;
            prop_assert!((difference - exact).abs() < rounding, "{difference:e} {exact:e} {size:e}");
        }
        for ((plus, minus), exact) in forward.1.iter().zip(&backward.1).zip(&exact_outputs) {
            let difference = (plus - minus) / (2.0 * step);
            prop_assert!((difference - exact).abs() < 1e-10 * (1.0 + exact.abs()), "{difference:e} {exact:e}");
        }
    }
}
