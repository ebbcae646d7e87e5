//! Saved states.

use std::any::Any;
use std::sync::Arc;

use super::life::check_experiment;
use super::set::accept_integer;
use super::{Slave, State, out_of_range};
use crate::access::Access;
use crate::model::{Failure, Model};
use crate::phase::Phase;
use crate::snapshot::{self, SnapshotError};
use crate::status::{Outcome, Refusal};

/// A state, whatever its model.
pub(crate) type Snapshot = Arc<dyn Any + Send + Sync>;

pub(crate) trait Remember {
    fn save(&self) -> Snapshot;
    fn restore(&mut self, snapshot: &Snapshot) -> Outcome;
    fn encode(&self, snapshot: &Snapshot) -> Result<Vec<u8>, Refusal>;
    /// How many bytes [`encode`](Self::encode) gives.
    fn encoded_size(&self, snapshot: &Snapshot) -> Result<usize, Refusal>;
    fn decode(&self, bytes: &[u8]) -> Result<Snapshot, Refusal>;
}

impl From<SnapshotError> for Refusal {
    fn from(error: SnapshotError) -> Self {
        Self::error(error.to_string())
    }
}

impl<M: Model> Remember for Slave<M> {
    fn save(&self) -> Snapshot {
        Arc::new(self.state.clone())
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Outcome {
        let saved = Self::own(snapshot)?;
        self.check_kind(saved)?;
        self.state = saved.clone();
        self.strings.clear();
        Ok(())
    }

    fn encode(&self, snapshot: &Snapshot) -> Result<Vec<u8>, Refusal> {
        Ok(snapshot::encode(self.guid, Self::own(snapshot)?)?)
    }

    fn encoded_size(&self, snapshot: &Snapshot) -> Result<usize, Refusal> {
        Ok(snapshot::encoded_size(Self::own(snapshot)?)?)
    }

    fn decode(&self, bytes: &[u8]) -> Result<Snapshot, Refusal> {
        let mut state: State<M> = snapshot::decode(self.guid, bytes)?;
        self.check_kind(&state)?;
        self.check_decoded(&mut state).map_err(SnapshotError::Content)?;
        let content = |failure: Failure| SnapshotError::Content(failure.to_string());
        state.model.resources(&self.resources).map_err(content)?;
        state.model.restored().map_err(content)?;
        Ok(Arc::new(state))
    }
}

impl<M: Model> Slave<M> {
    /// Checks that a state is of an instance that was made for the same as this one: what the host may do with it differs.
    fn check_kind(&self, state: &State<M>) -> Outcome {
        if state.kind == self.state.kind {
            return Ok(());
        }
        let (its, own) = (state.kind.name(), self.state.kind.name());
        Err(Refusal::error(format!("this FMU state is of an instance for {its}, this instance is for {own}")))
    }

    /// Checks what a host could not have brought about: a checksum is no proof of where bytes come from. The state of the
    /// model itself is the model's to check, in `restored`.
    fn check_decoded(&self, state: &mut State<M>) -> Result<(), String> {
        if !state.time.is_finite() {
            return Err("its time is not finite".into());
        }
        if !state.phase.is_of(state.kind) {
            return Err(format!("an instance for {} is never {}", state.kind.name(), state.phase.name()));
        }
        match &state.experiment {
            Some(experiment) => check_experiment(experiment)?,
            None if matches!(state.phase, Phase::Instantiated | Phase::Error) => {}
            None => return Err("it has been initialized without an experiment".into()),
        }
        for real in &self.layout.reals {
            let value = *(real.lens)(&mut state.model);
            if real.slot.settable != 0 && !real.accepts(value) {
                return Err(out_of_range(self.name(&real.slot), value, real.min, real.max).message);
            }
            if let Some(ramp) = &real.ramp {
                let slope = *ramp(&mut state.model);
                if !slope.is_finite() {
                    return Err(format!("the slope of {} is {slope:?}", self.name(&real.slot)));
                }
                state.ramped |= slope != 0.0;
            }
        }
        for slot in self.layout.integers.iter().filter(|slot| slot.settable != 0) {
            let variable = &self.layout.variables[slot.variable as usize];
            if let Access::Integer { get, .. } = &variable.access {
                get(&mut state.model)
                    .and_then(|value| accept_integer(variable, value))
                    .map_err(|why| format!("{}: {why}", variable.name))?;
            }
        }
        Ok(())
    }

    fn own(snapshot: &Snapshot) -> Result<&State<M>, Refusal> {
        snapshot.downcast_ref().ok_or_else(|| Refusal::error("this FMU state belongs to another model"))
    }
}
