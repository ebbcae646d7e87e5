//! From instantiation to termination.

use std::fmt;

use super::{Slave, State, all};
use crate::model::{Conclusion, Experiment, Failure, Model};
use crate::phase::{Call, Kind, Phase};
use crate::status::{Outcome, Refusal};

pub(crate) trait Live {
    fn kind(&self) -> Kind;
    fn phase(&self) -> Phase;
    /// After a panic: nothing but reset, restore and free is possible.
    fn poison(&mut self);
    fn setup_experiment(&mut self, experiment: Experiment) -> Outcome;
    fn enter_initialization(&mut self) -> Outcome;
    fn exit_initialization(&mut self) -> Outcome;
    /// Ends the run. What the model says of it goes to `warn`.
    fn terminate(&mut self, warn: &mut dyn FnMut(fmt::Arguments<'_>)) -> Outcome;
    fn reset(&mut self) -> Outcome;
}

impl<M: Model> Live for Slave<M> {
    fn kind(&self) -> Kind {
        self.state.kind
    }

    fn phase(&self) -> Phase {
        self.state.phase
    }

    fn poison(&mut self) {
        self.state.phase = Phase::Error;
    }

    fn setup_experiment(&mut self, experiment: Experiment) -> Outcome {
        self.check(Call::SetupExperiment, "fmi2SetupExperiment")?;
        check_experiment(&experiment).map_err(Refusal::error)?;
        self.state.experiment = Some(experiment);
        self.state.time = experiment.start_time;
        self.tell_time();
        Ok(())
    }

    fn enter_initialization(&mut self) -> Outcome {
        self.check(Call::EnterInitializationMode, "fmi2EnterInitializationMode")?;
        if self.state.experiment.is_none() {
            return Err(Refusal::error("fmi2SetupExperiment must be called before fmi2EnterInitializationMode"));
        }
        self.initialize()?;
        self.state.phase = Phase::Initialization;
        Ok(())
    }

    fn exit_initialization(&mut self) -> Outcome {
        self.check(Call::ExitInitializationMode, "fmi2ExitInitializationMode")?;
        if self.state.uninitialized {
            self.initialize()?;
        }
        self.state.phase = self.state.kind.initialized();
        Ok(())
    }

    fn terminate(&mut self, warn: &mut dyn FnMut(fmt::Arguments<'_>)) -> Outcome {
        self.check(Call::Terminate, "fmi2Terminate")?;
        self.state.model.conclude(&mut Conclusion { time: self.state.time, warn });
        self.state.phase = Phase::Terminated;
        Ok(())
    }

    fn reset(&mut self) -> Outcome {
        let fresh = State::new(self.state.kind, &self.resources)?;
        let old = std::mem::replace(&mut self.state, fresh);
        // A failed model may have left anything there.
        self.direction = None;
        self.strings.clear();
        if old.phase != Phase::Error {
            self.state.model.inherit(old.model);
        }
        Ok(())
    }
}

impl<M: Model> Slave<M> {
    pub(super) fn initialize(&mut self) -> Outcome {
        let experiment = self.state.experiment.unwrap_or_default();
        let before = self.state.model.clone();
        let initialize = self.initializer();
        if let Err(failure) = initialize(&mut self.state.model, &experiment) {
            self.state.model = before;
            return Err(Refusal::of(&failure));
        }
        self.state.uninitialized = false;
        self.state.stale = all();
        Ok(())
    }

    /// The function that computes the initial state: a model may offer less where the host integrates.
    pub(super) fn initializer(&self) -> fn(&mut M, &Experiment) -> Result<(), Failure> {
        match (&self.layout.continuous, self.state.kind) {
            (Some(continuous), Kind::ModelExchange) => continuous.exchange.initialize,
            _ => M::initialize,
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
