//! The consequences of the parameters: matrices, actuators, and the maps from inputs and signals to forces and outputs.

use crate::actuator::Actuator;
use crate::cache::Shared;
use crate::dynamics::{Dynamics, FORCES, Signals, TIP_SHEAR, TIP_SHEAR_RATE, builtin_forces};
use crate::extended::Extended;
use crate::modal::{DeadZones, Four, Lanes, Modal, Table};
use crate::parameters::{ActuatorModel, Channel, Parameters};
use crate::propagator::Propagator;
use crate::signals::{Direct, Inputs};
use std::sync::OnceLock;

/// Everything that follows from the parameters alone, except the start values.
#[derive(Debug)]
pub(crate) struct Model {
    /// The parameters, with default start values.
    pub parameters: Parameters,
    pub dynamics: Dynamics,
    pub extended: Extended,
    pub actuators: [Actuator; FORCES],
    /// The actuators' dead zones, if they have any.
    dead_zones: Option<DeadZones>,
    /// Commands at which the actuators' limits begin: the lower ones, the upper ones.
    pub limits: [Lanes; 2],
    /// Contact forces per signal of `GRIP_SIGNALS`, and per force on the object.
    grip: ([Lanes; 2], [f64; 2]),
    /// The modal form, computed at the first step; `None` inside if there is none.
    modal: OnceLock<Option<Modal>>,
    /// Steps of the sizes last used: in modal coordinates, and by dense matrices.
    pub tables: Shared<Table>,
    pub propagators: Shared<Propagator>,
}

/// Most kinks that three ramps can meet.
pub(crate) const MAX_KINK_TIMES: usize = FORCES * Actuator::MAX_KINKS;

/// The signals that λ depends on, as a step has them in lanes.
const GRIP_SIGNALS: [usize; 4] = [TIP_SHEAR_RATE[0], TIP_SHEAR_RATE[1], TIP_SHEAR[0], TIP_SHEAR[1]];

impl Model {
    /// Assembles the plant of valid parameters.
    pub fn new(parameters: Parameters) -> Self {
        let dynamics = Dynamics::new(&parameters);
        let extended = Extended::new(&dynamics, parameters.length);
        let channels = [&parameters.torque_channel, &parameters.torque_channel, &parameters.force_channel];
        let each = |of: fn(&Channel) -> f64| [of(channels[0]), of(channels[1]), of(channels[2]), 0.0];
        let actuators = channels.map(|channel| Actuator::new(parameters.actuator_model, channel));
        let grip = |signals: &Signals, force| {
            let [first, second] = lambda(&parameters, signals, force);
            [-first, second]
        };
        let mut of_signals = [Lanes::default(); 2];
        for (lane, signal) in GRIP_SIGNALS.into_iter().enumerate() {
            let mut signals = Signals::default();
            signals[signal] = 1.0;
            [of_signals[0][lane], of_signals[1][lane]] = grip(&signals, 0.0);
        }
        let grip = (of_signals, grip(&Signals::default(), 1.0));
        let limit = |side: usize, of_none: f64| {
            let [first, second, third] = actuators.each_ref().map(|actuator| actuator.limits()[side]);
            [first, second, third, of_none]
        };
        Self {
            dynamics,
            extended,
            dead_zones: (parameters.actuator_model == ActuatorModel::Raw).then_some(DeadZones {
                upper: (each(|c| c.m_r), each(|c| c.k_r)),
                lower: (each(|c| c.m_l), each(|c| c.k_l)),
            }),
            limits: [limit(0, f64::NEG_INFINITY), limit(1, f64::INFINITY)],
            parameters,
            actuators,
            grip,
            modal: OnceLock::new(),
            tables: Shared::default(),
            propagators: Shared::default(),
        }
    }

    /// The modal form, if there is one. The first call makes it.
    #[inline]
    pub fn modal(&self) -> Option<&Modal> {
        self.modal.get_or_init(|| Modal::new(&self.dynamics, &self.parameters)).as_ref()
    }

    /// Forces that actuators and external disturbances exert together.
    #[inline]
    pub fn forces(&self, inputs: &Inputs) -> [f64; FORCES] {
        let (outputs, disturbances) = (self.outputs(&inputs.commands()), inputs.disturbances());
        std::array::from_fn(|i| outputs[i] + disturbances[i])
    }

    /// The same in lanes.
    #[allow(clippy::inline_always)] // Into a function for wide registers, or the compiler does not use these registers.
    #[inline(always)]
    pub fn forces_in_lanes<V: Four>(&self, commands: V, disturbances: V) -> V {
        let [low, high] = self.limits.each_ref().map(V::load);
        let mut outputs = commands.limited(low, high);
        if let Some(zones) = &self.dead_zones {
            outputs = outputs.behind_dead_zones(zones);
        }
        outputs.plus(disturbances)
    }

    /// Whether any command is at a limit of its actuator.
    #[allow(clippy::inline_always)] // As above.
    #[inline(always)]
    pub fn is_any_limited<V: Four>(&self, commands: V) -> bool {
        let [low, high] = self.limits.each_ref().map(V::load);
        commands.is_any_limited(low, high)
    }

