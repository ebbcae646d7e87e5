//! Any law, from angles, position and strain alone.
//!
//! Few grasps have sensors of rates. [`Encoders`] puts an [`Observer`] per coordinate before a law: hubs and object are
//! inertias under a known force (the command after its limits, less the measured strain) and an unknown one. Rates of
//! strain follow from the rates of hubs and object, as for arms that bend as at rest, which is right below the first
//! beam mode.

mod continuous;

pub(crate) use continuous::{observers, put_observers};

use super::DIVISOR;
use super::root_strain::{motions, quasi_static_shear_rates};
use crate::blocks::observer::{Known, Observer, RateSource};
use crate::law::{CommandJacobian, Law, StepError};
use crate::signals::{Commands, Inputs, column};
use crate::target::Arms;
use parameter_table::{InvalidParameter, Parameter, Range, check, parameter};
use serde::{Deserialize, Serialize};

/// Poles of observers and filters \[rad/s\].
pub(crate) const POLES: Range = Range::new(0.1, 1e5);

/// What a controller that predicts or limits knows of the actuators and of what they move.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Actuation {
    /// Largest torque of a hub \[N·m\].
    pub torque_limit: f64,
    /// Largest force on the object \[N\].
    pub force_limit: f64,
    /// Inertias of the hubs \[kg·m²\].
    pub hub_inertia: [f64; 2],
    /// Mass that moves with the object, m₁ + m₂ + M \[kg\]; laws that estimate it do not use this one.
    pub mass: f64,
    /// Poles of the observers that estimate rates \[rad/s\].
    pub bandwidth: f64,
}

impl Default for Actuation {
    /// The limits and inertias of Section IV.
    fn default() -> Self {
        Self { torque_limit: 2.0, force_limit: 0.3, hub_inertia: [0.0073; 2], mass: 0.5, bandwidth: 300.0 }
    }
}

impl Actuation {
    /// Limits and observers.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<Actuation>; 6] = [
            parameter!("tau_limit", "N.m", DIVISOR, "Largest torque a hub's motor gives", torque_limit),
            parameter!("u_limit", "N", DIVISOR, "Largest force the object's actuator gives", force_limit),
            parameter!("observer_inertia1", "kg.m2", DIVISOR, "Inertia of hub 1 in the observers", hub_inertia[0]),
            parameter!("observer_inertia2", "kg.m2", DIVISOR, "Inertia of hub 2 in the observers", hub_inertia[1]),
            parameter!(
                "observer_mass",
                "kg",
                DIVISOR,
                "Moving mass m1 + m2 + M in the observers of laws that do not estimate it",
                mass
            ),
            parameter!(
                "observer_bandwidth",
                "rad/s",
                POLES,
                "Poles of the observers that estimate rates, where rate_source asks for it",
                bandwidth
            ),
        ];
        &ROWS
    };

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is not a number in its range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check(Self::PARAMETERS, self)
    }

    /// The known forces on hubs and object: limited commands less the measured loads.
    pub(crate) fn forces(&self, commands: &Commands, inputs: &Inputs) -> [f64; 3] {
        let limit = self.torque_limit;
        let m = &inputs.measured;
        [
            commands.tau[0].clamp(-limit, limit) - m.root_moment[0],
            commands.tau[1].clamp(-limit, limit) - m.root_moment[1],
            commands.u.clamp(-self.force_limit, self.force_limit) - m.tip_shear[0] - m.tip_shear[1],
        ]
    }
}

/// A law with the rates it is given, or with estimated ones.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Encoders<L> {
    law: L,
    source: RateSource,
    actuation: Actuation,
    /// Hub 1, hub 2, object.
    observers: [Observer; 3],
}

impl<L: Clone> Clone for Encoders<L> {
    fn clone(&self) -> Self {
        let Self { law, source, actuation, observers } = self;
        Self { law: law.clone(), source: *source, actuation: *actuation, observers: *observers }
    }

    /// The same in the memory that is there.
    fn clone_from(&mut self, from: &Self) {
        let Self { law, source, actuation, observers } = from;
        (self.source, self.actuation, self.observers) = (*source, *actuation, *observers);
        self.law.clone_from(law);
    }
}

