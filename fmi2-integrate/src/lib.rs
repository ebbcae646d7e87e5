#![doc = include_str!("../README.md")]

use std::cell::RefCell;

use fmi2_export::integration::{Equations, tolerance};
use fmi2_export::{Failure, ModelExchange, Step};
use ivp::dense::StepInterpolant;
use ivp::ivp::FirstOrderSystem;
use ivp::methods::DOP853;
use ivp::solout::{ControlFlag, SolOut};
use ivp::status::Status;

/// Relative tolerance if the host gives none.
const TOLERANCE: f64 = 1e-9;
/// The least one: below, rounding decides.
const LEAST_TOLERANCE: f64 = 1e-13;
/// The largest number of events in a communication step, and of repetitions that one event may request.
const MOST_EVENTS: u32 = 1000;
/// How many steps the solver may take between two events.
const MOST_STEPS: usize = 10_000;
/// The shortest time interval (s) for the solver, whose step control divides by the length of the interval.
const SHORTEST: f64 = 1e-200;

/// Communication steps of a model that only defines its time derivatives.
pub trait Integrate {
    /// Computes the step by integrating the time derivatives of the model's continuous states, through all its events.
    /// Inputs are held. The relative tolerance is that of the experiment, or 10⁻⁹; the absolute tolerance is the relative
    /// one times the nominal value of each state.
    ///
    /// The solver is DOP853, the explicit Runge–Kutta method of order 8 by Dormand and Prince with step control and dense
    /// output (E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., Springer 1993).
    /// It restarts at every communication point and every event, so only the state of the model has to be saved. It
    /// allocates memory.
    ///
    /// # Errors
    /// [`Failure::Discard`] if the derivatives cannot be computed, the model is stiff, or events do not come to an end: a
    /// shorter step may help. Also every failure of the model itself.
    fn integrate<M: ModelExchange>(&mut self, model: &mut M) -> Result<(), Failure>;
}

impl Integrate for Step<'_> {
    fn integrate<M: ModelExchange>(&mut self, model: &mut M) -> Result<(), Failure> {
        let equations = Equations::of(self)?;
        let tolerance = tolerance(self).unwrap_or(TOLERANCE).max(LEAST_TOLERANCE);
        let end = self.time + self.size;
        let system = System { equations, model: RefCell::new(model) };
        let mut now = self.time;
        for _ in 0..MOST_EVENTS {
            let next_time = system.update_discrete_states(now, self)?;
            if now >= end {
                return Ok(());
            }
            let target = next_time.filter(|time| *time < end).map_or(end, |time| time.max(now));
            now = system.advance(now, target, tolerance)?;
        }
        Err(Failure::discard(format!("more than {MOST_EVENTS} events in one step, the last at t = {now:?} s")))
    }
}

/// A model as a system of differential equations. It is only borrowed for the time of one evaluation.
struct System<'a, M> {
    equations: Equations<'a, M>,
    model: RefCell<&'a mut M>,
}

