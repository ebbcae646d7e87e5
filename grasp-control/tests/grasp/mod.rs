//! The plant and a controller in a loop at a fixed rate, with disturbances, noise, delay and quantised sensors.

use grasp_control::blocks::observer::RateSource;
use grasp_control::laws::encoders::Actuation;
use grasp_control::laws::nabfc::RbfLayout;
use grasp_control::laws::root_strain::{RootStrain, RootStrainGains};
use grasp_control::{Arms, Inputs, Law, Measurements, References};
use grasp_plant::{ActuatorModel, Parameters, Plant};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// One grasp: what differs from the paper's.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub order: usize,
    pub step: f64,
    pub duration: f64,
    pub object_mass: f64,
    pub length: f64,
    /// EI as a multiple of the paper's, known to the controller.
    pub stiffness: f64,
    pub actuator: ActuatorModel,
    /// Δf₁ \[N·m\] and ΔF \[N\].
    pub hub_torque: f64,
    pub object_force: f64,
    /// Coulomb friction of both hubs against their way \[N·m\].
    pub friction: f64,
    /// Dahl friction of both hubs: its largest torque \[N·m\], reached within a tenth of a degree.
    pub dahl: f64,
    /// The hubs' inertias as a multiple of the paper's, which the controller takes for granted.
    pub hub_inertia: f64,
    /// `c_f` \[s\]: what damps the beams.
    pub root_uncertainty: f64,
    /// Multiple of one percent noise.
    pub noise: f64,
    /// Steps by which commands are late.
    pub delay: usize,
    pub encoders: bool,
    /// Amplitude of θ₁'s reference \[rad\] at 2 Hz.
    pub sway: f64,
}

impl Default for Case {
    fn default() -> Self {
        Self {
            order: 8,
            step: 1e-3,
            duration: 1.5,
            object_mass: 0.3,
            length: 0.2,
            stiffness: 1.0,
            actuator: ActuatorModel::Compensated,
            hub_torque: 0.0,
            object_force: 0.0,
            friction: 0.0,
            dahl: 0.0,
            hub_inertia: 1.0,
            root_uncertainty: 0.1,
            noise: 0.0,
            delay: 0,
            encoders: false,
            sway: 0.0,
        }
    }
}

/// One percent sensor noise, for a minute.
#[allow(dead_code)]
pub const NOISE: Case = Case {
    order: 8,
    step: 1e-3,
    duration: 60.0,
    object_mass: 0.3,
    length: 0.2,
    stiffness: 1.0,
    actuator: ActuatorModel::Compensated,
    hub_torque: 0.0,
    object_force: 0.0,
    friction: 0.0,
    dahl: 0.0,
    hub_inertia: 1.0,
    root_uncertainty: 0.1,
    noise: 1.0,
    delay: 0,
    encoders: false,
    sway: 0.0,
};

impl Case {
    /// The arms, as controller and plant know them.
    pub fn arms(&self) -> Arms {
        Arms { ei: [0.115 * self.stiffness; 2], length: self.length, hub_distance: 0.1 }
    }

    /// The object's way \[m\].
    pub fn way(&self) -> f64 {
        (self.arms().targets(&References::default()).y_object - 0.05).abs()
    }
}

/// What came of it. Times \[s\] after which the quantity stays within 2 % of its way; infinite if it does not.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    pub force: f64,
    pub angles: f64,
    pub position: f64,
    /// Of the larger contact force, relative.
    pub overshoot: f64,
    /// Mean and rms of the force errors in the last tenth (60 s: the last 10 s), rms from 10 s to 20 s \[N\].
    pub mean_error: f64,
    pub rms: f64,
    pub rms_early: f64,
    /// Share of the steps with a command at its limit.
    pub saturated: f64,
    /// |Δ̂| of hub 1, hub 2 and object at the end; m̂.
    pub estimates: [f64; 3],
    pub mass: f64,
    pub inertia: [f64; 2],
}

impl Outcome {
    /// All of (17).
    pub fn settling(&self) -> f64 {
        self.force.max(self.angles).max(self.position)
    }
}

/// Normal deviates: xorshift and Box–Muller.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let (radius, angle) = (self.uniform(), self.uniform());
        (-2.0 * radius.ln()).sqrt() * (TAU * angle).cos()
    }
}

fn quantised(value: f64, step: f64) -> f64 {
    (value / step).round() * step
}

/// What the sensors give: standard deviations of "noise profile 1".
fn sensed(case: &Case, mut m: Measurements, noise: &mut Noise) -> Measurements {
    if case.noise > 0.0 {
        let mut add = |value: &mut f64, sigma: f64| *value += case.noise * sigma * noise.normal();
        for i in 0..2 {
            add(&mut m.theta[i], 1e-4);
            add(&mut m.theta_dot[i], 1e-2);
            add(&mut m.root_moment[i], 1e-3);
            add(&mut m.tip_shear[i], 5e-3);
            add(&mut m.tip_shear_dot[i], 0.5);
            add(&mut m.root_moment_dot[i], 0.1);
        }
        add(&mut m.y_object, 1e-5);
        add(&mut m.y_object_dot, 1e-3);
    }
    if case.encoders {
        m.theta = m.theta.map(|theta| quantised(theta, TAU / 65536.0));
        m.y_object = quantised(m.y_object, 1e-6);
        m.root_moment = m.root_moment.map(|moment| quantised(moment, 3e-5));
        m.tip_shear = m.tip_shear.map(|shear| quantised(shear, 1.5e-4));
        (m.theta_dot, m.y_object_dot, m.tip_shear_dot, m.root_moment_dot) = ([0.0; 2], 0.0, [0.0; 2], [0.0; 2]);
    }
    m
}

