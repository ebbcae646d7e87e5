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
//! nothing winds up. [`Learner::Networks`] puts networks and robust terms in its place, fed by the same error.
//!
//! **Mass.** m̂ comes from the prediction error too ([`MassGains`]).
//!
//! **Surface.** G(p) = G/√(1 + |p| m̂ G²/(2 q u_max)): near the target a line, far from it the parabola on which the share
//! q of the limit u_max brings an object of mass m̂ to rest at the target. So heavy objects do not overshoot.

// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]

mod continuous;
mod gains;
mod loops;
mod mass;
mod networks;
mod table;

pub use gains::{HubGains, ObjectGains, RootStrainGains};
pub use mass::MassGains;
pub use networks::{Learner, NetworkGains};

use crate::blocks::lowpass::LowPass;
use crate::blocks::observer::{Known, Motion, Observer, RateSource};
use crate::law::{CommandJacobian, Law, StepError};
use crate::laws::encoders::Actuation;
use crate::laws::nabfc::{Estimates, RbfLayout, Surfaces};
use crate::signals::{Commands, INPUTS, Inputs};
use crate::target::Arms;
use loops::{Compliance, Loops, Outcome, Point};
use mass::MassEstimator;
use networks::{Networks, Seen};
use parameter_table::InvalidParameter;
use serde::{Deserialize, Serialize};

/// The law of the module's text.
#[derive(Debug, Clone, Serialize, Deserialize)]
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
    /// None where the observers learn.
    networks: Option<Box<Networks>>,
}

impl From<Outcome> for Surfaces {
    fn from(outcome: Outcome) -> Self {
        Self { object: outcome.object, posture: outcome.posture }
    }
}

impl From<Outcome> for Commands {
    fn from(outcome: Outcome) -> Self {
        Self { tau: outcome.tau, u: outcome.u }
    }
}

