//! The tuned gains on the plant of `grasp-plant`: what the shipped gains promise, at the cost of a unit test.

#![allow(clippy::float_cmp)]

use grasp_control::laws::nabfc::{Estimates, Gains, Nabfc};
use grasp_control::{Arms, Commands, Inputs, Law, Measurements, References};
use grasp_plant::{Measured, Parameters};

/// Loads that do not vanish at rest.
#[derive(Debug, Clone, Copy, Default)]
struct Disturbance {
    hub_torque: [f64; 2],
    object_force: f64,
    /// Coulomb friction of the hubs, smoothed below 5 mrad/s \[N·m\].
    friction: f64,
    /// A torque proportional to the hub angle \[N·m/rad\].
    position_load: f64,
}

/// The grasp at rest with straight arms, and loads on it.
#[derive(Debug, Clone)]
struct Plant {
    plant: grasp_plant::Plant,
    disturbance: Disturbance,
}

impl Plant {
    fn at_rest(object_mass: f64, disturbance: Disturbance) -> Self {
        let parameters = Parameters { object_mass, ..Parameters::default() };
        Self { plant: grasp_plant::Plant::new(parameters).unwrap(), disturbance }
    }

    /// The commands and the loads of this moment.
    fn inputs(&self, commands: &Commands) -> grasp_plant::Inputs {
        let (d, measured) = (&self.disturbance, self.plant.measured());
        let load = |arm: usize| {
            d.hub_torque[arm] - d.friction * (measured.theta_dot[arm] / 0.005).tanh()
                + d.position_load * measured.theta[arm]
        };
        grasp_plant::Inputs {
            torque_command: commands.tau,
            force_command: commands.u,
            hub_disturbance: [load(0), load(1)],
            object_disturbance: d.object_force,
        }
    }

    /// The multipliers λᵢ of (13) and (14).
    fn multipliers(&self, commands: &Commands) -> [f64; 2] {
        self.plant.direct(&self.inputs(commands)).lambda
    }

    fn measure(&self, reference: References) -> Inputs {
        let Measured { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot } =
            self.plant.measured();
        let root_moment_dot = self.plant.uncertainty().root_moment_dot;
        let measured = Measurements {
            theta,
            theta_dot,
            y_object,
            y_object_dot,
            root_moment,
            tip_shear,
            tip_shear_dot,
            root_moment_dot,
        };
        Inputs { measured, reference }
    }

    /// Exact for the commands, which are held. The loads follow the motion every 0.1 ms: friction has a time constant of
    /// J·(5 mrad/s)/(20 mN·m) = 1.8 ms at the least.
    fn step(&mut self, h: f64, commands: &Commands) {
        let parts = (h / 1e-4).round();
        let mut part = 0.0;
        while part < parts {
            let inputs = self.inputs(commands);
            self.plant.step(h / parts, &inputs, &grasp_plant::Inputs::ZERO).unwrap();
            part += 1.0;
        }
    }
}

/// When a command acts that was computed from the measurements at t.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Coupling {
    /// From t on.
    GaussSeidel,
    /// One step later.
    Jacobi,
}

#[derive(Debug)]
struct Outcome {
    settling: f64,
    overshoot: f64,
    peak: Commands,
    /// Largest relative force error in the last quarter.
    late_error: f64,
    halfway: Estimates,
    last: Estimates,
}

fn run(gains: &Gains, mut plant: Plant, h: f64, duration: f64, coupling: Coupling) -> Outcome {
    let reference = References::default();
    let target = [reference.lambda1_ref, -reference.lambda1_ref];
    let mut law = Nabfc::new(Arms::default(), *gains).unwrap();
    law.initialize(&plant.measure(reference));
    let mut held = Commands::default();
    let mut outcome = Outcome {
        settling: 0.0,
        overshoot: 0.0,
        peak: Commands::default(),
        late_error: 0.0,
        halfway: Estimates::default(),
        last: Estimates::default(),
    };
    let mut time = 0.0;
    while time < duration {
        let inputs = plant.measure(reference);
        let fresh = law.commands(&inputs);
        let commands = if coupling == Coupling::GaussSeidel { fresh } else { held };
        for (lambda, target) in plant.multipliers(&commands).into_iter().zip(target) {
            let error = lambda / target - 1.0;
            assert!(error.is_finite());
            outcome.overshoot = outcome.overshoot.max(error);
            if error.abs() > 0.02 {
                outcome.settling = time + h;
            }
            if time > 0.75 * duration {
                outcome.late_error = outcome.late_error.max(error.abs());
            }
        }
        for arm in 0..2 {
            outcome.peak.tau[arm] = outcome.peak.tau[arm].max(fresh.tau[arm].abs());
        }
        outcome.peak.u = outcome.peak.u.max(fresh.u.abs());
        law.step(h, &inputs, &Inputs::HELD).unwrap();
        held = law.commands(&inputs);
        plant.step(h, &commands);
        if time < 0.5 * duration {
            outcome.halfway = law.estimates();
        }
        time += h;
    }
    outcome.last = law.estimates();
    outcome
}

