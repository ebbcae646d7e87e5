//! Boundary force control with root strain in the posture surface, the default law of NABFC.
//!
//! The paper puts the tip shears into the object's virtual control (34), but no root strain into those of the hubs (52);
//! so arms that swing against each other with hubs and object at rest are not damped. With q_i = w_i − w_i^d,
//! M̃_i = EI_i q_i''(0), Q = Σ EI_i q_i'''(l), and the compliances a_i = l/3EI_i and b = 1/Σ(3EI_i/l³) of the arms, which
//! make all gains rates:
//!
//! ```text
//! s_i = G_i e_i + ė_i + σ_i a_i M̃_i,        s = G(p) p + ṗ + κ b Q
//! τ̄_i = M_i − J_i (k_i s_i + f_i (G_i ė_i + σ_i a_i M̃̇_i)) − ė_i/(σ_i a_i) − Δ̂_i
//! v   = Q − m̂ (k s + f (G ṗ + κ b Q̇)) − ṗ/(κ b) − Δ̂_F
//! ```
//!
//! Where (36) and (54) have −z_1 and −z_3i, this law has −ṗ/(κ b) and −ė_i/(σ_i a_i). With E the energy of the arms'
//! motion relative to the target, Ė = ṗ Q + Σ ė_i M̃_i, so for f = 1, a constant G and known inertias and disturbances
//!
//! ```text
//! d/dt [E + ½ G p²/(κ b) + ½ Σ G_i e_i²/(σ_i a_i) + ½ m s² + ½ Σ J_i s_i²]
//!     = −ṗ²/(κ b) − Σ ė_i²/(σ_i a_i) − m k s² − Σ J_i k_i s_i²,
//! ```
//!
//! also for unequal arms.
//!
//! **Learning.** The paper's networks learn from s, which is also what a new reference and noise make; under noise they
//! learn without end. Here Δ̂ is the weight of a constant basis function that learns from the error of a prediction
//! ([`Observer`]): of that only disturbances make any, and noise has no mean. Known limits enter the prediction, so
//! nothing winds up.
//!
//! **Mass.** m̂ comes from the prediction error too ([`MassGains`]).
//!
//! **Surface.** G(p) = G/√(1 + |p| m̂ G²/(2 q u_max)): near the target a line, far from it the parabola on which the share
//! q of the limit u_max brings an object of mass m̂ to rest at the target. So heavy objects do not overshoot.

// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]

mod gains;
mod mass;
mod table;

pub use gains::{HubGains, ObjectGains, RootStrainGains};
pub use mass::MassGains;

use crate::blocks::lowpass::LowPass;
use crate::blocks::observer::{Known, Motion, Observer, RateSource};
use crate::law::{CommandJacobian, Law, StepError};
use crate::laws::encoders::Actuation;
use crate::laws::nabfc::{Estimates, Surfaces};
use crate::signals::{Commands, INPUTS, Inputs, column};
use crate::target::Arms;
use mass::MassEstimator;
use parameter_table::InvalidParameter;
use serde::{Deserialize, Serialize};

/// The law of the module's text.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RootStrain {
    arms: Arms,
    gains: RootStrainGains,
    actuation: Actuation,
    source: RateSource,
    /// Hub 1, hub 2, object.
    observers: [Observer; 3],
    mass: MassEstimator,
    root_moment_rate: LowPass,
    tip_shear_rate: LowPass,
}

/// Signals of the law at one instant.
#[derive(Debug, Clone, Copy)]
struct Point {
    e: [f64; 2],
    p: f64,
    /// M̃ᵢ \[N·m\].
    moment: [f64; 2],
    /// Q \[N\].
    shear: f64,
    /// Rates of M̃ᵢ and Q.
    moment_rate: [f64; 2],
    shear_rate: f64,
    mass: f64,
    /// Measured root moments \[N·m\].
    load: [f64; 2],
}

/// Properties of the arms that turn strain into motion.
#[derive(Debug, Clone, Copy)]
struct Compliance {
    /// aᵢ = l/3EIᵢ \[rad/(N·m)\].
    root: [f64; 2],
    /// 3EIᵢ/l³ \[N/m\].
    tip_stiffness: [f64; 2],
    /// b \[m/N\].
    tip: f64,
}

