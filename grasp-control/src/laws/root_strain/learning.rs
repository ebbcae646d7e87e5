//! How the law learns disturbances and inertias from the errors of predictions.

use super::RootStrain;
use super::inertia::{Moving, OfSize, Priors, Sights};
use super::loops::{Outcome, Point};
use super::networks::Seen;
use super::signals::motions;
use crate::blocks::four::{Four, Narrow};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};
use crate::blocks::observer::{Known, Observer, RateSource};
use crate::law::StepError;
use crate::laws::encoders::Actuation;
use crate::signals::{Inputs, Measurements};

impl RootStrain {
    /// What is known of hub 1, hub 2 and the object.
    pub(super) fn known(&self) -> [Known; 3] {
        let (gains, actuation, source, inertia) = (&self.gains, &self.actuation, self.source, self.inertias());
        let known = |i: usize, bandwidth: f64, limit: f64| Known { source, bandwidth, inertia: inertia[i], limit };
        [
            known(0, gains.hub[0].observer, actuation.torque_limit),
            known(1, gains.hub[1].observer, actuation.torque_limit),
            known(2, gains.object.observer, actuation.force_limit),
        ]
    }

    /// The known force on each coordinate: what the limited command does, less the measured load.
    pub(super) fn forces(&self, inputs: &Inputs) -> [f64; 3] {
        self.actuation.forces(&self.act(inputs), inputs)
    }

    /// Ĵ₁, Ĵ₂ \[kg·m²\] and m̂ \[kg\].
    pub(super) fn inertias(&self) -> [f64; 3] {
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
    pub(super) fn moving(&self, inputs: &Inputs, forces: &[f64; 3]) -> [Moving; 3] {
        moving(self.source, &self.observers.all(), inputs, forces)
    }

    pub(super) fn state_rates(&self, inputs: &Inputs) -> StateRates {
        let (forces, motions, known) = (self.forces(inputs), motions(inputs), self.known());
        let moving = self.moving(inputs, &forces);
        StateRates {
            observers: std::array::from_fn(|i| self.observers.of(i).derivative(&known[i], motions[i], forces[i])),
            inertia: std::array::from_fn(|i| {
                self.inertia.of(i).inertia_rate(&self.gains.filter, &self.priors[i], moving[i])
            }),
        }
    }

    /// A step with inputs that change. Not inlined, because few hosts ask for it.
    #[inline(never)]
    pub(super) fn ramped_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        StepError::check(h, inputs, rates)?;
        self.learn(h, &inputs.after(0.5 * h, rates));
        self.follow(h, &inputs.measured, &rates.measured);
        Ok(())
    }

    /// A step of the low-passes.
    #[inline(always)]
    pub(super) fn follow(&mut self, h: f64, measured: &Measurements, rate: &Measurements) {
        self.root_moment.step(h, measured.root_moment, rate.root_moment);
        self.root_moment_rate.step(h, measured.root_moment, rate.root_moment);
        self.tip_shear_rate.step(h, measured.tip_shear, rate.tip_shear);
    }

    /// A step of all that learns, with the inputs held at `mean`.
    pub(super) fn learn(&mut self, h: f64, mean: &Inputs) {
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.learn_wide(h, mean) };
        }
        self.learn_here::<Narrow>(h, mean);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn learn_wide(&mut self, h: f64, mean: &Inputs) {
        self.learn_here::<Wide>(h, mean);
    }

    /// Here what is measured gets into the lanes of a register, and not through memory: there a processor waits until all four are in its cache.
    #[inline(always)]
    fn learn_here<V: Four>(&mut self, h: f64, mean: &Inputs) {
        let forces = self.forces(mean);
        let m = &mean.measured;
        let rate = V::pairs(m.theta_dot, [m.y_object_dot, 0.0]);
        let sights = Sights {
            position: V::pairs(m.theta, [m.y_object, 0.0]),
            rate,
            moving: match self.source {
                RateSource::Measured => rate,
                RateSource::Estimated => V::load(&self.observers.rate),
            },
            force: V::pairs([forces[0], forces[1]], [forces[2], 0.0]),
            load: V::pairs(m.root_moment, [m.tip_shear[0] + m.tip_shear[1], 0.0]),
        };
        let mut inertias = None;
        if self.networks.is_some() {
            self.step_networks(h, mean, &forces);
        } else {
            let [hub1, hub2, object] = self.inertias();
            inertias = Some(V::pairs([hub1, hub2], [object; 2]));
        }
        if self.of_size.as_ref().is_none_or(|of_size| of_size.h != h) {
            self.of_size = Some(self.of_size(h));
        }
        let Some(of_size) = &self.of_size else { return };
        self.found = Some(self.inertia.step(of_size, &sights, &mut self.observers, inertias));
    }

    /// A step of the networks with the inputs held at `mean`.
    #[inline(never)]
    fn step_networks(&mut self, h: f64, mean: &Inputs, forces: &[f64; 3]) {
        let known = self.known();
        let at = self.point(mean);
        let (_, shear_rate) = self.strain_rates(mean);
        let seen = self.seen(&at, &self.loops().at(&at), mean.measured.tip_shear, shear_rate);
        let Some(networks) = &mut self.networks else { return };
        let motions = motions(mean);
        let measured = std::array::from_fn(|i| (motions[i], forces[i]));
        let mut observers = self.observers.all();
        networks.step(h, &self.gains.networks, &known, &seen, &mut observers, &measured);
        self.observers = observers.into();
    }

    /// What the networks see at a point whose surfaces are those of `outcome`, with the shears and their rates of each arm.
    pub(super) fn seen<'a>(&self, at: &'a Point, outcome: &Outcome, shear: [f64; 2], shear_rate: [f64; 2]) -> Seen<'a> {
        let (scaled, loops) = (&self.scaled, self.loops());
        Seen {
            at,
            surface: outcome.object,
            posture: outcome.posture,
            alpha_rate: -scaled.slope * at.v - loops.tip(at) * at.shear_rate,
            posture_alpha_rate: std::array::from_fn(|i| {
                -loops.hub_slope(i, at.inertia[i]) * at.omega[i]
                    - scaled.hub_strain[i] * at.moment_rate[i] / at.inertia[i]
            }),
            shear,
            shear_rate,
        }
    }
}

/// Time derivatives of the law's state.
pub(super) struct StateRates {
    pub observers: [Observer; 3],
    pub inertia: [f64; 3],
}

/// What the estimators of the inertias see of hub 1, hub 2 and the object; or the change of that, for it is linear.
pub(super) fn moving(source: RateSource, observers: &[Observer; 3], inputs: &Inputs, forces: &[f64; 3]) -> [Moving; 3] {
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