fn every_coupling() -> impl Iterator<Item = (f64, Coupling)> {
    [1e-4, 1e-3].into_iter().flat_map(|h| [Coupling::GaussSeidel, Coupling::Jacobi].map(|coupling| (h, coupling)))
}

#[test]
fn the_default_settles_in_time_without_overshoot() {
    for (h, coupling) in every_coupling() {
        let outcome = run(&Gains::default(), Plant::at_rest(0.3, Disturbance::default()), h, 1.0, coupling);
        assert!(outcome.settling < 0.33, "{h} {coupling:?} {outcome:?}");
        assert!(outcome.overshoot < 0.005, "{h} {coupling:?} {outcome:?}");
        assert!(outcome.peak.u < 0.3 && outcome.peak.tau.iter().all(|tau| *tau < 2.0), "{outcome:?}");
    }
}

#[test]
fn the_fast_preset_is_twice_as_fast() {
    for (h, coupling) in every_coupling() {
        let outcome = run(&Gains::fast(), Plant::at_rest(0.3, Disturbance::default()), h, 1.0, coupling);
        assert!(outcome.settling < 0.18, "{h} {coupling:?} {outcome:?}");
        assert!(outcome.overshoot < 0.01, "{h} {coupling:?} {outcome:?}");
        assert!(outcome.peak.u < 0.3 && outcome.peak.tau.iter().all(|tau| *tau < 2.0), "{outcome:?}");
    }
}

#[test]
fn light_and_heavy_objects_settle() {
    for object_mass in [0.05, 1.0, 2.0] {
        let outcome =
            run(&Gains::default(), Plant::at_rest(object_mass, Disturbance::default()), 1e-3, 1.5, Coupling::Jacobi);
        assert!(outcome.settling < 0.5, "M = {object_mass}: {outcome:?}");
    }
}

/// What the networks are for: loads that do not vanish leave at most half the force error that they leave without
/// networks (in fact less than a tenth), and the weights come to rest.
#[test]
fn networks_take_over_lasting_disturbances() {
    let none = Disturbance::default();
    let disturbances = [
        Disturbance { hub_torque: [0.02, -0.02], object_force: 0.05, ..none },
        Disturbance { hub_torque: [0.02, 0.02], object_force: -0.05, ..none },
        Disturbance { position_load: 0.4, ..none },
        Disturbance { friction: 0.02, hub_torque: [0.01, 0.0], object_force: 0.03, ..none },
    ];
    for gains in [Gains::default(), Gains::fast()] {
        for disturbance in disturbances {
            let plant = Plant::at_rest(0.3, disturbance);
            // a₃ a₄ = 0.2 1/s: half of the time is six of their time constants.
            let with = run(&gains, plant.clone(), 1e-3, 60.0, Coupling::GaussSeidel);
            // Without, nothing is that slow.
            let without = run(&gains.without_networks(), plant, 1e-3, 20.0, Coupling::GaussSeidel);
            assert!(without.late_error > 5e-3, "{disturbance:?} is no test");
            assert!(with.late_error < 0.1 * without.late_error, "{disturbance:?} {with:?} {without:?}");
            let norms = |e: &Estimates| [e.w_norm, e.u_norm[0], e.u_norm[1]];
            for (last, halfway) in norms(&with.last).into_iter().zip(norms(&with.halfway)) {
                assert!((last - halfway).abs() < 0.02 * halfway + 1e-3, "{disturbance:?} {with:?}");
            }
        }
    }
}