impl Compliance {
    fn of(arms: &Arms) -> Self {
        let l = arms.length;
        let tip_stiffness = arms.ei.map(|ei| 3.0 * ei / (l * l * l));
        Self { root: arms.ei.map(|ei| l / (3.0 * ei)), tip_stiffness, tip: 1.0 / (tip_stiffness[0] + tip_stiffness[1]) }
    }
}

impl RootStrain {
    /// A controller for these arms, in its initial state.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    pub fn new(
        arms: Arms,
        gains: RootStrainGains,
        actuation: Actuation,
        source: RateSource,
    ) -> Result<Self, InvalidParameter> {
        arms.validate()?;
        gains.validate()?;
        actuation.validate()?;
        Ok(Self {
            arms,
            gains,
            actuation,
            source,
            observers: [Observer::default(); 3],
            mass: MassEstimator::default(),
            root_moment_rate: LowPass::new(gains.strain_rate_bandwidth),
            tip_shear_rate: LowPass::new(gains.strain_rate_bandwidth),
        })
    }

    /// The gains.
    #[must_use]
    pub const fn gains(&self) -> &RootStrainGains {
        &self.gains
    }

    /// Changes the gains while the law runs; what has been learnt stays. The initial mass stays what it was.
    ///
    /// # Errors
    /// The first parameter that is not in its range; the law is then as before.
    pub fn set_gains(&mut self, gains: RootStrainGains, actuation: Actuation) -> Result<(), InvalidParameter> {
        let mass = MassGains { initial: self.gains.mass.initial, ..gains.mass };
        let gains = RootStrainGains { mass, ..gains };
        gains.validate()?;
        actuation.validate()?;
        self.gains = gains;
        self.actuation = actuation;
        self.root_moment_rate.set_bandwidth(gains.strain_rate_bandwidth);
        self.tip_shear_rate.set_bandwidth(gains.strain_rate_bandwidth);
        Ok(())
    }

    /// Whether this law has the arms and settings of another one, whatever its state.
    #[must_use]
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.arms == other.arms
            && self.gains == other.gains
            && self.actuation == other.actuation
            && self.source == other.source
    }

    /// Estimated hub rates, then the object's.
    fn rates_now(&self) -> ([f64; 2], f64) {
        let [hub1, hub2, object] = &self.observers;
        ([hub1.rate, hub2.rate], object.rate)
    }

    /// Rates of root moments and of the sum of the tip shears. Estimated ones are those of arms that bend as at rest:
    /// right below the first beam mode.
    fn strain_rates(&self, inputs: &Inputs, omega: [f64; 2], v: f64) -> ([f64; 2], f64) {
        match self.source {
            RateSource::Measured => {
                let measured = &inputs.measured;
                let shear = self.tip_shear_rate.output(measured.tip_shear_dot);
                (self.root_moment_rate.output(measured.root_moment_dot), shear[0] + shear[1])
            }
            RateSource::Estimated => self.quasi_static(omega, v),
        }
    }

    /// Q̇ᵢ = −(3EIᵢ/l³)(l θ̇ᵢ − ẏ), Ṁᵢ = −l Q̇ᵢ; also maps accelerations to the rates of these.
    fn quasi_static(&self, omega: [f64; 2], v: f64) -> ([f64; 2], f64) {
        let shear = quasi_static_shear_rates(&self.arms, omega, v);
        (shear.map(|rate| -self.arms.length * rate), shear[0] + shear[1])
    }

    fn point(&self, inputs: &Inputs) -> Point {
        let targets = self.arms.targets(&inputs.reference);
        let errors = targets.errors(inputs);
        let measured = &inputs.measured;
        let (omega, v) = self.rates_now();
        let (moment_rate, shear_rate) = self.strain_rates(inputs, omega, v);
        Point {
            e: errors.e,
            p: errors.p,
            moment: std::array::from_fn(|i| measured.root_moment[i] + targets.lambda[i] * self.arms.length),
            shear: measured.tip_shear[0] + measured.tip_shear[1],
            moment_rate,
            shear_rate,
            mass: self.mass.mass(&self.gains.mass),
            load: measured.root_moment,
        }
    }

    /// (1 + r)^(−½) and r = |p| m̂ G²/(2 q `u_max`), which bends the surface.
    fn bend(&self, at: &Point) -> (f64, f64) {
        let g = &self.gains.object;
        let r = at.p.abs() * at.mass * g.slope * g.slope / (2.0 * g.brake * self.actuation.force_limit);
        ((1.0 + r).sqrt().recip(), r)
    }

    fn object_surface(&self, at: &Point) -> f64 {
        let g = &self.gains.object;
        g.slope * self.bend(at).0 * at.p + self.observers[2].rate + g.strain * Compliance::of(&self.arms).tip * at.shear
    }

    fn hub_surface(&self, arm: usize, at: &Point) -> f64 {
        let g = &self.gains.hub[arm];
        let root = Compliance::of(&self.arms).root[arm];
        g.slope * at.e[arm] + self.observers[arm].rate + g.strain * root * at.moment[arm]
    }

    /// The sliding variables for these inputs.
    #[must_use]
    pub fn surfaces(&self, inputs: &Inputs) -> Surfaces {
        let at = self.point(inputs);
        Surfaces { object: self.object_surface(&at), posture: [0, 1].map(|arm| self.hub_surface(arm, &at)) }
    }

    /// Change of the sliding variables along a direction of the inputs.
    #[must_use]
    pub fn surface_derivative(&self, inputs: &Inputs, direction: &Inputs) -> Surfaces {
        let at = self.point(inputs);
        let (errors, moment, shear) = self.directions(direction);
        let compliance = Compliance::of(&self.arms);
        let object = &self.gains.object;
        Surfaces {
            object: self.slope_by_p(&at) * errors.p + object.strain * compliance.tip * shear,
            posture: std::array::from_fn(|i| {
                let g = &self.gains.hub[i];
                g.slope * errors.e[i] + g.strain * compliance.root[i] * moment[i]
            }),
        }
    }

    /// Time derivatives of the sliding variables, for inputs that change at `rates`.
    pub fn surface_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Surfaces {
        let mut surfaces = self.surface_derivative(inputs, rates);
        let state = self.state_rates(inputs);
        surfaces.object += state.observers[2].rate + self.slope_by_mass(&self.point(inputs)) * state.mass;
        for (surface, observer) in surfaces.posture.iter_mut().zip(&state.observers) {
            *surface += observer.rate;
        }
        surfaces
    }

    /// What the law has learnt: m̂, and Δ̂ as the weights of its constant basis functions.
    #[must_use]
    pub fn estimates(&self) -> Estimates {
        let [hub1, hub2, object] = self.observers.map(|observer| observer.disturbance.abs());
        Estimates {
            m_hat: self.mass.mass(&self.gains.mass),
            j_hat: self.actuation.hub_inertia,
            epsilon_hat: 0.0,
            pi_hat: [0.0; 2],
            w_norm: object,
            u_norm: [hub1, hub2],
        }
    }

    /// Time derivatives of the estimates.
    pub fn estimate_rates(&mut self, inputs: &Inputs) -> Estimates {
        let state = self.state_rates(inputs);
        let rate = |i: usize| state.observers[i].disturbance * self.observers[i].disturbance.signum();
        Estimates {
            m_hat: state.mass,
            j_hat: [0.0; 2],
            epsilon_hat: 0.0,
            pi_hat: [0.0; 2],
            w_norm: rate(2),
            u_norm: [rate(0), rate(1)],
        }
    }

    /// ∂(G(p) p)/∂p.
    fn slope_by_p(&self, at: &Point) -> f64 {
        let (bend, r) = self.bend(at);
        self.gains.object.slope * (bend - 0.5 * r * bend * bend * bend)
    }

    /// ∂(G(p) p)/∂m̂.
    fn slope_by_mass(&self, at: &Point) -> f64 {
        let (bend, r) = self.bend(at);
        -0.5 * self.gains.object.slope * at.p * r * bend * bend * bend / at.mass
    }

    /// Change of errors, M̃ᵢ and Q along a direction of the inputs.
    fn directions(&self, direction: &Inputs) -> (crate::signals::Errors, [f64; 2], f64) {
        let jacobian = self.arms.error_jacobian();
        let values = direction.to_array();
        let inner = |row: &[f64; INPUTS]| crate::law::inner(row, &values);
        let errors = crate::signals::Errors { e: jacobian.e.each_ref().map(inner), p: inner(&jacobian.p) };
        let lambda = [direction.reference.lambda1_ref, -direction.reference.lambda1_ref];
        let measured = &direction.measured;
        let moment = std::array::from_fn(|i| measured.root_moment[i] + lambda[i] * self.arms.length);
        (errors, moment, measured.tip_shear[0] + measured.tip_shear[1])
    }

    fn known(&self, index: usize) -> Known {
        let (bandwidth, inertia, limit) = if index < 2 {
            (self.gains.hub[index].observer, self.actuation.hub_inertia[index], self.actuation.torque_limit)
        } else {
            (self.gains.object.observer, self.mass.mass(&self.gains.mass), self.actuation.force_limit)
        };
        Known { source: self.source, bandwidth, inertia, limit }
    }

    /// The known force on each coordinate: what the limited command does, less the measured load.
    fn forces(&mut self, inputs: &Inputs) -> [f64; 3] {
        let commands = self.commands(inputs);
        self.actuation.forces(&commands, inputs)
    }

    /// The velocity that the mass estimate uses.
    fn velocity(&self, inputs: &Inputs) -> f64 {
        match self.source {
            RateSource::Measured => inputs.measured.y_object_dot,
            RateSource::Estimated => self.observers[2].rate,
        }
    }

    fn state_rates(&mut self, inputs: &Inputs) -> StateRates {
        let forces = self.forces(inputs);
        let motions = motions(inputs);
        StateRates {
            observers: std::array::from_fn(|i| self.observers[i].derivative(&self.known(i), motions[i], forces[i])),
            mass: self.mass.mass_rate(&self.gains.mass, self.velocity(inputs)),
        }
    }
}

