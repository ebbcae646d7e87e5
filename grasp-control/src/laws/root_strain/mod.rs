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
//! **Surface.** The command pulls with k G(p) p and damps the object's rate with D = k + f G + 1/(m̂ C). G(p) = G/√(1 + |p| m̂ (kG/D)²/(2 q u_max)): near
//! the target a line, far from it k G(p) p/D is the rate √(2 q u_max |p|/m̂), from which the share q of the limit u_max brings an object of mass m̂
//! to rest at the target. So heavy objects do not overshoot.
//!
//! **Heavy hubs.** Near the target strain adds c_i (3EI_i/l)/Ĵ_i to the slope G_i, most of it while hubs are light. For heavy ones G_i grows by a part of
//! what is missing ([`Scaled`]).

// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]
// What is unsafe asks for a feature of the processor, and nothing of the data.
#![allow(clippy::unsafe_derive_deserialize)]
// Where a part of what is computed is not used, the compiler sees it only if it is inlined.
#![allow(clippy::inline_always)]

mod continuous;
mod gains;
mod inertia;
mod learning;
mod loops;
mod natural;
mod networks;
mod observed;
mod signals;
mod table;

pub use gains::{HubGains, ObjectGains, RootStrainGains};
pub use inertia::{FilterGains, InertiaGains, MassGains};
pub use natural::Scaled;
pub use networks::{Learner, NetworkGains};
pub(crate) use signals::{motions, quasi_static_shear_rates};

use crate::blocks::four::Lanes;
use crate::blocks::lowpass::LowPass;
use crate::blocks::observer::{Observer, RateSource};
use crate::blocks::slope::Slope;
use crate::law::{CommandJacobian, Law, StepError};
use crate::laws::encoders::Actuation;
use crate::laws::nabfc::{Estimates, RbfLayout, Surfaces};
use crate::signals::{Commands, INPUTS, Inputs};
use crate::target::{Arms, TargetSlopes};
use inertia::{Estimator, Estimators, Moving, OfSize, Prior};
use loops::{Loops, Outcome};
use networks::Networks;
use observed::Observers;
use parameter_table::InvalidParameter;
use serde::{Deserialize, Serialize};
use signals::loads;

/// The law of the module's text.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RootStrain {
    arms: Arms,
    gains: RootStrainGains,
    scaled: Scaled,
    actuation: Actuation,
    source: RateSource,
    observers: Observers,
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
            observers: [Observer::default(); 3].into(),
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
        Loops { gains: &self.gains, scaled: &self.scaled }
    }

    /// What the law has learnt: m̂, and Δ̂ as the weights of its constant basis functions, or those of the networks.
    #[must_use]
    pub fn estimates(&self) -> Estimates {
        let [hub1, hub2, object, _] = self.observers.disturbance.map(f64::abs);
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
            networks.norm_rates(&self.gains.networks, &known, &self.observers.all(), &state.observers, &motions)
        } else {
            let rate = |i: usize| state.observers[i].disturbance * self.observers.disturbance[i].signum();
            ([rate(0), rate(1)], [0.0; 2], rate(2), 0.0)
        };
        let [inertia1, inertia2, m_hat] = state.inertia;
        Estimates { m_hat, j_hat: [inertia1, inertia2], epsilon_hat, pi_hat, w_norm, u_norm }
    }
}

impl Law for RootStrain {
    fn arms(&self) -> &Arms {
        &self.arms
    }

    fn initialize(&mut self, inputs: &Inputs) {
        self.observers = motions(inputs).map(|motion| Observer::settled(self.source, motion)).into();
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
