//! Invariants over long runs: energy, momentum, constraint.

#![allow(clippy::doc_markdown)]

use grasp_plant::{Inputs, Parameters, Plant, Start};

fn conservative() -> Parameters {
    Parameters { root_uncertainty: 0.0, tip_uncertainty: 0.0, ..Parameters::default() }
}

/// PD control (97)(98) towards the static target of (16), with a shaking disturbance: keeps the actuators busy.
fn drive(plant: &Plant, t: f64) -> Inputs {
    let m = plant.measured();
    let (e_1, e_2, p) = (m.theta[0] - 0.052_36, m.theta[1] + 0.063_58, m.y_object - 0.048_88);
    let torque = |e: f64, rate: f64, moment: f64| -6.0 * e - 0.3 * rate + moment;
    Inputs {
        torque_command: [torque(e_1, m.theta_dot[0], m.root_moment[0]), torque(e_2, m.theta_dot[1], m.root_moment[1])],
        force_command: -10.0 * p - 2.0 * m.y_object_dot + m.tip_shear[0] + m.tip_shear[1],
        hub_disturbance: [0.02 * (17.0 * t).sin(), 0.01 * (562.0 * t).cos()],
        object_disturbance: 0.05 * (3.0 * t).sin(),
    }
}

/// energy − supplied energy, and the constraint, over `steps` driven steps of 0.1 ms.
fn run(parameters: Parameters, steps: u32) -> (f64, f64, Plant) {
    let mut plant = Plant::new(parameters).unwrap();
    let start = plant.energy();
    let (mut drift, mut constraint) = (0.0f64, 0.0f64);
    for i in 0..steps {
        let inputs = drive(&plant, f64::from(i) * 1e-4);
        plant.step(1e-4, &inputs, &Inputs::ZERO).unwrap();
        drift = drift.max((plant.energy() - start - plant.supplied_energy()).abs());
        constraint = plant.constraint().into_iter().fold(constraint, |worst, value| worst.max(value.abs()));
    }
    (drift, constraint, plant)
}

#[test]
fn driven_motion_balances_energy_and_keeps_the_constraint() {
    for order in [4, 8, 12, 24] {
        let (drift, constraint, plant) = run(Parameters { order, ..conservative() }, 100_000);
        println!("order {order}: {drift:.1e} J, {constraint:.1e} m, energy {:.1e}", plant.energy());
        assert!(drift < 1e-12, "order {order}: {drift:e} J");
        assert!(constraint < 1e-12, "order {order}: {constraint:e} m");
        let parameters = Parameters { order, kelvin_voigt: 1e-5, ..Parameters::default() };
        let (_, constraint, _) = run(parameters, 100_000);
        println!("order {order} with uncertainties: {constraint:.1e} m");
        assert!(constraint < 1e-12, "order {order} with uncertainties: {constraint:e} m");
    }
}

/// Ten million steps, a thousand seconds.
#[test]
#[ignore = "takes several seconds; run with --ignored"]
fn ten_million_steps_drift_little() {
    let (drift, constraint, _) = run(conservative(), 10_000_000);
    println!("1e7 steps: {drift:e} J, {constraint:e} m");
    assert!(drift < 1e-10 && constraint < 1e-11);
}

/// The grasp as a whole: Σ(J θ̇ + ∫ρ x v dx) + m l ẏ is changed only by τ_1 + τ_2 + l u (forces do work on the rigid
/// motion θ_1 = θ_2 = y/l only).
#[test]
fn momentum_changes_by_the_applied_forces_alone() {
    let start = Start { theta_dot: [0.3, -0.2], y_object_dot: 0.05, ..Start::default() };
    let mut plant = Plant::new(Parameters { start, ..conservative() }).unwrap();
    // The power of a rigid motion of unit rate is the momentum's derivative: the last coordinate of x is −momentum/√I.
    let p = plant.parameters().clone();
    let beams: f64 = p.arms.iter().map(|arm| arm.rho * p.length.powi(3) / 3.0 + arm.hub_inertia).sum();
    let inertia = beams + p.moving_mass() * p.length * p.length;
    let momentum = |plant: &Plant| -plant.energy_coordinates().last().unwrap() * inertia.sqrt();
    let before = momentum(&plant);
    for _ in 0..10_000 {
        plant.step(1e-4, &Inputs::ZERO, &Inputs::ZERO).unwrap();
    }
    assert_eq!(momentum(&plant).to_bits(), before.to_bits(), "free motion");
    let inputs = Inputs { torque_command: [0.02, -0.05], force_command: 0.1, ..Inputs::ZERO };
    for _ in 0..10_000 {
        plant.step(1e-4, &inputs, &Inputs::ZERO).unwrap();
    }
    let impulse = 0.02 - 0.05 + p.length * 0.1;
    assert!((momentum(&plant) - before - impulse).abs() < 1e-14);
}

/// What a free plant loses, the Kelvin–Voigt damping takes: energy never rises, and vibration dies.
#[test]
fn kelvin_voigt_dissipates() {
    let start = Start { theta: [0.1, -0.05], theta_dot: [1.0, 0.5], ..Start::default() };
    let mut plant = Plant::new(Parameters { kelvin_voigt: 1e-2, start, ..conservative() }).unwrap();
    let mut energy = plant.energy();
    for _ in 0..20_000 {
        plant.step(1e-3, &Inputs::ZERO, &Inputs::ZERO).unwrap();
        assert!(plant.energy() <= energy * (1.0 + 1e-15), "{} after {energy}", plant.energy());
        energy = plant.energy();
    }
    // Only the rigid motion is left.
    let rigid = plant.energy_coordinates().last().unwrap().powi(2) / 2.0;
    assert!((energy - rigid).abs() < 1e-9 * energy);
    assert!(plant.measured().tip_shear.iter().all(|shear| shear.abs() < 1e-6));
}

/// Both uncertainties of Section IV take energy from a grasp that vibrates symmetrically (ΔF does not feel the rest).
#[test]
fn uncertainties_dissipate() {
    for (root, tip) in [(0.1, 0.0), (0.0, 0.05), (0.1, 0.05)] {
        let start = Start { theta: [0.1, 0.1], ..Start::default() };
        let parameters = Parameters { root_uncertainty: root, tip_uncertainty: tip, start, ..Parameters::default() };
        let mut plant = Plant::new(parameters).unwrap();
        let before = plant.energy();
        plant.step(5.0, &Inputs::ZERO, &Inputs::ZERO).unwrap();
        let vibration = plant.energy() - plant.energy_coordinates().last().unwrap().powi(2) / 2.0;
        assert!(vibration.abs() < 1e-3 * before, "{root} {tip}: {vibration} of {before}");
        assert!(plant.supplied_energy() == 0.0);
    }
}