impl<M: ModelExchange> System<'_, M> {
    /// Goes from one time towards another, to the first event on the way at most; when it got to.
    fn advance(&self, from: f64, to: f64, tolerance: f64) -> Result<f64, Failure> {
        if to <= from {
            return Ok(from);
        }
        let mut absolute: Vec<f64> = self.equations.nominals().map(|nominal| tolerance * nominal).collect();
        if absolute.is_empty() {
            // Without any state, one that stays zero keeps the solver's step control alive.
            absolute.push(tolerance);
        }
        let mut start = vec![0.0; absolute.len()];
        self.equations.states(&mut self.model.borrow_mut(), &mut start);
        if to - from < SHORTEST.max(64.0 * f64::EPSILON * from.abs().max(to.abs())) {
            return self.shift(from, to, &start);
        }
        let mut watch = Watch { system: self, signs: Vec::new(), time: from, states: start.clone() };
        let solver =
            DOP853 { dense_output: self.equations.has_indicators(), max_steps: MOST_STEPS, ..DOP853::default() };
        let result = solver
            .solve(self, from, &start, to, tolerance.into(), absolute.into(), Some(&mut watch))
            .map_err(Failure::error)?;
        let Watch { time, states, .. } = watch;
        let time = match result.status {
            Status::UserInterrupt => time,
            // Rounding must not keep us from getting there.
            Status::Success => to,
            Status::ProbablyStiff => {
                return Err(Failure::discard(format!(
                    "the model is stiff at t = {time:?} s, and its solver is explicit"
                )));
            }
            Status::NeedLargerNMax => {
                return Err(Failure::discard(format!("the solver has done too many steps, up to t = {time:?} s")));
            }
            _ => {
                return Err(Failure::discard(format!(
                    "the solver gets no further than t = {time:?} s: derivatives are too large or not finite"
                )));
            }
        };
        self.arrive(time, &states)
    }

    /// Like [`advance`](Self::advance), over a time so short that the solver could not divide it: the states change only by
    /// rounding.
    fn shift(&self, from: f64, to: f64, start: &[f64]) -> Result<f64, Failure> {
        let mut states = vec![0.0; start.len()];
        self.derivative(from, start, &mut states);
        for (state, start) in states.iter_mut().zip(start) {
            *state = start + *state * (to - from);
        }
        self.arrive(to, &states)
    }

    /// Leaves the model with these states.
    fn arrive(&self, time: f64, states: &[f64]) -> Result<f64, Failure> {
        if self.equations.set(&mut self.model.borrow_mut(), time, states) {
            Ok(time)
        } else {
            Err(Failure::discard(format!("the model cannot have the states that it should at t = {time:?} s")))
        }
    }

    /// The sign of each event indicator; `None` if the model cannot compute them.
    fn signs(&self, time: f64, states: &[f64]) -> Option<Vec<bool>> {
        if !self.equations.has_indicators() {
            return Some(Vec::new());
        }
        let model = &mut **self.model.borrow_mut();
        if !self.equations.set(model, time, states) {
            return None;
        }
        let indicators = self.equations.indicators(model);
        indicators.iter().all(|value| value.is_finite()).then(|| indicators.iter().map(|value| *value > 0.0).collect())
    }

    /// Brings the discrete states up to date; when the next event comes for certain.
    fn update_discrete_states(&self, time: f64, step: &mut Step<'_>) -> Result<Option<f64>, Failure> {
        for _ in 0..MOST_EVENTS {
            let update = self.equations.update(&mut self.model.borrow_mut(), time, step)?;
            if update.terminate {
                return Err(Failure::discard(format!("the model has ended the simulation at t = {time:?} s")));
            }
            if !update.again {
                return Ok(update.next_time);
            }
        }
        Err(Failure::discard(format!("the discrete states do not settle at t = {time:?} s")))
    }
}

impl<M: ModelExchange> FirstOrderSystem for System<'_, M> {
    fn derivative(&self, time: f64, states: &[f64], derivatives: &mut [f64]) {
        let model = &mut **self.model.borrow_mut();
        // NaN makes the solver try a smaller step.
        let usual = if self.equations.set(model, time, states) { 0.0 } else { f64::NAN };
        derivatives.fill(usual);
        if usual == 0.0 {
            self.equations.derivatives(model, derivatives);
        }
    }
}

/// Looks for events in each step that the solver has accepted, and keeps where it is.
struct Watch<'s, 'a, M> {
    system: &'s System<'a, M>,
    /// Sides of zero of the event indicators where the step began.
    signs: Vec<bool>,
    time: f64,
    states: Vec<f64>,
}

impl<M: ModelExchange> SolOut for Watch<'_, '_, M> {
    fn solout(
        &mut self,
        begin: f64,
        end: &mut f64,
        states: &mut [f64],
        between: Option<&StepInterpolant<'_>>,
    ) -> ControlFlag {
        let at_begin = std::mem::take(&mut self.signs);
        self.time = *end;
        self.states.copy_from_slice(states);
        let Some(at_end) = self.system.signs(*end, states) else { return ControlFlag::Interrupt };
        self.signs.clone_from(&at_end);
        let Some(between) = between.filter(|_| at_begin != at_end) else { return ControlFlag::Continue };
        // Bisection, until there is no number left between the two sides of the first change.
        let (mut before, mut after) = (begin, *end);
        loop {
            let middle = before + 0.5 * (after - before);
            if middle <= before || middle >= after {
                break;
            }
            between.interpolate(middle, &mut self.states);
            match self.system.signs(middle, &self.states) {
                Some(signs) if signs == at_begin => before = middle,
                _ => after = middle,
            }
        }
        if after < *end {
            between.interpolate(after, &mut self.states);
        } else {
            self.states.copy_from_slice(states);
        }
        self.time = after;
        ControlFlag::Interrupt
    }
}
