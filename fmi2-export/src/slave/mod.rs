//! An instance of a model: its variables, its place in the calling sequence, its clock. What a call demands and does is in
//! the module of its kind; here is what they share.

mod derivatives;
mod exchange;
mod get;
mod initial;
mod life;
mod set;
mod states;
mod step;

use std::ffi::CString;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub(crate) use derivatives::Derive;
pub(crate) use exchange::BeIntegrated;
pub(crate) use get::Get;
pub(crate) use life::Live;
pub(crate) use set::Set;
pub(crate) use states::{Remember, Snapshot};
pub(crate) use step::Advance;

use crate::layout::{Layout, RealSlot, Slot};
use crate::model::{Experiment, Model};
use crate::phase::{Call, Kind, Phase};
use crate::resources::Resources;
use crate::status::Refusal;

/// An instance, whatever its model: the C interface calls these.
pub(crate) trait AnySlave: Live + Get + Set + Derive + Advance + BeIntegrated + Remember + Send {}

impl<M: Model> AnySlave for Slave<M> {}

/// All that a saved state holds.
#[derive(Clone, Serialize, Deserialize)]
#[serde(bound = "")]
struct State<M: Model> {
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
    model: M,
}

/// Every evaluation.
fn all() -> u64 {
    u64::MAX
}

impl<M: Model> State<M> {
    /// The model has been told where its files are.
    fn new(kind: Kind, resources: &Resources) -> Result<Self, Refusal> {
        let mut model = M::default();
        model.resources(resources).map_err(|failure| Refusal::of(&failure))?;
        Ok(Self {
            kind,
            phase: Phase::Instantiated,
            experiment: None,
            time: 0.0,
            stale: all(),
            uninitialized: true,
            ramped: false,
            model,
        })
    }
}

pub(crate) struct Slave<M: Model> {
    layout: Arc<Layout<M>>,
    guid: &'static str,
    resources: Resources,
    state: State<M>,
    /// Scratch for directional derivatives: a model all of whose real inputs and outputs are zero.
    direction: Option<Box<M>>,
    /// What the last `fmi2GetString` returned.
    strings: Vec<CString>,
    /// Scratch for values that are checked before the host gets them.
    values: Vec<f64>,
}

impl<M: Model> Slave<M> {
    pub fn new(layout: Arc<Layout<M>>, guid: &'static str, kind: Kind, resources: Resources) -> Result<Self, Refusal> {
        if kind == Kind::ModelExchange && layout.continuous.is_none() {
            return Err(Refusal::error(format!("this FMU is for {} only", Kind::CoSimulation.name())));
        }
        let state = State::new(kind, &resources)?;
        Ok(Self { layout, guid, resources, state, direction: None, strings: Vec::new(), values: Vec::new() })
    }

    /// Name of a variable, for messages.
    fn name(&self, slot: &Slot) -> &str {
        &self.layout.variables[slot.variable as usize].name
    }

    fn real(&self, reference: u32) -> Result<&RealSlot<M>, Refusal> {
        self.layout.reals.get(reference as usize).ok_or_else(|| no_such(reference))
    }

    fn check(&self, call: Call, what: &str) -> Result<(), Refusal> {
        if self.state.phase.allows(call) { Ok(()) } else { Err(self.out_of_order(what)) }
    }

    /// As [`check`](Self::check), of a call that only co-simulation has.
    fn check_co_simulation(&self, call: Call, what: &str) -> Result<(), Refusal> {
        if self.state.kind == Kind::CoSimulation {
            self.check(call, what)
        } else {
            Err(Refusal::error(format!("{what} is for co-simulation; this instance is for {}", self.state.kind.name())))
        }
    }

    /// Tells the model the time, if it wants to know it.
    fn tell_time(&mut self) {
        if self.layout.tell_time(&mut self.state.model, self.state.time) {
            self.state.stale = all();
        }
    }

    #[cold]
    fn out_of_order(&self, what: &str) -> Refusal {
        let hint = match self.state.phase {
            Phase::Error | Phase::StepFailed => "; fmi2SetFMUstate or fmi2Reset lead on",
            Phase::Terminated => "; fmi2Reset starts anew",
            _ => "",
        };
        Refusal::error(format!("{what} is not allowed {}{hint}", self.state.phase.name()))
    }

    /// Brings the results of these evaluations up to date.
    fn evaluate(&mut self, wanted: u64) -> Result<(), Refusal> {
        if self.state.phase == Phase::Error {
            // What there is may be looked at, but a failed model is not asked to compute.
            return Ok(());
        }
        if self.state.phase == Phase::Initialization && self.state.uninitialized {
            self.initialize()?;
        }
        let todo = wanted & self.state.stale;
        self.state.stale &= !todo;
        self.layout.evaluate(todo, &mut self.state.model);
        Ok(())
    }
}

fn find(slots: &[Slot], reference: u32) -> Result<&Slot, Refusal> {
    slots.get(reference as usize).ok_or_else(|| no_such(reference))
}

#[cold]
fn no_such(reference: u32) -> Refusal {
    Refusal::error(format!("there is no variable of this type with value reference {reference}"))
}

#[cold]
fn out_of_range(name: &str, value: f64, min: f64, max: f64) -> Refusal {
    let range = match (min > f64::MIN, max < f64::MAX) {
        (true, true) => format!("it must be between {min:?} and {max:?}"),
        (true, false) => format!("it must be finite and at least {min:?}"),
        (false, true) => format!("it must be finite and at most {max:?}"),
        (false, false) => "it must be finite".into(),
    };
    Refusal::error(format!("{name} cannot be {value:?}: {range}"))
}
