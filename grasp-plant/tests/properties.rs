//! Physical laws for arbitrary plants, inputs and step sizes.

#![allow(clippy::doc_markdown)]

use grasp_plant::nalgebra::DMatrix;
use grasp_plant::{ActuatorModel, Arm, Direct, Inputs, Measured, Parameters, Plant, Start, State};
use proptest::prelude::*;

fn logarithmic(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn arm() -> impl Strategy<Value = Arm> {
    (logarithmic(0.01, 10.0), logarithmic(0.01, 1.0), logarithmic(1e-3, 0.1), logarithmic(0.01, 1.0))
        .prop_map(|(ei, rho, hub_inertia, tip_mass)| Arm { ei, rho, hub_inertia, tip_mass })
}

fn start() -> impl Strategy<Value = Start> {
    (prop::array::uniform2(-0.2..0.2f64), prop::array::uniform2(-1.0..1.0f64), 0.03..0.07f64, -0.2..0.2f64)
        .prop_map(|(theta, theta_dot, y_object, y_object_dot)| Start { theta, theta_dot, y_object, y_object_dot })
}

fn actuator_model() -> impl Strategy<Value = ActuatorModel> {
    prop_oneof![Just(ActuatorModel::Ideal), Just(ActuatorModel::Compensated), Just(ActuatorModel::Raw)]
}

/// Plants with unequal arms, of moderate order, without dissipation.
fn conservative() -> impl Strategy<Value = Parameters> {
    (prop::array::uniform2(arm()), 4usize..=12, start(), actuator_model(), 0.1..0.5f64).prop_map(
        |(arms, order, start, actuator_model, length)| Parameters {
            arms,
            order,
            start,
            actuator_model,
            length,
            root_uncertainty: 0.0,
            tip_uncertainty: 0.0,
            ..Parameters::default()
        },
    )
}

/// The same with Kelvin–Voigt damping and the built-in uncertainties.
fn any_plant() -> impl Strategy<Value = Parameters> {
    (conservative(), 0.0..0.1f64, 0.0..0.05f64, 0.0..1e-4f64).prop_map(|(base, root, tip, kelvin_voigt)| Parameters {
        root_uncertainty: root,
        tip_uncertainty: tip,
        kelvin_voigt,
        ..base
    })
}

fn inputs(torque: f64, force: f64) -> impl Strategy<Value = Inputs> {
    (
        prop::array::uniform2(-torque..torque),
        -force..force,
        prop::array::uniform2(-torque / 5.0..torque / 5.0),
        -force / 5.0..force / 5.0,
    )
        .prop_map(|(torque_command, force_command, hub_disturbance, object_disturbance)| Inputs {
            torque_command,
            force_command,
            hub_disturbance,
            object_disturbance,
        })
}

fn after(inputs: &Inputs, rates: &Inputs, t: f64) -> Inputs {
    let pair = |value: [f64; 2], rate: [f64; 2]| [0, 1].map(|i| value[i] + rate[i] * t);
    Inputs {
        torque_command: pair(inputs.torque_command, rates.torque_command),
        force_command: inputs.force_command + rates.force_command * t,
        hub_disturbance: pair(inputs.hub_disturbance, rates.hub_disturbance),
        object_disturbance: inputs.object_disturbance + rates.object_disturbance * t,
    }
}

fn norm(plant: &Plant) -> f64 {
    plant.energy_coordinates().iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance(left: &Plant, right: &Plant) -> f64 {
    let (left, right) = (left.energy_coordinates(), right.energy_coordinates());
    left.iter().zip(right).map(|(l, r)| (l - r).powi(2)).sum::<f64>().sqrt()
}

fn flat(measured: &Measured, direct: &Direct) -> Vec<f64> {
    let m = measured;
    [
        &m.theta[..],
        &m.theta_dot,
        &[m.y_object, m.y_object_dot],
        &m.root_moment,
        &m.tip_shear,
        &m.tip_shear_dot,
        &direct.torque,
        &[direct.force],
        &direct.lambda,
        &direct.contact_force,
    ]
    .concat()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// (12) at the start and ever after; energy balance with held and with ramped, saturating, dead-zoned inputs.
    #[test]
    fn constraint_and_energy_balance(
        parameters in conservative(),
        drives in prop::collection::vec((inputs(3.0, 0.5), inputs(300.0, 50.0), any::<bool>(), logarithmic(1e-6, 0.03)), 1..20),
    ) {
        let mut plant = Plant::new(parameters).unwrap();
        let start = plant.energy();
        let mut largest = start;
        for (inputs, rates, ramped, h) in drives {
            plant.step(h, &inputs, if ramped { &rates } else { &Inputs::ZERO }).unwrap();
            largest = largest.max(plant.energy()).max(plant.supplied_energy().abs());
            let balance = plant.energy() - start - plant.supplied_energy();
            prop_assert!(balance.abs() < 1e-12 * largest, "{balance:e} of {largest}");
            let travel = plant.measured().y_object.abs().max(0.1);
            for value in plant.constraint() {
                prop_assert!(value.abs() < 1e-14 * travel.max(plant.measured().theta[0].abs()), "{value:e}");
            }
        }
    }

    /// A ramp over h is the ramp over its first part and then over the rest, wherever the actuators' kinks lie.
    #[test]
    fn ramps_compose(
        parameters in any_plant(), inputs in inputs(3.0, 0.5), rates in inputs(2000.0, 300.0),
        h in logarithmic(1e-5, 0.01), cut in 0.0..1.0f64,
    ) {
        let mut whole = Plant::new(parameters).unwrap();
        let mut parts = whole.clone();
        let first = (cut * h).max(1e-3 * h);
        prop_assume!(first < h);
        whole.step(h, &inputs, &rates).unwrap();
        parts.step(first, &inputs, &rates).unwrap();
        parts.step(h - first, &after(&inputs, &rates, first), &rates).unwrap();
        let scale = norm(&whole).max(norm(&parts));
        prop_assert!(distance(&whole, &parts) < 1e-11 * scale, "{:e}", distance(&whole, &parts) / scale);
        let work = whole.supplied_energy() - parts.supplied_energy();
        prop_assert!(work.abs() < 1e-10 * scale * scale, "{work:e}");
    }

    /// λ_i as printed in (13) and (14), for any state, with ΔF both built in and external.
    #[test]
    fn multipliers_are_those_of_13_and_14(parameters in any_plant(), push in inputs(3.0, 0.5), inputs in inputs(3.0, 0.5)) {
        let p = Parameters { kelvin_voigt: 0.0, ..parameters };
        let mut plant = Plant::new(p.clone()).unwrap();
        plant.step(0.02, &push, &Inputs::ZERO).unwrap();
        let (shear, direct) = (plant.measured().tip_shear, plant.direct(&inputs));
        let applied = direct.force + inputs.object_disturbance + plant.uncertainty().delta_force;
        let m = p.moving_mass();
        let [m_1, m_2] = p.arms.map(|arm| arm.tip_mass);
        let lambda_1 = (m_1 * applied + (m_2 + p.object_mass) * shear[0] - m_1 * shear[1]) / m;
        let lambda_2 = (m_2 * applied + (m_1 + p.object_mass) * shear[1] - m_2 * shear[0]) / m;
        let tolerance = 1e-13 * (applied.abs() + shear[0].abs() + shear[1].abs());
        prop_assert!((direct.lambda[0] - lambda_1).abs() < tolerance);
        prop_assert!((direct.lambda[1] - lambda_2).abs() < tolerance);
        // (6): the object with its tip masses.
        let rates = plant.rates(&inputs, &Inputs::ZERO);
        let object = applied - direct.lambda[0] - direct.lambda[1] - p.object_mass * rates.measured.y_object_dot;
        prop_assert!(object.abs() < 1e-9 * (1.0 + tolerance / 1e-13), "{object:e}");
        prop_assert!(direct.contact_force[0] + direct.lambda[0] == 0.0 && direct.contact_force[1] - direct.lambda[1] == 0.0);
    }

    /// Time derivatives against central differences of exact steps.
    #[test]
    fn rates_are_the_derivatives(parameters in any_plant(), push in inputs(3.0, 0.5), inputs in inputs(0.09, 0.009), rates in inputs(5.0, 1.0)) {
        // Compensated actuators are linear around these inputs.
        let parameters = Parameters { actuator_model: ActuatorModel::Compensated, ..parameters };
        let mut plant = Plant::new(parameters).unwrap();
        plant.step(0.02, &push, &Inputs::ZERO).unwrap();
        let space = plant.state_space();
        let size = |matrix: &DMatrix<f64>, i: usize| matrix.row(i).iter().map(|entry| entry.abs()).sum::<f64>();
        let norm_a = (0..space.a.nrows()).map(|i| size(&space.a, i)).fold(0.0, f64::max);
        let delta = 1e-2 / norm_a;
        // Outputs at times −2δ … 2δ around the middle.
        let mut samples = Vec::new();
        for i in -2..=2 {
            let t = f64::from(i) * delta;
            let now = after(&inputs, &rates, t);
            let mut values = flat(&plant.measured(), &plant.direct(&now));
            values.extend([plant.energy(), plant.supplied_energy()]);
            samples.push(values);
            if i == 0 {
                let analytic = plant.rates(&now, &rates);
                prop_assert!(analytic.constraint.iter().all(|rate| rate.abs() < 1e-13 * (1.0 + norm(&plant))));
                let mut exact = flat(&analytic.measured, &analytic.direct);
                exact.extend([analytic.energy, analytic.supplied_energy]);
                samples.push(exact);
            }
            plant.step(delta, &now, &rates).unwrap();
        }
        for (i, exact) in samples[3].iter().enumerate() {
            let narrow = (samples[4][i] - samples[1][i]) / (2.0 * delta);
            let wide = (samples[5][i] - samples[0][i]) / (4.0 * delta);
            // The error is cδ², and wide − narrow is 3cδ²; below that, rounding of values that may cancel.
            // Values are sums over the state with the rows of C; λ and the powers contain the shears and their rates.
            let row = if i < 12 { size(&space.c, i) } else { size(&space.c, 8) + size(&space.c, 9) + size(&space.c, 10) + size(&space.c, 11) };
            let rounding = 1e-15 * (1.0 + row) * (1.0 + norm(&plant)) / delta;
            let tolerance = (wide - narrow).abs() + rounding;
            prop_assert!((narrow - exact).abs() < tolerance, "output {i}: {narrow} for {exact}, tolerance {tolerance:e}");
        }
    }

    /// Directional derivatives against central differences; between kinks the direct outputs are linear.
    #[test]
    fn direct_derivatives_are_exact(parameters in any_plant(), inputs in inputs(3.0, 0.5), direction in inputs(1.0, 1.0)) {
        let plant = Plant::new(parameters).unwrap();
        let delta = 1e-4;
        let sample = |t: f64| plant.direct(&after(&inputs, &direction, t));
        let (first, centre, last) = (sample(-delta), sample(0.0), sample(delta));
        let values = |direct: &Direct| flat(&Measured::default(), direct);
        let (first, centre, last) = (values(&first), values(&centre), values(&last));
        let exact = values(&plant.direct_derivative(&inputs, &direction));
        for i in 0..exact.len() {
            let smooth = (first[i] + last[i] - 2.0 * centre[i]).abs() < 1e-12 * (1.0 + centre[i].abs());
            prop_assume!(smooth);
            let difference = (last[i] - first[i]) / (2.0 * delta);
            prop_assert!((difference - exact[i]).abs() < 1e-10 * (1.0 + centre[i].abs()) , "{i}: {difference} {}", exact[i]);
        }
    }

    /// A serialised state continues with the same bits.
    #[test]
    fn states_survive_serialisation(parameters in any_plant(), inputs in inputs(3.0, 0.5), rates in inputs(100.0, 10.0)) {
        let mut plant = Plant::new(parameters).unwrap();
        plant.step(1e-3, &inputs, &rates).unwrap();
        let text = serde_json::to_string(&(plant.parameters(), plant.state())).unwrap();
        let (parameters, state): (Parameters, State) = serde_json::from_str(&text).unwrap();
        let mut copy = Plant::new(parameters).unwrap();
        copy.set_state(&state).unwrap();
        for h in [1e-3, 1e-4, 1e-3] {
            plant.step(h, &inputs, &rates).unwrap();
            copy.step(h, &inputs, &rates).unwrap();
        }
        prop_assert_eq!(plant.state(), copy.state());
        prop_assert_eq!(plant.measured(), copy.measured());
    }
}
