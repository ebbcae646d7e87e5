//! Boundary force control with root strain in the posture surface, the default law of NABFC.
//!
//! The paper puts the tip shears into the object's virtual control (34), but no root strain into those of the hubs (52);
//! so arms that swing against each other with hubs and object at rest are not damped. With q_i = w_i − w_i^d,
//! M̃_i = EI_i q_i''(0), Q = Σ EI_i q_i'''(l) and the compliance b = 1/Σ(3EI_i/l³) of the tips:
//!
//! ```text
//! s_i = G_i e_i + ė_i + c_i M̃_i/Ĵ_i,        s = G(p) p + ṗ + κ √(b/m̂) Q
//! τ̄_i = M_i − Ĵ_i (k_i s_i + f_i (G_i ė_i + c_i M̃̇_i/Ĵ_i)) − Ĵ_i ė_i/c_i − Δ̂_i
//! v   = Q − m̂ (k s + f (G ṗ + κ √(b/m̂) Q̇)) − ṗ/(κ √(b/m̂)) − Δ̂_F
//! ```
//!
//! Where (36) and (54) have −z_1 and −z_3i, this law has −ṗ and −ė_i over the shares of the strain. With E the energy of the
//! arms' motion relative to the target, Ė = ṗ Q + Σ ė_i M̃_i, so for f = 1, a constant G and known inertias and disturbances,
//! with C = κ √(b/m),
//!
//! ```text
//! d/dt [E + ½ G p²/C + ½ Σ G_i J_i e_i²/c_i + ½ m s² + ½ Σ J_i s_i²]
//!     = −ṗ²/C − Σ J_i ė_i²/c_i − m k s² − Σ J_i k_i s_i²,
//! ```
//!
//! also for unequal arms.
//!
//! **Units.** G_i, k_i, G, k and 1/c_i are pure numbers times the plant's natural rates ([`Scaled`]), which are known at the start. What the
//! arm's bending does to the hub enters as the acceleration M̃_i/Ĵ_i, so the torque that answers it, c_i (k_i M̃_i + f_i M̃̇_i), does not
//! grow with the estimated inertia. That matters at the beams' frequencies, where a late command no longer damps and only Section
//! IV's loss −c_f Ṁ_i does: there the law's gain on the root moment has to stay below c_f ω (`docs/comparison.md`).
//!
//! **Rates of strain** come from the moments and shears themselves, as ω_s (x − x̄) with x̄ behind a low-pass: what a low-pass makes of a
//! measured rate, but an impact cannot mislead it (`blocks/slope.rs`).
//!
//! **Learning.** The paper's networks learn from s, which is also what a new reference and noise make; under noise they
//! learn without end. Here Δ̂ is the weight of a constant basis function that learns from the error of a prediction
//! ([`Observer`]): of that only disturbances make any, and noise has no mean. Known limits enter the prediction, so
//! nothing winds up. [`Learner::Networks`] puts networks and robust terms in its place, fed by the same error.
//!
//! **Inertias.** m̂ and Ĵ_i come from the prediction errors too ([`MassGains`], [`InertiaGains`]).
//!
//! **Surface.** G(p) = G/√(1 + |p| m̂ G²/(2 q u_max)): near the target a line, far from it the parabola on which the share
//! q of the limit u_max brings an object of mass m̂ to rest at the target. So heavy objects do not overshoot.

// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]
// Where a part of what is computed is not used, the compiler sees it only if it is inlined.
#![allow(clippy::inline_always)]

mod continuous;
mod gains;
mod inertia;
mod loops;
mod natural;
mod networks;
mod table;

pub use gains::{HubGains, ObjectGains, RootStrainGains};
pub use inertia::{FilterGains, InertiaGains, MassGains};
pub use natural::Scaled;
pub use networks::{Learner, NetworkGains};

use crate::blocks::four::Lanes;
use crate::blocks::lowpass::LowPass;
use crate::blocks::observer::{Known, Motion, Observer, RateSource};
use crate::blocks::slope::{Signals, Slope};
use crate::law::{CommandJacobian, Law, StepError};
use crate::laws::encoders::Actuation;
use crate::laws::nabfc::{Estimates, RbfLayout, Surfaces};
use crate::signals::{Commands, INPUTS, Inputs, Measurements};
use crate::target::{Arms, TargetSlopes};
use inertia::{Estimator, Estimators, Moving, OfSize, Prior, Priors, Sights};
use loops::{Loops, Outcome, Point};
use natural::Compliance;
use networks::{Networks, Seen};
use parameter_table::InvalidParameter;
use serde::{Deserialize, Serialize};