impl<L: Law> Encoders<L> {
    /// Puts observers before `law`, if the source of rates asks for it.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    pub fn new(law: L, source: RateSource, actuation: Actuation) -> Result<Self, InvalidParameter> {
        actuation.validate()?;
        Ok(Self { law, source, actuation, observers: [Observer::default(); 3] })
    }

    /// The law behind the observers.
    #[must_use]
    pub const fn law(&self) -> &L {
        &self.law
    }

    /// The law behind the observers, to be retuned.
    pub const fn law_mut(&mut self) -> &mut L {
        &mut self.law
    }

    /// Changes limits and observers while the law runs.
    ///
    /// # Errors
    /// The first parameter that is not in its range; nothing is then changed.
    pub fn set_actuation(&mut self, actuation: Actuation) -> Result<(), InvalidParameter> {
        actuation.validate()?;
        self.actuation = actuation;
        Ok(())
    }

    /// Whether source, limits and observers are those of another one.
    #[must_use]
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.source == other.source && self.actuation == other.actuation
    }

    /// What the law is given: `inputs`, with the rates that the observers estimate.
    #[must_use]
    pub fn seen(&self, inputs: &Inputs) -> Inputs {
        match self.source {
            RateSource::Measured => *inputs,
            RateSource::Estimated => self.with_rates(inputs, self.observers.map(|observer| observer.rate)),
        }
    }

    /// Which directions of the inputs the law sees at once.
    #[must_use]
    pub fn seen_direction(&self, direction: &Inputs) -> Inputs {
        match self.source {
            RateSource::Measured => *direction,
            RateSource::Estimated => self.with_rates(direction, [0.0; 3]),
        }
    }

    /// Time derivatives of what the law sees.
    pub fn seen_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Inputs {
        match self.source {
            RateSource::Measured => *rates,
            RateSource::Estimated => {
                let forces = self.forces(inputs);
                let motions = motions(inputs);
                let accelerations =
                    [0, 1, 2].map(|i| self.observers[i].derivative(&self.known(i), motions[i], forces[i]).rate);
                self.with_rates(rates, accelerations)
            }
        }
    }

    fn with_rates(&self, inputs: &Inputs, [hub1, hub2, object]: [f64; 3]) -> Inputs {
        let arms = self.law.arms();
        // Rates of stiff arms are larger than those that they come from; the law refuses what is no usable input.
        let usable = |rate: f64| rate.clamp(-Inputs::LARGEST, Inputs::LARGEST);
        let shear = quasi_static_shear_rates(arms, [hub1, hub2], object).map(usable);
        let mut seen = *inputs;
        seen.measured.theta_dot = [hub1, hub2].map(usable);
        seen.measured.y_object_dot = usable(object);
        seen.measured.tip_shear_dot = shear;
        seen.measured.root_moment_dot = shear.map(|rate| usable(-arms.length * rate));
        seen
    }

    fn known(&self, index: usize) -> Known {
        let Actuation { torque_limit, force_limit, hub_inertia, mass, bandwidth } = self.actuation;
        let (inertia, limit) = if index < 2 { (hub_inertia[index], torque_limit) } else { (mass, force_limit) };
        Known { source: self.source, bandwidth, inertia, limit }
    }

    fn forces(&mut self, inputs: &Inputs) -> [f64; 3] {
        let seen = self.seen(inputs);
        let commands = self.law.commands(&seen);
        self.actuation.forces(&commands, inputs)
    }

    // Functions of their own, so that the usual way needs no room on the stack.
    #[inline(never)]
    fn estimated_commands(&mut self, inputs: &Inputs) -> Commands {
        let seen = self.seen(inputs);
        self.law.commands(&seen)
    }

    #[inline(never)]
    fn estimated_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        StepError::check(h, inputs, rates)?;
        let mean = inputs.after(0.5 * h, rates);
        let forces = self.forces(&mean);
        let motions = motions(&mean);
        let seen = self.seen(inputs);
        self.law.step(h, &seen, &self.with_rates(rates, [0.0; 3]))?;
        let known: [Known; 3] = std::array::from_fn(|i| self.known(i));
        for (i, observer) in self.observers.iter_mut().enumerate() {
            observer.step(h, &known[i], motions[i], forces[i]);
        }
        Ok(())
    }
}

/// Columns of the rates in a Jacobian row.
const RATES: [usize; 7] = [
    column::THETA_DOT,
    column::THETA_DOT + 1,
    column::Y_OBJECT_DOT,
    column::TIP_SHEAR_DOT,
    column::TIP_SHEAR_DOT + 1,
    column::ROOT_MOMENT_DOT,
    column::ROOT_MOMENT_DOT + 1,
];

impl<L: Law> Law for Encoders<L> {
    fn arms(&self) -> &Arms {
        self.law.arms()
    }

    fn initialize(&mut self, inputs: &Inputs) {
        self.observers = motions(inputs).map(|motion| Observer::settled(self.source, motion));
        self.law.initialize(&self.seen(inputs));
    }

    // On the way of every step, and called from a crate that is compiled for size.
    #[inline]
    fn commands(&mut self, inputs: &Inputs) -> Commands {
        if self.source == RateSource::Measured { self.law.commands(inputs) } else { self.estimated_commands(inputs) }
    }

    /// The observers are exact for held inputs; inputs that ramp enter with their mean, an error of second order. The law
    /// holds estimated rates over the step.
    #[inline]
    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        if self.source == RateSource::Measured {
            self.law.step(h, inputs, rates)
        } else {
            self.estimated_step(h, inputs, rates)
        }
    }

    fn jacobian(&mut self, inputs: &Inputs) -> CommandJacobian {
        let seen = self.seen(inputs);
        let mut jacobian = self.law.jacobian(&seen);
        if self.source == RateSource::Estimated {
            for row in jacobian.tau.iter_mut().chain([&mut jacobian.u]) {
                for rate in RATES {
                    row[rate] = 0.0;
                }
            }
        }
        jacobian
    }

    fn command_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Commands {
        let (seen, seen_rates) = (self.seen(inputs), self.seen_rates(inputs, rates));
        self.law.command_rates(&seen, &seen_rates)
    }
}