impl RootStrain {
    /// A controller for these arms, in its initial state. `layout` is that of the networks, where they learn.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    pub fn new(
        arms: Arms,
        gains: RootStrainGains,
        actuation: Actuation,
        source: RateSource,
        layout: &RbfLayout,
    ) -> Result<Self, InvalidParameter> {
        arms.validate()?;
        gains.validate()?;
        actuation.validate()?;
        let networks = (gains.learner == Learner::Networks).then(|| Box::new(Networks::new(layout, &arms)));
        Ok(Self {
            arms,
            gains,
            actuation,
            source,
            observers: [Observer::default(); 3],
            mass: MassEstimator::default(),
            root_moment_rate: LowPass::new(gains.strain_rate_bandwidth),
            tip_shear_rate: LowPass::new(gains.strain_rate_bandwidth),
            networks,
        })
    }

    /// The gains.
    #[must_use]
    pub const fn gains(&self) -> &RootStrainGains {
        &self.gains
    }

    /// Changes the gains while the law runs; what has been learnt stays. The initial mass and the learner stay what they
    /// were.
    ///
    /// # Errors
    /// The first parameter that is not in its range; the law is then as before.
    pub fn set_gains(&mut self, gains: RootStrainGains, actuation: Actuation) -> Result<(), InvalidParameter> {
        let mass = MassGains { initial: self.gains.mass.initial, ..gains.mass };
        let gains = RootStrainGains { mass, learner: self.gains.learner, ..gains };
        gains.validate()?;
        actuation.validate()?;
        self.root_moment_rate.set_bandwidth(gains.strain_rate_bandwidth);
        self.tip_shear_rate.set_bandwidth(gains.strain_rate_bandwidth);
        (self.gains, self.actuation) = (gains, actuation);
        Ok(())
    }

    /// Whether this law has the arms and settings of another one, whatever its state.
    #[must_use]
    pub fn has_settings_of(&self, other: &Self) -> bool {
        let same_networks = match (&self.networks, &other.networks) {
            (None, None) => true,
            (Some(one), Some(other)) => one.has_settings_of(other),
            _ => false,
        };
        self.arms == other.arms
            && self.gains == other.gains
            && self.actuation == other.actuation
            && self.source == other.source
            && same_networks
    }

    fn loops(&self) -> Loops<'_> {
        Loops::new(&self.arms, &self.gains, &self.actuation)
    }

    /// Q̇ᵢ = −(3EIᵢ/l³)(l θ̇ᵢ − ẏ), Ṁᵢ = −l Q̇ᵢ; also maps accelerations to the rates of these.
    fn quasi_static(&self, omega: [f64; 2], v: f64) -> ([f64; 2], [f64; 2]) {
        let shear = quasi_static_shear_rates(&self.arms, omega, v);
        (shear.map(|rate| -self.arms.length * rate), shear)
    }

    /// Rates of root moments and of the tip shears. Estimated ones are those of arms that bend as at rest: right below
    /// the first beam mode.
    fn strain_rates(&self, inputs: &Inputs) -> ([f64; 2], [f64; 2]) {
        let [hub1, hub2, object] = &self.observers;
        match self.source {
            RateSource::Measured => {
                let measured = &inputs.measured;
                let moment = self.root_moment_rate.output(measured.root_moment_dot);
                (moment, self.tip_shear_rate.output(measured.tip_shear_dot))
            }
            RateSource::Estimated => self.quasi_static([hub1.rate, hub2.rate], object.rate),
        }
    }

    /// The signals for these inputs.
    fn point(&self, inputs: &Inputs) -> Point {
        let targets = self.arms.targets(&inputs.reference);
        let errors = targets.errors(inputs);
        let measured = &inputs.measured;
        let [hub1, hub2, object] = &self.observers;
        let (moment_rate, shear_rate) = self.strain_rates(inputs);
        Point {
            e: errors.e,
            omega: [hub1.rate, hub2.rate],
            moment: std::array::from_fn(|i| measured.root_moment[i] + targets.lambda[i] * self.arms.length),
            moment_rate,
            load: measured.root_moment,
            p: errors.p,
            v: object.rate,
            shear: measured.tip_shear[0] + measured.tip_shear[1],
            shear_rate: shear_rate[0] + shear_rate[1],
            mass: self.mass.mass(&self.gains.mass),
            unknown: self.observers.map(|observer| observer.disturbance),
        }
    }

    /// Change of the signals along a direction of the inputs, with the law's state as it is.
    fn direction(&self, direction: &Inputs) -> Point {
        let jacobian = self.arms.error_jacobian();
        let values = direction.to_array();
        let inner = |row: &[f64; INPUTS]| crate::law::inner(row, &values);
        let lambda = [direction.reference.lambda1_ref, -direction.reference.lambda1_ref];
        let measured = &direction.measured;
        let mut change = Point {
            e: jacobian.e.each_ref().map(inner),
            moment: std::array::from_fn(|i| measured.root_moment[i] + lambda[i] * self.arms.length),
            load: measured.root_moment,
            p: inner(&jacobian.p),
            shear: measured.tip_shear[0] + measured.tip_shear[1],
            ..Point::default()
        };
        if self.source == RateSource::Measured && !self.root_moment_rate.is_on() {
            change.moment_rate = measured.root_moment_dot;
            change.shear_rate = measured.tip_shear_dot[0] + measured.tip_shear_dot[1];
        }
        change
    }

    /// Change of the signals in time, for inputs that change at `rates`.
    fn velocity(&mut self, inputs: &Inputs, rates: &Inputs) -> Point {
        let state = self.state_rates(inputs);
        let mut change = self.direction(rates);
        let [hub1, hub2, object] = &state.observers;
        change.omega = [hub1.rate, hub2.rate];
        change.v = object.rate;
        change.unknown = state.observers.map(|observer| observer.disturbance);
        change.mass = state.mass;
        match self.source {
            RateSource::Estimated => {
                let shear;
                (change.moment_rate, shear) = self.quasi_static(change.omega, change.v);
                change.shear_rate = shear[0] + shear[1];
            }
            RateSource::Measured if self.root_moment_rate.is_on() => {
                let (m, r) = (&inputs.measured, &rates.measured);
                let shear = self.tip_shear_rate.output_rate(m.tip_shear_dot, r.tip_shear_dot);
                change.moment_rate = self.root_moment_rate.output_rate(m.root_moment_dot, r.root_moment_dot);
                change.shear_rate = shear[0] + shear[1];
            }
            RateSource::Measured => {}
        }
        change
    }

    /// The sliding variables for these inputs.
    #[must_use]
    pub fn surfaces(&self, inputs: &Inputs) -> Surfaces {
        self.loops().at(&self.point(inputs)).into()
    }

    /// Change of the sliding variables along a direction of the inputs.
    #[must_use]
    pub fn surface_derivative(&self, inputs: &Inputs, direction: &Inputs) -> Surfaces {
        self.loops().change(&self.point(inputs), &self.direction(direction)).into()
    }

    /// Time derivatives of the sliding variables, for inputs that change at `rates`.
    pub fn surface_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Surfaces {
        let change = self.velocity(inputs, rates);
        self.loops().change(&self.point(inputs), &change).into()
    }

    /// What the law has learnt: m̂, and Δ̂ as the weights of its constant basis functions, or those of the networks.
    #[must_use]
    pub fn estimates(&self) -> Estimates {
        let [hub1, hub2, object] = self.observers.map(|observer| observer.disturbance.abs());
        let constants = ([hub1, hub2], [0.0; 2], object, 0.0);
        let (u_norm, pi_hat, w_norm, epsilon_hat) =
            self.networks.as_ref().map_or(constants, |networks| networks.norms());
        Estimates {
            m_hat: self.mass.mass(&self.gains.mass),
            j_hat: self.actuation.hub_inertia,
            epsilon_hat,
            pi_hat,
            w_norm,
            u_norm,
        }
    }

    /// Time derivatives of the estimates.
    pub fn estimate_rates(&mut self, inputs: &Inputs) -> Estimates {
        let state = self.state_rates(inputs);
        let (u_norm, pi_hat, w_norm, epsilon_hat) = if let Some(networks) = &self.networks {
            let known = self.known();
            let motions = motions(inputs);
            networks.norm_rates(&self.gains.networks, &known, &self.observers, &state.observers, &motions)
        } else {
            let rate = |i: usize| state.observers[i].disturbance * self.observers[i].disturbance.signum();
            ([rate(0), rate(1)], [0.0; 2], rate(2), 0.0)
        };
        Estimates { m_hat: state.mass, j_hat: [0.0; 2], epsilon_hat, pi_hat, w_norm, u_norm }
    }

    /// What is known of hub 1, hub 2 and the object.
    fn known(&self) -> [Known; 3] {
        let (gains, actuation, source) = (&self.gains, &self.actuation, self.source);
        let hub = |i: usize| Known {
            source,
            bandwidth: gains.hub[i].observer,
            inertia: actuation.hub_inertia[i],
            limit: actuation.torque_limit,
        };
        let mass = self.mass.mass(&gains.mass);
        let object = Known { source, bandwidth: gains.object.observer, inertia: mass, limit: actuation.force_limit };
        [hub(0), hub(1), object]
    }

    /// The known force on each coordinate: what the limited command does, less the measured load.
    fn forces(&self, inputs: &Inputs) -> [f64; 3] {
        let commands = self.loops().at(&self.point(inputs)).into();
        self.actuation.forces(&commands, inputs)
    }

    /// The velocity that the mass estimate uses.
    fn object_rate(&self, inputs: &Inputs) -> f64 {
        match self.source {
            RateSource::Measured => inputs.measured.y_object_dot,
            RateSource::Estimated => self.observers[2].rate,
        }
    }

    fn state_rates(&self, inputs: &Inputs) -> StateRates {
        let (forces, motions, known) = (self.forces(inputs), motions(inputs), self.known());
        StateRates {
            observers: std::array::from_fn(|i| self.observers[i].derivative(&known[i], motions[i], forces[i])),
            mass: self.mass.mass_rate(&self.gains.mass, self.object_rate(inputs)),
        }
    }

    /// A step of the networks with the inputs held at `mean`.
    fn step_networks(&mut self, h: f64, mean: &Inputs, known: &[Known; 3], forces: &[f64; 3]) {
        let at = self.point(mean);
        let (_, shear_rate) = self.strain_rates(mean);
        let seen = self.seen(&at, &self.loops().at(&at), mean.measured.tip_shear, shear_rate);
        let Some(networks) = &mut self.networks else { return };
        let motions = motions(mean);
        let measured = std::array::from_fn(|i| (motions[i], forces[i]));
        networks.step(h, &self.gains.networks, known, &seen, &mut self.observers, &measured);
    }

    /// What the networks see at a point whose surfaces are those of `outcome`, with the shears and their rates of each arm. Linear
    /// in everything, so it also maps changes to changes.
    fn seen<'a>(&self, at: &'a Point, outcome: &Outcome, shear: [f64; 2], shear_rate: [f64; 2]) -> Seen<'a> {
        let compliance = Compliance::of(&self.arms);
        let RootStrainGains { object, hub, .. } = &self.gains;
        Seen {
            at,
            surface: outcome.object,
            posture: outcome.posture,
            alpha_rate: -object.slope * at.v - object.strain * compliance.tip * at.shear_rate,
            posture_alpha_rate: std::array::from_fn(|i| {
                -hub[i].slope * at.omega[i] - hub[i].strain * compliance.root[i] * at.moment_rate[i]
            }),
            shear,
            shear_rate,
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
        if let Some(networks) = &mut self.networks {
            networks.reset();
        }
    }

    fn commands(&mut self, inputs: &Inputs) -> Commands {
        self.loops().at(&self.point(inputs)).into()
    }

    /// Observers and filters are exact for held inputs; inputs that ramp enter with their mean, an error of second order.
    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        StepError::check(h, inputs, rates)?;
        let mean = inputs.after(0.5 * h, rates);
        let (forces, known) = (self.forces(&mean), self.known());
        let velocity = self.object_rate(&mean);
        self.mass.step(h, &self.gains.mass, velocity, forces[2]);
        if self.networks.is_some() {
            self.step_networks(h, &mean, &known, &forces);
        } else {
            let motions = motions(&mean);
            for (i, observer) in self.observers.iter_mut().enumerate() {
                observer.step(h, &known[i], motions[i], forces[i]);
            }
        }
        let (measured, rate) = (&inputs.measured, &rates.measured);
        self.root_moment_rate.step(h, measured.root_moment_dot, rate.root_moment_dot);
        self.tip_shear_rate.step(h, measured.tip_shear_dot, rate.tip_shear_dot);
        Ok(())
    }

    fn jacobian(&mut self, inputs: &Inputs) -> CommandJacobian {
        let (at, loops) = (self.point(inputs), self.loops());
        let mut jacobian = CommandJacobian { tau: [[0.0; INPUTS]; 2], u: [0.0; INPUTS] };
        for column in 0..INPUTS {
            let mut unit = [0.0; INPUTS];
            unit[column] = 1.0;
            let Outcome { tau, u, .. } = loops.change(&at, &self.direction(&Inputs::from_array(unit)));
            (jacobian.tau[0][column], jacobian.tau[1][column], jacobian.u[column]) = (tau[0], tau[1], u);
        }
        jacobian
    }

    /// Networks are evaluated once per step; in between they are as the observers are.
    fn command_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Commands {
        let change = self.velocity(inputs, rates);
        self.loops().change(&self.point(inputs), &change).into()
    }
}