/// The law of the module's text.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RootStrain {
    arms: Arms,
    gains: RootStrainGains,
    scaled: Scaled,
    actuation: Actuation,
    source: RateSource,
    /// Hub 1, hub 2, object.
    observers: [Observer; 3],
    /// What there is to know of each inertia beforehand, and what has been learnt of it.
    priors: [Prior; 3],
    inertia: Estimators,
    /// Ĵ₁, Ĵ₂ and m̂ of the estimators, if they are known: a point, an observer and the next commands ask for the same ones.
    #[serde(skip)]
    found: Option<Lanes>,
    #[serde(skip)]
    slopes: Option<TargetSlopes>,
    /// What follows from gains and the size of a step, kept for the next one of the same size.
    #[serde(skip)]
    of_size: Option<OfSize>,
    root_moment: LowPass,
    root_moment_rate: Slope,
    tip_shear_rate: Slope,
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
        let scaled = Scaled::new(&gains, &arms, &actuation);
        let networks = (gains.learner == Learner::Networks).then(|| Box::new(Networks::new(layout, &arms)));
        Ok(Self {
            arms,
            gains,
            scaled,
            actuation,
            source,
            observers: [Observer::default(); 3],
            priors: gains.priors(&arms, &actuation),
            inertia: [Estimator::default(); 3].into(),
            found: None,
            slopes: Some(arms.slopes()),
            of_size: None,
            root_moment: LowPass::new(gains.strain_bandwidth),
            root_moment_rate: Slope::new(scaled.strain_rate_bandwidth),
            tip_shear_rate: Slope::new(scaled.strain_rate_bandwidth),
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
        self.root_moment.set_bandwidth(gains.strain_bandwidth);
        self.scaled = Scaled::new(&gains, &self.arms, &actuation);
        self.root_moment_rate.set_bandwidth(self.scaled.strain_rate_bandwidth);
        self.tip_shear_rate.set_bandwidth(self.scaled.strain_rate_bandwidth);
        self.priors = gains.priors(&self.arms, &actuation);
        (self.gains, self.actuation) = (gains, actuation);
        (self.found, self.of_size) = (None, None);
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
        Loops { gains: &self.gains, scaled: &self.scaled, actuation: &self.actuation }
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
                let (moments, shears) = loads(inputs);
                (self.root_moment_rate.output(moments), self.tip_shear_rate.output(shears))
            }
            RateSource::Estimated => self.quasi_static([hub1.rate, hub2.rate], object.rate),
        }
    }

    /// The commands for these inputs. Not inlined, because a step and what comes after it ask for them; what they are made of is.
    #[inline(never)]
    fn act(&self, inputs: &Inputs) -> Commands {
        self.loops().at(&self.point_here(inputs)).into()
    }

    /// The signals for these inputs.
    #[inline(never)]
    fn point(&self, inputs: &Inputs) -> Point {
        self.point_here(inputs)
    }

    #[inline(always)]
    fn point_here(&self, inputs: &Inputs) -> Point {
        let slopes = self.slopes.unwrap_or_else(|| self.arms.slopes());
        let targets = self.arms.targets_with(&slopes, &inputs.reference);
        let errors = targets.errors(inputs);
        let measured = &inputs.measured;
        let [hub1, hub2, object] = &self.observers;
        let (moment_rate, shear_rate) = self.strain_rates(inputs);
        let [inertia1, inertia2, mass] = self.inertias();
        let moment = self.root_moment.output(measured.root_moment);
        Point {
            e: errors.e,
            omega: [hub1.rate, hub2.rate],
            moment: std::array::from_fn(|i| moment[i] + targets.lambda[i] * self.arms.length),
            moment_rate,
            load: measured.root_moment,
            p: errors.p,
            v: object.rate,
            shear: measured.tip_shear[0] + measured.tip_shear[1],
            shear_rate: shear_rate[0] + shear_rate[1],
            mass,
            inertia: [inertia1, inertia2],
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
        let moment = if self.root_moment.is_on() { [0.0; 2] } else { measured.root_moment };
        let mut change = Point {
            e: jacobian.e.each_ref().map(inner),
            moment: std::array::from_fn(|i| moment[i] + lambda[i] * self.arms.length),
            load: measured.root_moment,
            p: inner(&jacobian.p),
            shear: measured.tip_shear[0] + measured.tip_shear[1],
            ..Point::default()
        };
        if self.source == RateSource::Measured {
            let (moments, shears) = loads(direction);
            change.moment_rate = self.root_moment_rate.output_change(moments, [0.0; 2]);
            let shear = self.tip_shear_rate.output_change(shears, [0.0; 2]);
            change.shear_rate = shear[0] + shear[1];
        }
        change
    }

    /// Change of the signals in time, for inputs that change at `rates`.
    fn velocity(&mut self, inputs: &Inputs, rates: &Inputs) -> Point {
        let state = self.state_rates(inputs);
        let mut change = self.direction(rates);
        if self.root_moment.is_on() {
            let rate = self.root_moment.output_rate(inputs.measured.root_moment, rates.measured.root_moment);
            (0..2).for_each(|i| change.moment[i] += rate[i]);
        }
        let [hub1, hub2, object] = &state.observers;
        change.omega = [hub1.rate, hub2.rate];
        change.v = object.rate;
        change.unknown = state.observers.map(|observer| observer.disturbance);
        let [inertia1, inertia2, mass] = state.inertia;
        (change.mass, change.inertia) = (mass, [inertia1, inertia2]);
        match self.source {
            RateSource::Estimated => {
                let shear;
                (change.moment_rate, shear) = self.quasi_static(change.omega, change.v);
                change.shear_rate = shear[0] + shear[1];
            }
            RateSource::Measured if self.root_moment_rate.is_on() => {
                let (moments, shears) = loads(rates);
                let m = &inputs.measured;
                let slow = self.root_moment_rate.filtered_rate(m.root_moment);
                change.moment_rate = self.root_moment_rate.output_change(moments, slow);
                let slow = self.tip_shear_rate.filtered_rate(m.tip_shear);
                let shear = self.tip_shear_rate.output_change(shears, slow);
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
        let [inertia1, inertia2, m_hat] = self.inertias();
        Estimates { m_hat, j_hat: [inertia1, inertia2], epsilon_hat, pi_hat, w_norm, u_norm }
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
        let [inertia1, inertia2, m_hat] = state.inertia;
        Estimates { m_hat, j_hat: [inertia1, inertia2], epsilon_hat, pi_hat, w_norm, u_norm }
    }

    /// What is known of hub 1, hub 2 and the object.
    fn known(&self) -> [Known; 3] {
        let (gains, actuation, source, inertia) = (&self.gains, &self.actuation, self.source, self.inertias());
        let known = |i: usize, bandwidth: f64, limit: f64| Known { source, bandwidth, inertia: inertia[i], limit };
        [
            known(0, gains.hub[0].observer, actuation.torque_limit),
            known(1, gains.hub[1].observer, actuation.torque_limit),
            known(2, gains.object.observer, actuation.force_limit),
        ]
    }

    /// The known force on each coordinate: what the limited command does, less the measured load.
    fn forces(&self, inputs: &Inputs) -> [f64; 3] {
        self.actuation.forces(&self.act(inputs), inputs)
    }

    /// Ĵ₁, Ĵ₂ \[kg·m²\] and m̂ \[kg\].
    fn inertias(&self) -> [f64; 3] {
        match self.found {
            Some([hub1, hub2, object, _]) => [hub1, hub2, object],
            None => self.find_inertias(),
        }
    }

    #[inline(never)]
    fn find_inertias(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.inertia.of(i).inertia(&self.priors[i]))
    }

    /// What follows from gains and a step size of `h` \[s\].
    #[inline(never)]
    fn of_size(&self, h: f64) -> OfSize {
        let ([hub1, hub2], object) = (self.gains.hub.map(|hub| hub.observer), self.gains.object.observer);
        let Actuation { torque_limit, force_limit, .. } = self.actuation;
        // The lane to spare stays at rest.
        let poles = [hub1, hub2, object, object];
        OfSize {
            h,
            source: self.source,
            poles,
            decays: poles.map(|pole| Observer::decay(pole, h)),
            limits: [torque_limit, torque_limit, force_limit, force_limit],
            filter: self.gains.filter,
            shares: self.gains.filter.shares(h),
            priors: Priors::from(&self.priors),
        }
    }

    /// What the estimators of the inertias see, under the known forces.
    fn moving(&self, inputs: &Inputs, forces: &[f64; 3]) -> [Moving; 3] {
        moving(self.source, &self.observers, inputs, forces)
    }

    fn state_rates(&self, inputs: &Inputs) -> StateRates {
        let (forces, motions, known) = (self.forces(inputs), motions(inputs), self.known());
        let moving = self.moving(inputs, &forces);
        StateRates {
            observers: std::array::from_fn(|i| self.observers[i].derivative(&known[i], motions[i], forces[i])),
            inertia: std::array::from_fn(|i| {
                self.inertia.of(i).inertia_rate(&self.gains.filter, &self.priors[i], moving[i])
            }),
        }
    }

    /// A step with inputs that change. Not inlined, because few hosts ask for it.
    #[inline(never)]
    fn ramped_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        StepError::check(h, inputs, rates)?;
        self.learn(h, &inputs.after(0.5 * h, rates));
        self.follow(h, &inputs.measured, &rates.measured);
        Ok(())
    }

    /// A step of the low-passes.
    #[inline(always)]
    fn follow(&mut self, h: f64, measured: &Measurements, rate: &Measurements) {
        self.root_moment.step(h, measured.root_moment, rate.root_moment);
        self.root_moment_rate.step(h, measured.root_moment, rate.root_moment);
        self.tip_shear_rate.step(h, measured.tip_shear, rate.tip_shear);
    }

    /// A step of all that learns, with the inputs held at `mean`.
    fn learn(&mut self, h: f64, mean: &Inputs) {
        let forces = self.forces(mean);
        let m = &mean.measured;
        let rate = [m.theta_dot[0], m.theta_dot[1], m.y_object_dot, 0.0];
        let [hub1, hub2, object] = &self.observers;
        let sights = Sights {
            position: [m.theta[0], m.theta[1], m.y_object, 0.0],
            rate,
            moving: match self.source {
                RateSource::Measured => rate,
                RateSource::Estimated => [hub1.rate, hub2.rate, object.rate, 0.0],
            },
            force: [forces[0], forces[1], forces[2], 0.0],
            load: [m.root_moment[0], m.root_moment[1], m.tip_shear[0] + m.tip_shear[1], 0.0],
        };
        let mut inertias = None;
        if self.networks.is_some() {
            self.step_networks(h, mean, &forces);
        } else {
            let [hub1, hub2, object] = self.inertias();
            inertias = Some([hub1, hub2, object, object]);
        }
        if self.of_size.as_ref().is_none_or(|of_size| of_size.h != h) {
            self.of_size = Some(self.of_size(h));
        }
        let Some(of_size) = &self.of_size else { return };
        self.found = Some(self.inertia.step(of_size, &sights, &mut self.observers, inertias));
    }

    /// A step of the networks with the inputs held at `mean`.
    fn step_networks(&mut self, h: f64, mean: &Inputs, forces: &[f64; 3]) {
        let known = self.known();
        let at = self.point(mean);
        let (_, shear_rate) = self.strain_rates(mean);
        let seen = self.seen(&at, &self.loops().at(&at), mean.measured.tip_shear, shear_rate);
        let Some(networks) = &mut self.networks else { return };
        let motions = motions(mean);
        let measured = std::array::from_fn(|i| (motions[i], forces[i]));
        networks.step(h, &self.gains.networks, &known, &seen, &mut self.observers, &measured);
    }

    /// What the networks see at a point whose surfaces are those of `outcome`, with the shears and their rates of each arm.
    fn seen<'a>(&self, at: &'a Point, outcome: &Outcome, shear: [f64; 2], shear_rate: [f64; 2]) -> Seen<'a> {
        let scaled = &self.scaled;
        Seen {
            at,
            surface: outcome.object,
            posture: outcome.posture,
            alpha_rate: -scaled.slope * at.v - self.loops().tip(at) * at.shear_rate,
            posture_alpha_rate: std::array::from_fn(|i| {
                -scaled.hub_slope[i] * at.omega[i] - scaled.hub_strain[i] * at.moment_rate[i] / at.inertia[i]
            }),
            shear,
            shear_rate,
        }
    }
}

