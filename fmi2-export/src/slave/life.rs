//! From instantiation to termination.

use std::fmt;

use super::{Frame, Slave, all};
use crate::any_model::AnyModel;
use crate::model::{Conclusion, Experiment, Failure};
use crate::phase::{Call, Kind, Phase};
use crate::status::{Outcome, Refusal};

impl Slave {
    pub fn kind(&self) -> Kind {
        self.frame.kind
    }

    pub fn phase(&self) -> Phase {
        self.frame.phase
    }

    /// Makes it ready for the short way of the calls of a step, if it can take it: if it is between steps, and no input is a ramp.
    pub fn is_ready(&mut self) -> bool {
        self.end = self.frame.experiment.and_then(|experiment| experiment.stop_time).unwrap_or(f64::MAX).min(f64::MAX);
        self.frame.phase == Phase::StepComplete && !self.frame.ramped
    }

    /// After a panic: nothing but reset, restore and free is possible.
    pub fn poison(&mut self) {
        self.frame.phase = Phase::Error;
    }

    pub fn setup_experiment(&mut self, experiment: Experiment) -> Outcome {
        self.check(Call::SetupExperiment, "fmi2SetupExperiment")?;
        check_experiment(&experiment).map_err(Refusal::error)?;
        self.frame.experiment = Some(experiment);
        self.frame.time = experiment.start_time;
        self.tell_time();
        Ok(())
    }

    pub fn enter_initialization(&mut self) -> Outcome {
        self.check(Call::EnterInitializationMode, "fmi2EnterInitializationMode")?;
        if self.frame.experiment.is_none() {
            return Err(Refusal::error("fmi2SetupExperiment must be called before fmi2EnterInitializationMode"));
        }
        self.initialize()?;
        self.frame.phase = Phase::Initialization;
        Ok(())
    }

    pub fn exit_initialization(&mut self) -> Outcome {
        self.check(Call::ExitInitializationMode, "fmi2ExitInitializationMode")?;
        if self.frame.uninitialized {
            self.initialize()?;
        }
        self.frame.phase = self.frame.kind.initialized();
        Ok(())
    }

    /// Ends the run. What the model says of it goes to `warn`.
    pub fn terminate(&mut self, warn: &mut dyn FnMut(fmt::Arguments<'_>)) -> Outcome {
        self.check(Call::Terminate, "fmi2Terminate")?;
        let mut conclusion = Conclusion { time: self.frame.time, warn };
        self.model().conclude(&mut conclusion);
        self.frame.phase = Phase::Terminated;
        Ok(())
    }

    pub fn reset(&mut self) -> Outcome {
        self.strings.clear();
        // A failed model may have left anything there, and in itself.
        self.direction = None;
        let inherits = self.frame.phase != Phase::Error;
        let renewed = self.subject.model_mut().renew(&self.resources, inherits);
        renewed.map_err(|failure| Refusal::of(&failure))?;
        self.frame = Frame::new(self.frame.kind);
        Ok(())
    }
}

impl Slave {
    pub(super) fn initialize(&mut self) -> Outcome {
        let experiment = self.frame.experiment.unwrap_or_default();
        let before = self.model().copy();
        let initialize = self.initializer();
        let model = self.model();
        if let Err(failure) = initialize(model, &experiment) {
            model.assign(&*before);
            return Err(Refusal::of(&failure));
        }
        self.frame.uninitialized = false;
        self.frame.stale = all();
        Ok(())
    }

    /// The function that computes the initial state: a model may offer less where the host integrates.
    pub(super) fn initializer(&self) -> fn(&mut dyn AnyModel, &Experiment) -> Result<(), Failure> {
        match (&self.layout().continuous, self.frame.kind) {
            (Some(continuous), Kind::ModelExchange) => continuous.exchange.initialize,
            _ => |model, experiment| model.initialize(experiment),
        }
    }
}

pub(super) fn check_experiment(experiment: &Experiment) -> Result<(), String> {
    let start = experiment.start_time;
    if !start.is_finite() {
        return Err(format!("startTime is {start:?}, it must be finite"));
    }
    if let Some(stop) = experiment.stop_time
        && (stop.is_nan() || stop < start)
    {
        return Err(format!("stopTime {stop:?} is before startTime {start:?}"));
    }
    if let Some(tolerance) = experiment.tolerance
        && !(tolerance.is_finite() && tolerance > 0.0)
    {
        return Err(format!("tolerance is {tolerance:?}, it must be positive and finite"));
    }
    Ok(())
}
