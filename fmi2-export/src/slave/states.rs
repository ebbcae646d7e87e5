//! Saved states.

use std::any::Any;
use std::sync::Arc;

use super::life::check_experiment;
use super::set::accept_integer;
use super::subject::Subject;
use super::{Frame, Slave, out_of_range};
use crate::any_model::AnyModel;
use crate::model::Failure;
use crate::phase::Phase;
use crate::snapshot::{self, Sink, SnapshotError};
use crate::status::{Outcome, Refusal};
use crate::view::Value;

/// All that a saved state holds.
pub(crate) struct Saved {
    frame: Frame,
    model: Box<dyn AnyModel>,
}

/// A saved state.
pub(crate) type Snapshot = Arc<Saved>;

impl From<SnapshotError> for Refusal {
    fn from(error: SnapshotError) -> Self {
        Self::error(error.to_string())
    }
}

impl Slave {
    pub fn save(&self) -> Snapshot {
        Arc::new(Saved { frame: self.frame, model: self.subject.model().copy() })
    }

    /// Saves into a state that nobody needs any more; false if somebody does, or it is of another model.
    pub fn save_in(&self, snapshot: &mut Snapshot) -> bool {
        let Some(saved) = Arc::get_mut(snapshot) else { return false };
        saved.frame = self.frame;
        saved.model.assign(self.subject.model())
    }

    pub fn restore(&mut self, snapshot: &Snapshot) -> Outcome {
        self.check_own(snapshot)?;
        self.check_kind(&snapshot.frame)?;
        self.model().assign(&*snapshot.model);
        self.frame = snapshot.frame;
        self.strings.clear();
        Ok(())
    }

    pub fn encode(&self, snapshot: &Snapshot) -> Result<Vec<u8>, Refusal> {
        self.check_own(snapshot)?;
        Ok(snapshot::encode(self.guid, &|sink| snapshot.write(sink))?)
    }

    /// How many bytes [`encode`](Self::encode) gives.
    pub fn encoded_size(&self, snapshot: &Snapshot) -> Result<usize, Refusal> {
        self.check_own(snapshot)?;
        Ok(snapshot::encoded_size(&|sink| snapshot.write(sink))?)
    }

    pub fn decode(&self, bytes: &[u8]) -> Result<Snapshot, Refusal> {
        let payload = snapshot::payload(self.guid, bytes)?;
        let (mut frame, rest): (Frame, _) = snapshot::part(payload)?;
        let own = self.subject.model();
        let (model, rest) = own.decode(rest).map_err(|error| SnapshotError::Content(error.to_string()))?;
        snapshot::finish(rest)?;
        self.check_kind(&frame)?;
        let mut subject = self.subject.with(model);
        check_decoded(&mut frame, &mut subject).map_err(SnapshotError::Content)?;
        let content = |failure: Failure| SnapshotError::Content(failure.to_string());
        let mut model = subject.into_model();
        model.resources(&self.resources).map_err(content)?;
        model.restored().map_err(content)?;
        Ok(Arc::new(Saved { frame, model }))
    }

    /// Checks that a state is of an instance that was made for the same as this one: what the host may do with it differs.
    fn check_kind(&self, frame: &Frame) -> Outcome {
        if frame.kind == self.frame.kind {
            return Ok(());
        }
        let (its, own) = (frame.kind.name(), self.frame.kind.name());
        Err(Refusal::error(format!("this FMU state is of an instance for {its}, this instance is for {own}")))
    }

    fn check_own(&self, snapshot: &Snapshot) -> Outcome {
        let model: &dyn Any = &*snapshot.model;
        if self.layout().is_of(model.type_id()) {
            Ok(())
        } else {
            Err(Refusal::error("this FMU state belongs to another model"))
        }
    }
}

impl Saved {
    fn write(&self, sink: &mut Sink<'_>) -> postcard::Result<()> {
        sink.put(&self.frame)?;
        self.model.encode(sink)
    }
}

/// Checks what a host could not have brought about: a checksum is no proof of where bytes come from. The state of the
/// model itself is the model's to check, in `restored`.
fn check_decoded(frame: &mut Frame, subject: &mut Subject) -> Result<(), String> {
    if !frame.time.is_finite() {
        return Err("its time is not finite".into());
    }
    if !frame.phase.is_of(frame.kind) {
        return Err(format!("an instance for {} is never {}", frame.kind.name(), frame.phase.name()));
    }
    match &frame.experiment {
        Some(experiment) => check_experiment(experiment)?,
        None if matches!(frame.phase, Phase::Instantiated | Phase::Error) => {}
        None => return Err("it has been initialized without an experiment".into()),
    }
    let (layout, mut view) = subject.view();
    for (reference, real) in (0..).zip(&layout.reals) {
        let value = view.real(reference);
        if real.settable != 0 && !real.accepts(value) {
            return Err(out_of_range(layout.name(real.variable), value, real.min, real.max).into_message());
        }
        if let Some(slope) = view.ramp(reference) {
            if !slope.is_finite() {
                return Err(format!("the slope of {} is {slope:?}", layout.name(real.variable)));
            }
            frame.ramped |= *slope != 0.0;
        }
    }
    for slot in layout.integers.iter().filter(|slot| slot.settable != 0) {
        let variable = &layout.variables[slot.variable as usize];
        if let Value::Integer(value) = view.value(slot.variable as usize) {
            value
                .and_then(|value| accept_integer(variable, value))
                .map_err(|why| format!("{}: {why}", variable.name))?;
        }
    }
    Ok(())
}
