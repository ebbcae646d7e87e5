//! Exact steps.

use super::model::{MAX_KINK_TIMES, Model};
use super::{Plant, Workspace};
use crate::dynamics::FORCES;
use crate::kernel::dot;
use crate::modal::NEGLIGIBLE;
use crate::propagator::Propagator;
use crate::signals::Inputs;
use crate::state::StepError;

impl Plant {
    /// Advances by h seconds, exactly: commands and disturbances are `inputs` + `rates`·t for 0 ≤ t ≤ h. Zero rates hold
    /// the inputs.
    ///
    /// A ramp that crosses kinks of an actuator is followed exactly too, piece by piece. The first step of a plant computes
    /// its modes, and the first step of a size the functions of each mode; the last eight sizes are remembered. A plant
    /// without modal form uses a matrix exponential for each size instead, and a series after more than eight new sizes in
    /// a row.
    ///
    /// # Errors
    /// See [`StepError`]; the plant is then unchanged.
    #[inline]
    pub fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        if self.held_step(h, inputs, rates) { Ok(()) } else { self.any_step(h, inputs, rates) }
    }

    /// Any step, whatever its size and inputs.
    #[inline(never)]
    pub(super) fn any_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        // Also a step that is refused may make its table the last.
        self.calm = 0;
        self.limited = self.is_any_limited(inputs);
        if !(h > 0.0 && h.is_finite()) {
            return Err(StepError::NotPositive { h });
        }
        let longest = self.longest_step();
        if h > longest {
            return Err(StepError::TooLong { h, longest });
        }
        if !(inputs.is_finite() && rates.is_finite()) {
            return Err(StepError::InputNotFinite);
        }
        if let Some(contacts) = &mut self.contacts {
            // That it is time to look at the contacts.
            self.pulls = true;
            return contacts.step(&self.model, &mut self.state, &mut self.signals, h, inputs, rates);
        }
        if h > self.longest_part() {
            return self.long_step(h, inputs, rates);
        }
        self.prepare();
        self.work.next.sizes = self.state.sizes;
        self.work.next.sizes.note(h);
        let repeats = self.work.next.sizes.repeat();
        let modal = self.model.modal().is_some();
        if *rates == Inputs::ZERO && (repeats | modal) {
            if modal {
                self.modal_step(h, inputs, rates, &[], repeats);
            } else {
                self.whole_step(h, &self.model.forces(inputs), None);
            }
        } else {
            // Outputs change at these rates, whether or not the step succeeds.
            if !(all_usable(&rates.commands()) & all_usable(&rates.disturbances())) {
                return Err(StepError::Overflow);
            }
            let mut times = [0.0; MAX_KINK_TIMES];
            let kinks = self.model.kink_times(h, inputs, rates, &mut times);
            if modal {
                self.modal_step(h, inputs, rates, kinks, repeats);
            } else if kinks.is_empty() && repeats {
                let force_rates = self.model.force_rates(&at(inputs, rates, h / 2.0), rates);
                self.whole_step(h, &self.model.forces(inputs), Some(&force_rates));
            } else {
                self.broken_step(h, inputs, rates, kinks);
            }
        }
        let next = &mut self.work.next;
        let signals = if let Some(modal) = self.model.modal() {
            modal.signals(&next.coordinates)
        } else {
            flush(&mut next.coordinates);
            self.model.dynamics.signals(&next.coordinates)
        };
        let usable = all_usable(&inputs.disturbances())
            & all_usable(&next.coordinates)
            & all_usable(&next.position)
            & all_usable(&signals);
        if !(usable & next.supplied_energy.is_finite()) {
            return Err(StepError::Overflow);
        }
        self.signals = signals;
        std::mem::swap(&mut self.state, next);
        self.pulls = self.may_pull(inputs);
        Ok(())
    }

    /// A step that is too long for one piece, in equal parts.
    #[cold]
    fn long_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        // One more than the quotient, so that rounding cannot make a part too long.
        let parts = (h / self.longest_part()).floor() + 1.0;
        let part = h / parts;
        let before = self.state.clone();
        let mut i = 0.0;
        while i < parts {
            if let Err(error) = self.any_step(part, &at(inputs, rates, i * part), rates) {
                self.state = before;
                self.read_signals();
                return Err(error);
            }
            i += 1.0;
        }
        (self.pulls, self.limited) = (self.may_pull(inputs), self.is_any_limited(inputs));
        Ok(())
    }

    /// One step with forces g + r t, into the workspace's next state.
    fn whole_step(&mut self, h: f64, forces: &[f64; FORCES], rates: Option<&[f64; FORCES]>) {
        self.prepare_increments();
        let n = self.state.coordinates.len();
        let Model { extended, propagators, .. } = &*self.model;
        let propagator = self.cache.propagators.get(propagators, h, || Propagator::new(extended, h));
        let Workspace { drive, increment, next, .. } = &mut self.work;
        drive[..n].copy_from_slice(&self.state.coordinates);
        drive[n..n + FORCES].copy_from_slice(forces);
        let mut length = n + FORCES;
        if let Some(rates) = rates {
            drive[length..length + FORCES].copy_from_slice(rates);
            length += FORCES;
        }
        propagator.step(&drive[..length], increment);
        let (change, travel) = increment.as_flattened().split_at(n);
        for ((next, x), change) in next.coordinates.iter_mut().zip(&self.state.coordinates).zip(change) {
            *next = x + change;
        }
        let mut work = dot(forces, travel);
        if let Some(rates) = rates {
            // ∫ t Θ̇ dt = h Θ(h) − ∫ Θ dt
            let integral = propagator.travel_integral(&drive[..length]);
            work += (0..FORCES).map(|i| rates[i] * (h * travel[i] - integral[i])).sum::<f64>();
        }
        next.travel(&self.state, &std::array::from_fn(|i| travel[i]));
        next.supplied_energy = self.state.supplied_energy + work;
    }

    /// One step whose forces have kinks at the given times, if any, without a matrix of its own, into the workspace's next
    /// state.
    fn broken_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs, kinks: &[f64]) {
        self.prepare_increments();
        let Model { extended, dynamics, parameters, .. } = &*self.model;
        let layout = extended.layout;
        let n = self.state.coordinates.len();
        let Workspace { drive, increment, next, .. } = &mut self.work;
        let z = &mut drive[..];
        z[..n].copy_from_slice(&self.state.coordinates);
        next.supplied_energy = self.state.supplied_energy;
        let mut total = [0.0; FORCES];
        let mut begin = 0.0;
        for end in kinks.iter().copied().chain([h]) {
            let duration = end - begin;
            let forces = self.model.forces(&at(inputs, rates, begin));
            let force_rates = self.model.force_rates(&at(inputs, rates, f64::midpoint(begin, end)), rates);
            z[layout.travel()..layout.force()].fill(0.0);
            z[layout.force()..layout.force_rate()].copy_from_slice(&forces);
            z[layout.force_rate()..].copy_from_slice(&force_rates);
            let tips = [0, 1].map(|i| z[dynamics.tip_coordinate(i)]);
            extended.advance(duration, z, increment);
            let (travel, integral) = (layout.travel(), layout.travel_integral());
            for i in 0..FORCES {
                let lag = duration * z[travel + i] - z[integral + i];
                next.supplied_energy += forces[i] * z[travel + i] + force_rates[i] * lag;
            }
            // Δθ_i follows from (12) as in a whole step.
            let rise = z[travel + 2];
            for i in 0..2 {
                let bend = dynamics.tip_compliance[i] * (z[dynamics.tip_coordinate(i)] - tips[i]);
                total[i] += (bend + rise) / parameters.length;
            }
            total[2] += rise;
            begin = end;
        }
        next.coordinates.copy_from_slice(&z[..n]);
        next.travel(&self.state, &total);
    }
}

