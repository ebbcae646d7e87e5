//! The tuned gains in a closed loop with massless beams: what the shipped gains promise, at the cost of a unit test.
//!
//! A massless beam has the static cubic as its shape at any time: Q = −3EI w(l)/l³ and M(0) = −Q l. Hubs, object, the
//! built-in uncertainties and the actuator limits are the real ones. The beams' own modes are left to the full plant.

#![allow(clippy::float_cmp)]

use grasp_control::Arms;
use grasp_control::Law;
use grasp_control::laws::nabfc::Gains;
use grasp_control::laws::nabfc::{Estimates, Nabfc};
use grasp_control::{Commands, Inputs, Measurements, References};

const EI: f64 = 0.115;
const LENGTH: f64 = 0.2;
const HUB_INERTIA: f64 = 0.0073;
const TIP_MASS: f64 = 0.1;
const ROOT_UNCERTAINTY: f64 = 0.1;
const TIP_UNCERTAINTY: f64 = 0.05;

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

#[derive(Debug, Clone, Copy)]
struct Plant {
    object_mass: f64,
    disturbance: Disturbance,
    /// θ₁, θ₂, `y_M` − L/2.
    position: [f64; 3],
    velocity: [f64; 3],
}

impl Plant {
    fn at_rest(object_mass: f64, disturbance: Disturbance) -> Self {
        Self { object_mass, disturbance, position: [0.0; 3], velocity: [0.0; 3] }
    }

    /// Shear force at a tip from angle and object position, or its rate from the velocities.
    fn shear(of: &[f64; 3], arm: usize) -> f64 {
        -3.0 * EI / LENGTH.powi(3) * (LENGTH * of[arm] - of[2])
    }

    fn acceleration(&self, position: &[f64; 3], velocity: &[f64; 3], commands: &Commands) -> [f64; 3] {
        let d = &self.disturbance;
        let hub = |arm: usize| {
            let (shear, shear_dot) = (Self::shear(position, arm), Self::shear(velocity, arm));
            let load =
                d.hub_torque[arm] - d.friction * (velocity[arm] / 0.005).tanh() + d.position_load * position[arm];
            (commands.tau[arm].clamp(-2.0, 2.0) + load + LENGTH * (shear + ROOT_UNCERTAINTY * shear_dot)) / HUB_INERTIA
        };
        let shear: f64 = (0..2).map(|arm| Self::shear(position, arm)).sum();
        let shear_dot: f64 = (0..2).map(|arm| Self::shear(velocity, arm)).sum();
        let object = (commands.u.clamp(-0.3, 0.3) + d.object_force - shear - 2.0 * TIP_UNCERTAINTY * shear_dot)
            / (self.object_mass + 2.0 * TIP_MASS);
        [hub(0), hub(1), object]
    }

    /// Contact forces' multipliers λᵢ = Qᵢ + mᵢ ÿ.
    fn multipliers(&self, commands: &Commands) -> [f64; 2] {
        let acceleration = self.acceleration(&self.position, &self.velocity, commands)[2];
        [0, 1].map(|arm| Self::shear(&self.position, arm) + TIP_MASS * acceleration)
    }

    fn measure(&self, reference: References) -> Inputs {
        let shear = [0, 1].map(|arm| Self::shear(&self.position, arm));
        let measured = Measurements {
            theta: [self.position[0], self.position[1]],
            theta_dot: [self.velocity[0], self.velocity[1]],
            y_object: self.position[2] + 0.05,
            y_object_dot: self.velocity[2],
            root_moment: shear.map(|q| -q * LENGTH),
            tip_shear: shear,
            tip_shear_dot: [0, 1].map(|arm| Self::shear(&self.velocity, arm)),
        };
        Inputs { measured, reference }
    }

    /// Classic Runge–Kutta in steps of at most 0.1 ms.
    fn step(&mut self, h: f64, commands: &Commands) {
        let parts = (h / 1e-4).ceil();
        let dt = h / parts;
        let mut time = 0.0;
        while time < h - 0.5 * dt {
            let (x, v) = (self.position, self.velocity);
            let along = |a: &[f64; 3], t: f64, b: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|i| a[i] + t * b[i]) };
            let a1 = self.acceleration(&x, &v, commands);
            let v2 = along(&v, 0.5 * dt, &a1);
            let a2 = self.acceleration(&along(&x, 0.5 * dt, &v), &v2, commands);
            let v3 = along(&v, 0.5 * dt, &a2);
            let a3 = self.acceleration(&along(&x, 0.5 * dt, &v2), &v3, commands);
            let v4 = along(&v, dt, &a3);
            let a4 = self.acceleration(&along(&x, dt, &v3), &v4, commands);
            for i in 0..3 {
                self.position[i] += dt / 6.0 * (v[i] + 2.0 * v2[i] + 2.0 * v3[i] + v4[i]);
                self.velocity[i] += dt / 6.0 * (a1[i] + 2.0 * a2[i] + 2.0 * a3[i] + a4[i]);
            }
            time += dt;
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
            let with = run(&gains, plant, 1e-3, 4.0, Coupling::GaussSeidel);
            let without = run(&gains.without_networks(), plant, 1e-3, 4.0, Coupling::GaussSeidel);
            assert!(without.late_error > 5e-3, "{disturbance:?} is no test");
            assert!(with.late_error < 0.1 * without.late_error, "{disturbance:?} {with:?} {without:?}");
            let norms = |e: &Estimates| [e.w_norm, e.u_norm[0], e.u_norm[1]];
            for (last, halfway) in norms(&with.last).into_iter().zip(norms(&with.halfway)) {
                assert!((last - halfway).abs() < 0.02 * halfway + 1e-3, "{disturbance:?} {with:?}");
            }
        }
    }
}
