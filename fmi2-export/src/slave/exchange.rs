//! Model exchange: what a host that integrates asks for.

use std::fmt;

use super::{Slave, all};
use crate::exchange::{Completed, EventUpdate, Moment};
use crate::exchange_phase::ExchangeCall;
use crate::layout::Continuous;
use crate::model::Failure;
use crate::out::Out;
use crate::phase::{Kind, Phase};
use crate::status::{Outcome, Refusal};

/// What bringing the discrete states up to date has led to: `fmi2EventInfo`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EventInfo {
    pub update: EventUpdate,
    /// A continuous state has another value than when the event began.
    pub states_changed: bool,
}

impl Slave {
    pub fn enter_event_mode(&mut self) -> Outcome {
        self.check_exchange(ExchangeCall::EnterEventMode)?;
        self.frame.phase = Phase::EventMode;
        self.frame.jumped = false;
        Ok(())
    }

    pub fn new_discrete_states(&mut self, warn: &mut dyn FnMut(fmt::Arguments<'_>)) -> Result<EventInfo, Refusal> {
        let continuous = self.check_exchange(ExchangeCall::NewDiscreteStates)?;
        let update = continuous.exchange.new_discrete_states;
        self.evaluate_states()?;
        let mut before = std::mem::take(&mut self.values);
        before.clear();
        before.extend(self.subject.states());
        let result = update(self.subject.model_mut(), &mut Moment::new(self.frame.time, warn));
        self.frame.stale = all();
        let result = match result {
            Ok(update) => {
                self.evaluate_states()?;
                self.after_event(update, &before)
            }
            Err(failure) => Err(failure),
        };
        self.values = before;
        let mut info = result.map_err(|failure| self.failed(&failure))?;
        // Hosts may look at the last answer of an event alone, as the standard's example does.
        info.states_changed |= self.frame.jumped;
        self.frame.jumped = info.states_changed;
        Ok(info)
    }

    pub fn enter_continuous_time_mode(&mut self) -> Outcome {
        self.check_exchange(ExchangeCall::EnterContinuousTimeMode)?;
        self.frame.phase = Phase::ContinuousTimeMode;
        self.frame.jumped = false;
        Ok(())
    }

    pub fn completed_integrator_step(
        &mut self,
        warn: &mut dyn FnMut(fmt::Arguments<'_>),
    ) -> Result<Completed, Refusal> {
        let continuous = self.check_exchange(ExchangeCall::CompletedIntegratorStep)?;
        let completed = continuous.exchange.step_completed;
        let result = completed(self.subject.model_mut(), &mut Moment::new(self.frame.time, warn));
        self.frame.stale = all();
        result.map_err(|failure| self.failed(&failure))
    }

    pub fn set_time(&mut self, time: f64) -> Outcome {
        self.check_exchange(ExchangeCall::SetTime)?;
        if !time.is_finite() {
            return Err(Refusal::error(format!("time is {time:?}, it must be finite")));
        }
        // Past the stop time, too: solvers look ahead.
        self.frame.time = time;
        self.tell_time();
        Ok(())
    }

    pub fn set_continuous_states(&mut self, values: &[f64]) -> Outcome {
        let continuous = self.check_exchange(ExchangeCall::SetContinuousStates)?;
        check_count(ExchangeCall::SetContinuousStates, "continuous states", continuous.states.len(), values.len())?;
        if let Some((slot, value)) = continuous.states.iter().zip(values).find(|(_, value)| !value.is_finite()) {
            let name = self.name(&self.layout().reals[slot.state as usize]);
            return Err(Refusal::discard(format!("the state {name} cannot be {value:?}: it must be finite")));
        }
        let states_set = continuous.exchange.states_set;
        let mut before = std::mem::take(&mut self.values);
        before.clear();
        before.extend(self.subject.states());
        self.subject.write_states(values);
        let result = states_set(self.model());
        if result.is_err() {
            self.subject.write_states(&before);
        }
        self.values = before;
        self.frame.stale = all();
        result.map_err(|failure| match failure {
            Failure::Fatal(_) => Refusal::of(&failure),
            Failure::Discard(message) | Failure::Error(message) => Refusal::discard(message),
        })
    }

    pub fn get_derivatives(&mut self, values: Out<'_, f64>) -> Outcome {
        let continuous = self.check_exchange(ExchangeCall::GetDerivatives)?;
        check_count(ExchangeCall::GetDerivatives, "continuous states", continuous.states.len(), values.len())?;
        let wanted = continuous.derivative_evaluations;
        self.evaluate(wanted)?;
        self.values.clear();
        let (layout, model) = self.subject.parts();
        self.values.extend(layout.derivatives(model));
        self.give(values, |slave, i| {
            let slot = slave.layout().continuous.as_ref()?.states.get(i)?;
            Some(slave.name(&slave.layout().reals[slot.derivative as usize]).to_owned())
        })
    }

    pub fn get_event_indicators(&mut self, values: Out<'_, f64>) -> Outcome {
        let continuous = self.check_exchange(ExchangeCall::GetEventIndicators)?;
        check_count(ExchangeCall::GetEventIndicators, "event indicators", continuous.indicator_count, values.len())?;
        let wanted = continuous.indicator_evaluations();
        self.evaluate(wanted)?;
        self.values.clear();
        let (layout, model) = self.subject.parts();
        self.values.extend_from_slice(layout.indicators(model));
        self.give(values, |_, i| Some(format!("event indicator {}", i + 1)))
    }

    pub fn get_continuous_states(&mut self, values: Out<'_, f64>) -> Outcome {
        let continuous = self.check_exchange(ExchangeCall::GetContinuousStates)?;
        check_count(ExchangeCall::GetContinuousStates, "continuous states", continuous.states.len(), values.len())?;
        self.evaluate_states()?;
        values.write(self.subject.states());
        Ok(())
    }

    pub fn get_nominals(&mut self, values: Out<'_, f64>) -> Outcome {
        let continuous = self.check_exchange(ExchangeCall::GetNominals)?;
        check_count(ExchangeCall::GetNominals, "continuous states", continuous.states.len(), values.len())?;
        values.write(self.layout().nominals());
        Ok(())
    }
}

impl Slave {
    /// Checks that the instance is one for model exchange, and that the call is allowed now.
    fn check_exchange(&self, call: ExchangeCall) -> Result<&Continuous, Refusal> {
        match &self.layout().continuous {
            Some(continuous) if self.frame.kind == Kind::ModelExchange => {
                if call.allowed_in(self.frame.phase) {
                    Ok(continuous)
                } else {
                    Err(self.out_of_order(call.name()))
                }
            }
            _ => Err(Refusal::error(format!(
                "{} is for model exchange; this instance is for {}",
                call.name(),
                self.frame.kind.name()
            ))),
        }
    }

    /// Brings the fields of the continuous states up to date.
    fn evaluate_states(&mut self) -> Outcome {
        let wanted = self.layout().continuous.as_ref().map_or(0, |continuous| continuous.state_evaluations);
        self.evaluate(wanted)
    }

    /// What the host is told after an event, if it can go on from there: no solver begins at NaN.
    fn after_event(&mut self, mut update: EventUpdate, before: &[f64]) -> Result<EventInfo, Failure> {
        let states_changed = !self.subject.states().map(f64::to_bits).eq(before.iter().map(|value| value.to_bits()));
        let broken = self.subject.states().enumerate().find(|(_, value)| !value.is_finite());
        if let Some((i, value)) = broken {
            let slot = self.layout().continuous.as_ref().and_then(|continuous| continuous.states.get(i));
            let name = slot.map_or("a state", |slot| self.name(&self.layout().reals[slot.state as usize]));
            return Err(Failure::error(format_args!(
                "{name} is {value:?} after an event at t = {:?} s",
                self.frame.time
            )));
        }
        match update.next_time {
            Some(time) if time.is_nan() => {
                return Err(Failure::error("the model says that its next event comes at t = NaN"));
            }
            // Never, that is.
            Some(f64::INFINITY) => update.next_time = None,
            _ => {}
        }
        Ok(EventInfo { update, states_changed })
    }

    /// What a host hears when the model cannot go on: the instance is at its end.
    fn failed(&mut self, failure: &Failure) -> Refusal {
        self.frame.phase = Phase::Error;
        Refusal::of(failure)
    }

    /// Gives the host the numbers in `self.values`, if the model could compute them.
    fn give(&self, values: Out<'_, f64>, name: impl Fn(&Self, usize) -> Option<String>) -> Outcome {
        let works = self.frame.phase.is_running();
        if works && let Some(i) = self.values.iter().position(|value| !value.is_finite()) {
            let (name, value) = (name(self, i).unwrap_or_default(), self.values[i]);
            return Err(Refusal::discard(format!(
                "{name} is {value:?} at t = {:?} s: a smaller step of the solver may help",
                self.frame.time
            )));
        }
        values.write(self.values.iter().copied());
        Ok(())
    }
}

/// Checks how many numbers the host has or expects.
fn check_count(call: ExchangeCall, what: &str, expected: usize, found: usize) -> Outcome {
    if expected == found {
        return Ok(());
    }
    Err(Refusal::error(format!("{}: the model has {expected} {what}, not {found}", call.name())))
}