/// Time derivatives of the law's state.
struct StateRates {
    observers: [Observer; 3],
    mass: f64,
}

/// Hub 1, hub 2, object.
pub(crate) fn motions(inputs: &Inputs) -> [Motion; 3] {
    let m = &inputs.measured;
    [
        Motion { position: m.theta[0], rate: m.theta_dot[0] },
        Motion { position: m.theta[1], rate: m.theta_dot[1] },
        Motion { position: m.y_object, rate: m.y_object_dot },
    ]
}

/// Q̇ᵢ = −(3EIᵢ/l³)(l θ̇ᵢ − ẏ) of arms that bend as at rest.
pub(crate) fn quasi_static_shear_rates(arms: &Arms, omega: [f64; 2], v: f64) -> [f64; 2] {
    let stiffness = Compliance::of(arms).tip_stiffness;
    std::array::from_fn(|i| -stiffness[i] * (arms.length * omega[i] - v))
}

impl Law for RootStrain {
    fn arms(&self) -> &Arms {
        &self.arms
    }

    fn initialize(&mut self, inputs: &Inputs) {
        self.observers = motions(inputs).map(|motion| Observer::settled(self.source, motion));
        self.mass = MassEstimator::settled(self.observers[2].rate);
        self.root_moment_rate.settle(inputs.measured.root_moment_dot);
        self.tip_shear_rate.settle(inputs.measured.tip_shear_dot);
    }