/// Dahl's friction torque after a turn \[rad\], dT/dθ = (most − T sgn θ̇)/(a tenth of a degree), which is exact for any turn.
fn dahl(most: f64, torque: f64, turn: f64) -> f64 {
    let end = most * turn.signum();
    end + (torque - end) * (-turn.abs() / 0.1_f64.to_radians()).exp()
}

/// Runs a case with the root-strain law.
pub fn run(case: &Case, gains: &RootStrainGains) -> Outcome {
    let source = if case.encoders { RateSource::Estimated } else { RateSource::Measured };
    let layout = RbfLayout::default();
    let mut law = RootStrain::new(case.arms(), *gains, Actuation::default(), source, &layout).unwrap();
    let outcome = run_law(case, &mut law);
    let estimates = law.estimates();
    Outcome {
        estimates: [estimates.u_norm[0], estimates.u_norm[1], estimates.w_norm],
        mass: estimates.m_hat,
        inertia: estimates.j_hat,
        ..outcome
    }
}

/// Runs a case with any law; estimates are left out.
pub fn run_law(case: &Case, law: &mut dyn Law) -> Outcome {
    let mut parameters = Parameters { order: case.order, length: case.length, ..Parameters::default() };
    parameters.object_mass = case.object_mass;
    parameters.actuator_model = case.actuator;
    parameters.root_uncertainty = case.root_uncertainty;
    for arm in &mut parameters.arms {
        arm.ei *= case.stiffness;
        arm.hub_inertia *= case.hub_inertia;
    }
    let mut plant = Plant::new(parameters).unwrap();
    let reference = References::default();
    let targets = case.arms().targets(&reference);
    let (force, way) = (-reference.lambda1_ref, case.way());
    let mut noise = Noise(0x2545_F491_4F6C_DD1D);
    let mut late = VecDeque::from(vec![[0.0; 3]; case.delay]);
    let steps = (case.duration / case.step).round();
    let mut outcome = Outcome {
        force: 0.0,
        angles: 0.0,
        position: 0.0,
        overshoot: f64::NEG_INFINITY,
        mean_error: 0.0,
        rms: 0.0,
        rms_early: 0.0,
        saturated: 0.0,
        estimates: [0.0; 3],
        mass: 0.0,
        inertia: [0.0; 2],
    };
    let window = (0.9 * case.duration).max(case.duration - 10.0);
    let (mut sums, mut squares, mut count, mut early) = ([0.0; 2], 0.0, 0.0, (0.0, 0.0));
    let mut bristles = [0.0; 2];
    let mut step = 0.0;
    while step < steps {
        let time = step * case.step;
        let measured = plant.measured();
        let truth = Measurements {
            theta: measured.theta,
            theta_dot: measured.theta_dot,
            y_object: measured.y_object,
            y_object_dot: measured.y_object_dot,
            root_moment: measured.root_moment,
            tip_shear: measured.tip_shear,
            tip_shear_dot: measured.tip_shear_dot,
            root_moment_dot: plant.uncertainty().root_moment_dot,
        };
        let sway = if time < 0.5 * case.duration { case.sway * (TAU * 2.0 * time).sin() } else { 0.0 };
        let inputs = Inputs {
            measured: sensed(case, truth, &mut noise),
            reference: References { theta1_ref: reference.theta1_ref + sway, ..reference },
        };
        if step == 0.0 {
            law.initialize(&inputs);
        }
        // As under the tool's master: the law takes in the newest sample before it commands.
        if step > 0.0 {
            law.step(case.step, &inputs, &Inputs::HELD).unwrap();
        }
        late.push_back(law.commands(&inputs).to_array());
        let command = late.pop_front().unwrap();
        if command[0].abs() >= 2.0 || command[1].abs() >= 2.0 || command[2].abs() >= 0.3 {
            outcome.saturated += 1.0 / steps;
        }
        let driven = grasp_plant::Inputs {
            torque_command: [command[0], command[1]],
            force_command: command[2],
            hub_disturbance: [case.hub_torque - case.friction - bristles[0], case.friction - bristles[1]],
            object_disturbance: case.object_force,
        };
        let errors = plant.direct(&driven).contact_force.map(|f| f - force);
        let after = time + case.step;
        if errors.iter().any(|error| error.abs() > 0.02 * force) {
            outcome.force = after;
        }
        if (0..2).any(|i| (truth.theta[i] - targets.theta[i]).abs() > 0.02 * targets.theta[i].abs()) {
            outcome.angles = after;
        }
        if (truth.y_object - targets.y_object).abs() > 0.02 * way {
            outcome.position = after;
        }
        outcome.overshoot = errors.iter().fold(outcome.overshoot, |most, error| most.max(error / force));
        let square = 0.5 * (errors[0].powi(2) + errors[1].powi(2));
        if time >= window {
            (0..2).for_each(|i| sums[i] += errors[i]);
            (squares, count) = (squares + square, count + 1.0);
        }
        if (10.0..20.0).contains(&time) {
            early = (early.0 + square, early.1 + 1.0);
        }
        plant.step(case.step, &driven, &grasp_plant::Inputs::ZERO).unwrap();
        let turned = plant.measured().theta;
        bristles = std::array::from_fn(|i| dahl(case.dahl, bristles[i], turned[i] - truth.theta[i]));
        step += 1.0;
    }
    let end = |time: f64| if time >= case.duration - 0.5 * case.step { f64::INFINITY } else { time };
    (outcome.force, outcome.angles, outcome.position) =
        (end(outcome.force), end(outcome.angles), end(outcome.position));
    outcome.mean_error = sums[0].abs().max(sums[1].abs()) / count;
    outcome.rms = (squares / count).sqrt();
    outcome.rms_early = (early.0 / early.1).sqrt();
    outcome
}