/// Time derivatives of the law's state.
struct StateRates {
    observers: [Observer; 3],
    inertia: [f64; 3],
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

/// Root moments and tip shears with their rates, or the change of that.
fn loads(inputs: &Inputs) -> (Signals, Signals) {
    let m = &inputs.measured;
    (Signals { value: m.root_moment, rate: m.root_moment_dot }, Signals { value: m.tip_shear, rate: m.tip_shear_dot })
}

/// What the estimators of the inertias see of hub 1, hub 2 and the object; or the change of that, for it is linear.
fn moving(source: RateSource, observers: &[Observer; 3], inputs: &Inputs, forces: &[f64; 3]) -> [Moving; 3] {
    let (m, measured) = (&inputs.measured, motions(inputs));
    let loads = [m.root_moment[0], m.root_moment[1], m.tip_shear[0] + m.tip_shear[1]];
    std::array::from_fn(|i| {
        let rate = match source {
            RateSource::Measured => measured[i].rate,
            RateSource::Estimated => observers[i].rate,
        };
        Moving { rate, force: forces[i], load: loads[i] }
    })
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
        let settled = |moving: Moving| Estimator::settled(moving.rate, moving.load);
        self.inertia = self.moving(inputs, &[0.0; 3]).map(settled).into();
        self.found = None;
        self.root_moment.settle(inputs.measured.root_moment);
        let (moments, shears) = loads(inputs);
        self.root_moment_rate.settle(moments);
        self.tip_shear_rate.settle(shears);
        if let Some(networks) = &mut self.networks {
            networks.reset();
        }
    }

    fn commands(&mut self, inputs: &Inputs) -> Commands {
        self.act(inputs)
    }

    /// Observers and filters are exact for held inputs; inputs that ramp enter with their mean, an error of second order.
    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        if !rates.are_held() {
            return self.ramped_step(h, inputs, rates);
        }
        StepError::check_held(h, inputs)?;
        self.learn(h, inputs);
        self.follow(h, &inputs.measured, &Inputs::HELD.measured);
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