    fn commands(&mut self, inputs: &Inputs) -> Commands {
        let at = self.point(inputs);
        let compliance = Compliance::of(&self.arms);
        let (omega, v) = self.rates_now();
        let tau = std::array::from_fn(|i| {
            let g = &self.gains.hub[i];
            let strain = g.strain * compliance.root[i];
            let s = self.hub_surface(i, &at);
            let forward = g.feedforward * (g.slope * omega[i] + strain * at.moment_rate[i]);
            at.load[i]
                - self.actuation.hub_inertia[i] * (g.reach * s + forward)
                - omega[i] / strain
                - self.observers[i].disturbance
        });
        let g = &self.gains.object;
        let strain = g.strain * compliance.tip;
        let forward = g.feedforward * (g.slope * v + strain * at.shear_rate);
        let u = at.shear
            - at.mass * (g.reach * self.object_surface(&at) + forward)
            - v / strain
            - self.observers[2].disturbance;
        Commands { tau, u }
    }

    /// Observers and filters are exact for held inputs; inputs that ramp enter with their mean, an error of second order.
    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        StepError::check(h, inputs, rates)?;
        let mean = inputs.after(0.5 * h, rates);
        let forces = self.forces(&mean);
        let motions = motions(&mean);
        let velocity = self.velocity(&mean);
        let known: [Known; 3] = std::array::from_fn(|i| self.known(i));
        self.mass.step(h, &self.gains.mass, velocity, forces[2]);
        for (i, observer) in self.observers.iter_mut().enumerate() {
            observer.step(h, &known[i], motions[i], forces[i]);
        }
        let (measured, rate) = (&inputs.measured, &rates.measured);
        self.root_moment_rate.step(h, measured.root_moment_dot, rate.root_moment_dot);
        self.tip_shear_rate.step(h, measured.tip_shear_dot, rate.tip_shear_dot);
        Ok(())
    }

    fn jacobian(&mut self, inputs: &Inputs) -> CommandJacobian {
        let at = self.point(inputs);
        let errors = self.arms.error_jacobian();
        let compliance = Compliance::of(&self.arms);
        let direct_rates = self.source == RateSource::Measured && !self.root_moment_rate.is_on();
        let tau = std::array::from_fn(|i| {
            let g = &self.gains.hub[i];
            let inertia = self.actuation.hub_inertia[i];
            let strain = g.strain * compliance.root[i];
            let mut row = errors.e[i].map(|by_input| -inertia * g.reach * g.slope * by_input);
            row[column::ROOT_MOMENT + i] += 1.0 - inertia * g.reach * strain;
            let sign = if i == 0 { 1.0 } else { -1.0 };
            row[column::LAMBDA1_REF] -= inertia * g.reach * strain * self.arms.length * sign;
            if direct_rates {
                row[column::ROOT_MOMENT_DOT + i] -= inertia * g.feedforward * strain;
            }
            row
        });
        let g = &self.gains.object;
        let strain = g.strain * compliance.tip;
        let by_p = -at.mass * g.reach * self.slope_by_p(&at);
        let mut u = errors.p.map(|by_input| by_p * by_input);
        for i in 0..2 {
            u[column::TIP_SHEAR + i] += 1.0 - at.mass * g.reach * strain;
            if direct_rates {
                u[column::TIP_SHEAR_DOT + i] -= at.mass * g.feedforward * strain;
            }
        }
        CommandJacobian { tau, u }
    }

    fn command_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Commands {
        let mut commands = self.jacobian(inputs).apply(rates);
        let state = self.state_rates(inputs);
        let at = self.point(inputs);
        let compliance = Compliance::of(&self.arms);
        let omega_dot: [f64; 2] = std::array::from_fn(|i| state.observers[i].rate);
        let v_dot = state.observers[2].rate;
        let (moment_jerk, shear_jerk) = match self.source {
            RateSource::Estimated => self.quasi_static(omega_dot, v_dot),
            RateSource::Measured if self.root_moment_rate.is_on() => {
                let (m, r) = (&inputs.measured, &rates.measured);
                let shear = self.tip_shear_rate.output_rate(m.tip_shear_dot, r.tip_shear_dot);
                (self.root_moment_rate.output_rate(m.root_moment_dot, r.root_moment_dot), shear[0] + shear[1])
            }
            RateSource::Measured => ([0.0; 2], 0.0),
        };
        for i in 0..2 {
            let g = &self.gains.hub[i];
            let strain = g.strain * compliance.root[i];
            let inertia = self.actuation.hub_inertia[i];
            commands.tau[i] -= (inertia * (g.reach + g.feedforward * g.slope) + strain.recip()) * omega_dot[i]
                + inertia * g.feedforward * strain * moment_jerk[i]
                + state.observers[i].disturbance;
        }
        let g = &self.gains.object;
        let strain = g.strain * compliance.tip;
        let v = self.observers[2].rate;
        let by_mass = g.reach * (self.object_surface(&at) + at.mass * self.slope_by_mass(&at))
            + g.feedforward * (g.slope * v + strain * at.shear_rate);
        commands.u -= (at.mass * (g.reach + g.feedforward * g.slope) + strain.recip()) * v_dot
            + at.mass * g.feedforward * strain * shear_jerk
            + state.observers[2].disturbance
            + by_mass * state.mass;
        commands
    }
}
