//! Motion against exact solutions: step response, statics, hold and ramp.

#![allow(clippy::doc_markdown)]

use grasp_plant::{ActuatorModel, Inputs, Parameters, Plant, Start, State};

const TORQUE_STEP: Inputs = Inputs { torque_command: [0.05, 0.0], ..Inputs::ZERO };

/// Response to 0.05 N·m on hub 1 at t = 0.05 s with the uncertainties of Section IV.
///
/// The exact value is the sum of the residues at the roots of the characteristic equation. Of the antisymmetric part,
/// whose modes all decay with about 15.75 1/s, 120 are summed: with three, θ_1 is off by 7e-10 and `M_1` by 3e-8. The
/// symmetric part decays with about 100 1/s and converges at once; `y_M` belongs to it.
#[test]
fn step_response_is_the_exact_one() {
    let (theta_symmetric, theta_antisymmetric) = (0.003_056_529_976_094_01, 0.002_856_083_243_519_32);
    let (moment_symmetric, moment_antisymmetric) = (0.003_933_700_229_6, 0.004_943_898_689_94);
    // Tolerances: the part of the modes beyond the order's reach, measured; it falls with the order.
    for (order, theta_tolerance, moment_tolerance) in [(8, 3e-10, 5e-8), (12, 3e-11, 3e-8), (24, 2e-12, 4e-9)] {
        let mut plant = Plant::new(Parameters { order, ..Parameters::default() }).unwrap();
        plant.step(0.05, &TORQUE_STEP, &Inputs::ZERO).unwrap();
        let m = plant.measured();
        let errors = [
            m.theta[0] - (theta_symmetric + theta_antisymmetric),
            m.theta[1] - (theta_symmetric - theta_antisymmetric),
            m.root_moment[0] - (moment_symmetric + moment_antisymmetric),
            m.root_moment[1] - (moment_symmetric - moment_antisymmetric),
            m.y_object - 0.05 - 0.000_159_421_280_771_27,
        ];
        println!("{order}: {errors:?}");
        assert!(errors[..2].iter().all(|error| error.abs() < theta_tolerance), "order {order}: {errors:?}");
        assert!(errors[2..4].iter().all(|error| error.abs() < moment_tolerance), "order {order}: {errors:?}");
        // Rounding of the propagator, which grows with the stiffness of the uncertainties at high order.
        assert!(errors[4].abs() < 5e-13, "order {order}: {errors:?}");
        // 13 decimals are given, and rounding as for y.
        let symmetric = f64::midpoint(m.root_moment[0], m.root_moment[1]) - moment_symmetric;
        assert!(symmetric.abs() < 1e-12, "order {order}: {symmetric:e}");
    }
}

#[test]
fn hold_steps_compose() {
    for h in [1e-6, 1e-4, 1e-3, 0.02] {
        let mut twice = Plant::new(Parameters::default()).unwrap();
        let mut once = twice.clone();
        for plant in [&mut twice, &mut once] {
            plant.step(0.01, &TORQUE_STEP, &Inputs::ZERO).unwrap();
        }
        let inputs = Inputs { torque_command: [-0.3, 0.7], force_command: 0.1, ..Inputs::ZERO };
        twice.step(h, &inputs, &Inputs::ZERO).unwrap();
        twice.step(h, &inputs, &Inputs::ZERO).unwrap();
        once.step(2.0 * h, &inputs, &Inputs::ZERO).unwrap();
        let scale = once.energy().sqrt();
        for (two, one) in twice.energy_coordinates().iter().zip(once.energy_coordinates()) {
            assert!((two - one).abs() < 1e-13 * scale, "h {h}: {:e}", two - one);
        }
        assert!((twice.supplied_energy() - once.supplied_energy()).abs() < 1e-14);
    }
}

