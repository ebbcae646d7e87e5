//! An instance of a model: its variables, its place in the calling sequence, its clock. What a call demands and does is in
//! the module of its kind; here is what they share.
//!
//! None of this knows the model's type: it is compiled once for all models of a library.

mod derivatives;
mod exchange;
mod get;
mod initial;
mod life;
mod set;
mod states;
mod step;
mod subject;

use std::ffi::CString;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub(crate) use states::Snapshot;
use subject::Subject;

use crate::any_model::AnyModel;
use crate::layout::{Layout, RealSlot, Slot};
use crate::model::Experiment;
use crate::phase::{Call, Kind, Phase};
use crate::resources::Resources;
use crate::status::Refusal;

/// What a saved state holds besides the model.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Frame {
    kind: Kind,
    phase: Phase,
    /// As `fmi2SetupExperiment` gave it, once it has.
    experiment: Option<Experiment>,
    time: f64,
    /// Evaluations whose results are out of date, a bit each: all of them in a state that was read from bytes, since a
    /// model need not serialise what it can compute.
    #[serde(skip, default = "all")]
    stale: u64,
    /// In initialization mode: a parameter or an input has changed since the last `initialize`.
    uninitialized: bool,
    /// An input has a slope for the next step.
    ramped: bool,
    /// In event mode: continuous states have jumped in this event. Bytes do not hold it; the host that reads them reads the states, too.
    #[serde(skip)]
    jumped: bool,
}

/// Every evaluation.
fn all() -> u64 {
    u64::MAX
}

impl Frame {
    const fn new(kind: Kind) -> Self {
        Self {
            kind,
            phase: Phase::Instantiated,
            experiment: None,
            time: 0.0,
            stale: u64::MAX,
            uninitialized: true,
            ramped: false,
            jumped: false,
        }
    }
}

#[repr(C)] // First what every call needs: of a thousand instances each has been pushed out of the processor's cache.
pub(crate) struct Slave {
    subject: Subject,
    frame: Frame,
    /// No step of an instance that is [ready](Self::is_ready) may end later (s): the stop time, if there is one.
    end: f64,
    guid: &'static str,
    resources: Resources,
    /// Scratch for directional derivatives: a model all of whose real inputs and outputs are zero.
    direction: Option<Box<dyn AnyModel>>,
    /// The state that was freed last, for its memory: hosts that try steps save one before each.
    pub spare: Option<Snapshot>,
    /// What the last `fmi2GetString` returned.
    strings: Vec<CString>,
    /// Scratch for values that are checked before the host gets them.
    values: Vec<f64>,
}

impl Slave {
    /// An instance of a model with its default values.
    pub fn new(
        layout: Arc<Layout>,
        mut model: Box<dyn AnyModel>,
        guid: &'static str,
        kind: Kind,
        resources: Resources,
    ) -> Result<Self, Refusal> {
        if kind == Kind::ModelExchange && layout.continuous.is_none() {
            return Err(Refusal::error(format!("this FMU is for {} only", Kind::CoSimulation.name())));
        }
        model.resources(&resources).map_err(|failure| Refusal::of(&failure))?;
        Ok(Self {
            guid,
            resources,
            subject: Subject::new(layout, model),
            frame: Frame::new(kind),
            end: f64::MAX,
            direction: None,
            spare: None,
            strings: Vec::new(),
            values: Vec::new(),
        })
    }

    fn layout(&self) -> &Layout {
        self.subject.layout()
    }

    fn model(&mut self) -> &mut dyn AnyModel {
        self.subject.model_mut()
    }

    fn real(&self, reference: u32) -> Result<&RealSlot, Refusal> {
        self.layout().reals.get(reference as usize).ok_or_else(|| no_such(reference))
    }

    /// Name of a real variable, for messages.
    fn name(&self, slot: &RealSlot) -> &str {
        self.layout().name(slot.variable)
    }

    #[inline]
    fn check(&self, call: Call, what: &str) -> Result<(), Refusal> {
        if self.frame.phase.allows(call) { Ok(()) } else { Err(self.out_of_order(what)) }
    }

    /// As [`check`](Self::check), of a call that only co-simulation has.
    fn check_co_simulation(&self, call: Call, what: &str) -> Result<(), Refusal> {
        if self.frame.kind == Kind::CoSimulation {
            self.check(call, what)
        } else {
            Err(Refusal::error(format!("{what} is for co-simulation; this instance is for {}", self.frame.kind.name())))
        }
    }

    /// Tells the model the time, if it wants to know it.
    fn tell_time(&mut self) {
        let (layout, model) = self.subject.parts();
        if layout.tell_time(model, self.frame.time) {
            self.frame.stale = all();
        }
    }

    #[cold]
    #[inline(never)]
    fn out_of_order(&self, what: &str) -> Refusal {
        let hint = match self.frame.phase {
            Phase::Error | Phase::StepFailed => "; fmi2SetFMUstate or fmi2Reset lead on",
            Phase::Terminated => "; fmi2Reset starts anew",
            _ => "",
        };
        Refusal::error(format!("{what} is not allowed {}{hint}", self.frame.phase.name()))
    }

    /// Brings the results of these evaluations up to date.
    #[inline]
    fn evaluate(&mut self, wanted: u64) -> Result<(), Refusal> {
        if wanted & self.frame.stale == 0 && !self.frame.uninitialized {
            return Ok(());
        }
        self.evaluate_stale(wanted)
    }

    fn evaluate_stale(&mut self, wanted: u64) -> Result<(), Refusal> {
        if self.frame.phase == Phase::Error {
            // What there is may be looked at, but a failed model is not asked to compute.
            return Ok(());
        }
        if self.frame.phase == Phase::Initialization && self.frame.uninitialized {
            self.initialize()?;
        }
        let todo = wanted & self.frame.stale;
        self.frame.stale &= !todo;
        self.subject.view().1.evaluate(todo);
        Ok(())
    }
}

fn find(slots: &[Slot], reference: u32) -> Result<&Slot, Refusal> {
    slots.get(reference as usize).ok_or_else(|| no_such(reference))
}

#[cold]
#[inline(never)]
fn no_such(reference: u32) -> Refusal {
    Refusal::error(format!("there is no variable of this type with value reference {reference}"))
}

#[cold]
#[inline(never)]
fn out_of_range(name: &str, value: f64, min: f64, max: f64) -> Refusal {
    let range = match (min > f64::MIN, max < f64::MAX) {
        (true, true) => format!("it must be between {min:?} and {max:?}"),
        (true, false) => format!("it must be finite and at least {min:?}"),
        (false, true) => format!("it must be finite and at most {max:?}"),
        (false, false) => "it must be finite".into(),
    };
    Refusal::error(format!("{name} cannot be {value:?}: {range}"))
}