    /// What the actuators put out.
    #[inline(never)]
    fn outputs(&self, commands: &[f64; FORCES]) -> [f64; FORCES] {
        std::array::from_fn(|i| self.actuators[i].output(commands[i]))
    }

    /// Change of the actuator outputs for a change of the commands.
    pub fn command_response(&self, inputs: &Inputs, direction: &Inputs) -> [f64; FORCES] {
        let (commands, direction) = (inputs.commands(), direction.commands());
        std::array::from_fn(|i| self.actuators[i].slope(commands[i]) * direction[i])
    }

    /// Change of [`Self::forces`].
    pub fn force_rates(&self, inputs: &Inputs, rates: &Inputs) -> [f64; FORCES] {
        let (response, disturbances) = (self.command_response(inputs, rates), rates.disturbances());
        std::array::from_fn(|i| response[i] + disturbances[i])
    }

    /// Ascending times strictly inside (0, h) at which a ramped command meets a kink of its actuator.
    pub fn kink_times<'a>(
        &self,
        h: f64,
        inputs: &Inputs,
        rates: &Inputs,
        times: &'a mut [f64; MAX_KINK_TIMES],
    ) -> &'a [f64] {
        let mut count = 0;
        for (actuator, (command, rate)) in
            self.actuators.iter().zip(inputs.commands().into_iter().zip(rates.commands()))
        {
            for kink in actuator.kinks() {
                // A rate of zero gives an infinity or a NaN, which are not inside.
                let time = (kink - command) / rate;
                if time > 0.0 && time < h {
                    times[count] = time;
                    count += 1;
                }
            }
        }
        let times = &mut times[..count];
        times.sort_unstable_by(f64::total_cmp);
        times
    }

    /// Outputs with direct feedthrough. Linear in all arguments, so it also maps rates to rates.
    ///
    /// λ_i = EI_i w_i'''(l) + m_i ÿ_M with ÿ_M from (11), which is (13) and (14); with Kelvin–Voigt damping the shear is
    /// the transmitted one, EI_i(w_i'''(l) + κ ẇ_i'''(l)).
    #[inline]
    pub fn direct(&self, signals: &Signals, applied: &[f64; FORCES], disturbances: &[f64; FORCES]) -> Direct {
        let lambda = self.lambda(signals, applied[2] + disturbances[2]);
        Direct { torque: [applied[0], applied[1]], force: applied[2], lambda, contact_force: [-lambda[0], lambda[1]] }
    }

    /// λ_i with this force on the object besides the built-in one, (13) and (14).
    #[inline]
    pub fn lambda(&self, signals: &Signals, force: f64) -> [f64; 2] {
        lambda(&self.parameters, signals, force)
    }

    /// Contact forces with this force on the object, to rounding: no division and few operations one after the other, since a step waits
    /// for them. Whether any is negative.
    #[allow(clippy::inline_always)] // As above.
    #[inline(always)]
    pub fn pulls<V: Four>(&self, of_tips: V, force: f64) -> bool {
        let (of_signals, of_force) = &self.grip;
        let of_signals = of_signals.each_ref().map(|per_signal| V::load(per_signal).times(of_tips));
        V::is_any_sum_negative(of_signals, of_force.map(|per_force| per_force * force))
    }

    /// The contact forces that [`pulls`](Self::pulls) looks at.
    #[cfg(test)]
    pub fn grip(&self, of_tips: Lanes, force: f64) -> [f64; 2] {
        let (of_signals, of_force) = &self.grip;
        [0, 1].map(|i| crate::kernel::dot(&of_signals[i], &of_tips) + of_force[i] * force)
    }

    /// The signals that contact forces depend on.
    pub fn of_tips(signals: &Signals) -> Lanes {
        GRIP_SIGNALS.map(|signal| signals[signal])
    }

    /// Tip deflections of energy coordinates.
    pub fn tip_deflection(&self, x: &[f64]) -> [f64; 2] {
        [0, 1].map(|arm| self.dynamics.tip_compliance[arm] * x[self.dynamics.tip_coordinate(arm)])
    }

    /// The homogeneous part of (12), l θ_i − w_i(l) − `y_M`.
    pub fn constraint(&self, tip: &[f64; 2], position: &[f64; 3]) -> [f64; 2] {
        [0, 1].map(|arm| self.parameters.length * position[arm] - tip[arm] - position[2])
    }
}

#[inline]
fn lambda(parameters: &Parameters, signals: &Signals, force: f64) -> [f64; 2] {
    let p = parameters;
    let shear = [0, 1].map(|i| signals[TIP_SHEAR[i]] + p.kelvin_voigt * signals[TIP_SHEAR_RATE[i]]);
    let acceleration = (force + builtin_forces(p, signals)[2] - shear[0] - shear[1]) / p.moving_mass();
    [0, 1].map(|i| shear[i] + p.arms[i].tip_mass * acceleration)
}