/// Held steps follow a ramp with an error of second order in their size when they take its value in their middle.
#[test]
fn ramps_are_the_limit_of_fine_holds() {
    let h = 0.01;
    let inputs = Inputs { torque_command: [0.1, -0.05], ..Inputs::ZERO };
    let rates = Inputs { torque_command: [30.0, 5.0], force_command: -12.0, ..Inputs::ZERO };
    for actuator_model in [ActuatorModel::Ideal, ActuatorModel::Compensated, ActuatorModel::Raw] {
        let start = Plant::new(Parameters { actuator_model, ..Parameters::default() }).unwrap();
        let mut exact = start.clone();
        exact.step(h, &inputs, &rates).unwrap();
        let error = |pieces: u32| {
            let mut plant = start.clone();
            let piece = h / f64::from(pieces);
            for i in 0..pieces {
                let t = (f64::from(i) + 0.5) * piece;
                let held = Inputs {
                    torque_command: [0, 1].map(|a| inputs.torque_command[a] + rates.torque_command[a] * t),
                    force_command: rates.force_command * t,
                    ..Inputs::ZERO
                };
                plant.step(piece, &held, &Inputs::ZERO).unwrap();
            }
            let work = (plant.supplied_energy() - exact.supplied_energy()).abs();
            let motion = plant.energy_coordinates().into_iter().zip(exact.energy_coordinates());
            (motion.map(|(p, e)| (p - e).powi(2)).sum::<f64>().sqrt(), work)
        };
        let (coarse, fine) = (error(200), error(2000));
        println!("{actuator_model:?}: {coarse:?} {fine:?}");
        let scale = exact.energy().sqrt();
        // Kinks inside a piece spoil the factor of 100 a little.
        assert!(fine.0 < coarse.0 / 30.0 && fine.0 < 1e-6 * scale, "{actuator_model:?}: {coarse:?} {fine:?}");
        assert!(fine.1 < coarse.1 / 30.0 + 1e-13 && fine.1 < 1e-6 * exact.supplied_energy().abs());
    }
}

/// Under the torques and the start of (16), the static target is an equilibrium with the paper's numbers.
#[test]
fn static_target_of_eq_16_is_an_equilibrium() {
    let (lambda, theta, l, ei): (f64, f64, f64, f64) = (-0.5, 3f64.to_radians(), 0.2, 0.115);
    let theta_2 = theta + lambda * l * l / 3.0 * (2.0 / ei);
    let y = l * theta + l.powi(3) * lambda / (3.0 * ei) + 0.05;
    assert!((theta_2 + 0.063_582_151).abs() < 1e-9 && (y - 0.048_877_773).abs() < 1e-9);
    let start = Start { theta: [theta, theta_2], y_object: y, ..Start::default() };
    let mut plant = Plant::new(Parameters { start, ..Parameters::default() }).unwrap();
    let hold = Inputs { torque_command: [-lambda * l, lambda * l], ..Inputs::ZERO };
    let before = plant.measured();
    for _ in 0..1000 {
        plant.step(1e-3, &hold, &Inputs::ZERO).unwrap();
    }
    let after = plant.measured();
    for arm in 0..2 {
        assert!((after.theta[arm] - before.theta[arm]).abs() < 1e-14);
        assert!(after.theta_dot[arm].abs() < 1e-13);
    }
    let direct = plant.direct(&hold);
    assert!((direct.lambda[0] - lambda).abs() < 1e-12 && (direct.lambda[1] + lambda).abs() < 1e-12);
    assert!((direct.contact_force[0] - 0.5).abs() < 1e-12 && (direct.contact_force[1] - 0.5).abs() < 1e-12);
    assert!(direct.in_contact());
    for (arm, lambda) in direct.lambda.into_iter().enumerate() {
        for (point, w) in plant.deflection()[arm].into_iter().enumerate() {
            let x = l * point as f64 / 10.0;
            let exact = lambda * x * x / (2.0 * ei) * (x / 3.0 - l);
            assert!((w - exact).abs() < 1e-14);
        }
        assert!((plant.tip_deflection()[arm] - plant.deflection()[arm][10]).abs() < 1e-17);
    }
}

/// A plant at rest touches without pressing, and stays at rest, exactly.
#[test]
fn rest_is_rest() {
    let mut plant = Plant::new(Parameters::default()).unwrap();
    let before = plant.state().clone();
    plant.step(1.0, &Inputs::ZERO, &Inputs::ZERO).unwrap();
    // Nothing moves; that a step of this size was done, in modal coordinates, is all that is new.
    assert!(before.coordinates.iter().chain(&plant.state().coordinates).all(|x| *x == 0.0));
    let State { basis, coordinates, sizes, .. } = plant.state().clone();
    assert_eq!(*plant.state(), State { basis, coordinates, sizes, ..before });
    assert!(!plant.direct(&Inputs::ZERO).in_contact());
}