/// Sets coordinates below [`NEGLIGIBLE`] to zero.
pub(crate) fn flush(coordinates: &mut [f64]) {
    for x in coordinates {
        *x = if x.abs() < NEGLIGIBLE { 0.0 } else { *x };
    }
}

/// Numbers above some 1e100 become infinite times this: their squares (energies) and their rates would leave the range of
/// floating-point numbers.
const REACH: f64 = 1e208;

/// Whether all numbers are so far inside the range of floating-point numbers that every output computed from them is
/// finite. Several numbers are tested at a time: infinity and NaN persist in a sum.
pub(crate) fn all_usable(numbers: &[f64]) -> bool {
    let (chunks, rest) = numbers.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for chunk in chunks {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum += REACH * x;
        }
    }
    let rest: f64 = rest.iter().map(|x| REACH * x).sum();
    sums.iter().fold(rest, |sum, x| sum + x).is_finite()
}

/// Inputs at time t of a ramp.
pub(crate) fn at(inputs: &Inputs, rates: &Inputs, t: f64) -> Inputs {
    let pair = |value: [f64; 2], rate: [f64; 2]| [value[0] + rate[0] * t, value[1] + rate[1] * t];
    Inputs {
        torque_command: pair(inputs.torque_command, rates.torque_command),
        force_command: inputs.force_command + rates.force_command * t,
        hub_disturbance: pair(inputs.hub_disturbance, rates.hub_disturbance),
        object_disturbance: inputs.object_disturbance + rates.object_disturbance * t,
    }
}
