//! An instance of a model: its variables, its place in the calling sequence, its clock.

use std::any::Any;
use std::ffi::CString;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::access::Access;
use crate::ffi::types::Status;
use crate::layout::{Layout, RealSlot, Slot};
use crate::logger::{Category, Logger};
use crate::phase::{Call, Phase};
use crate::snapshot::{self, SnapshotError};
use crate::variable::{Causality, Variable};
use crate::{Experiment, Failure, Model, Step};

/// Why a call was not carried out. Unless it says otherwise, the instance is as it was before the call.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub status: Status,
    pub message: String,
}

impl Refusal {
    pub fn error(message: impl Into<String>) -> Self {
        Self { status: Status::Error, message: message.into() }
    }

    fn discard(message: impl Into<String>) -> Self {
        Self { status: Status::Discard, message: message.into() }
    }

    pub fn category(&self) -> Category {
        if self.status == Status::Discard { Category::Discard } else { Category::Error }
    }
}

impl From<SnapshotError> for Refusal {
    fn from(error: SnapshotError) -> Self {
        Self::error(error.to_string())
    }
}

pub(crate) type Outcome = Result<Status, Refusal>;
pub(crate) type Snapshot = Arc<dyn Any + Send + Sync>;

/// An instance, whatever its model: the C interface calls these.
pub(crate) trait AnySlave: Send {
    fn phase(&self) -> Phase;
    /// After a panic: nothing but reset, restore and free is possible.
    fn poison(&mut self);
    fn setup_experiment(&mut self, experiment: Experiment) -> Outcome;
    fn enter_initialization(&mut self) -> Outcome;
    fn exit_initialization(&mut self) -> Outcome;
    fn terminate(&mut self) -> Outcome;
    fn reset(&mut self) -> Outcome;
    fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Outcome;
    fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Outcome;
    fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Outcome;
    /// The strings stay valid until the next call.
    fn get_string(&mut self, references: &[u32]) -> Result<&[CString], Refusal>;
    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Outcome;
    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Outcome;
    fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Outcome;
    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Outcome;
    fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome;
    fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Outcome;
    fn directional_derivative(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64], values: &mut [f64])
    -> Outcome;
    fn do_step(&mut self, time: f64, size: f64, logger: &Logger) -> Outcome;
    fn last_successful_time(&self) -> f64;
    fn save(&self) -> Snapshot;
    fn restore(&mut self, snapshot: &Snapshot) -> Outcome;
    fn encode(&self, snapshot: &Snapshot) -> Result<Vec<u8>, Refusal>;
    fn decode(&self, bytes: &[u8]) -> Result<Snapshot, Refusal>;
}

/// All that a saved state holds.
#[derive(Clone, Serialize, Deserialize)]
#[serde(bound = "")]
struct State<M: Model> {
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
    fn new() -> Self {
        Self {
            phase: Phase::Instantiated,
            experiment: None,
            time: 0.0,
            stale: all(),
            uninitialized: true,
            ramped: false,
            model: M::default(),
        }
    }
}

pub(crate) struct Slave<M: Model> {
    layout: Arc<Layout<M>>,
    guid: &'static str,
    state: State<M>,
    /// Scratch for directional derivatives: a model all of whose real inputs and outputs are zero.
    direction: Option<Box<M>>,
    /// What the last `fmi2GetString` returned.
    strings: Vec<CString>,
}

impl<M: Model> Slave<M> {
    pub fn new(layout: Arc<Layout<M>>, guid: &'static str) -> Self {
        Self { layout, guid, state: State::new(), direction: None, strings: Vec::new() }
    }

    /// Name of a variable, for messages.
    fn name(&self, slot: &Slot) -> &str {
        &self.layout.variables[slot.variable as usize].name
    }

    fn check(&self, call: Call, what: &str) -> Result<(), Refusal> {
        if self.state.phase.allows(call) { Ok(()) } else { Err(self.out_of_order(what)) }
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
        let mut todo = wanted & self.state.stale;
        self.state.stale &= !todo;
        while todo != 0 {
            let index = todo.trailing_zeros() as usize;
            if let Some(evaluation) = self.layout.evaluations.get(index) {
                evaluation(&mut self.state.model);
            }
            todo &= todo - 1;
        }
        Ok(())
    }

    fn initialize(&mut self) -> Result<(), Refusal> {
        let experiment = self.state.experiment.unwrap_or_default();
        let before = self.state.model.clone();
        if let Err(failure) = self.state.model.initialize(&experiment) {
            self.state.model = before;
            return Err(Refusal::error(failure.to_string()));
        }
        self.state.uninitialized = false;
        self.state.stale = all();
        Ok(())
    }

    /// Checks that the host may set this variable now.
    fn check_settable(&self, slot: &Slot) -> Result<(), Refusal> {
        if slot.settable & self.state.phase.settable_bit() == 0 { Err(self.not_settable(slot)) } else { Ok(()) }
    }

    #[cold]
    fn not_settable(&self, slot: &Slot) -> Refusal {
        let what = match slot.causality {
            Causality::Output | Causality::Local => "it is computed by the model",
            Causality::Input => "inputs can be set before and between steps",
            Causality::Parameter => "it is fixed once initialization mode has been left",
        };
        Refusal::error(format!("{} cannot be set {}: {what}", self.name(slot), self.state.phase.name()))
    }

    /// What to go back to if the model does not accept new values of tunable parameters. Not on the way of a step, where
    /// only inputs are set; boxed, so that nothing is moved about there.
    fn before_tuning(&self, changed: Changed) -> Option<Box<M>> {
        (changed.parameters() && self.state.phase == Phase::StepComplete).then(|| Box::new(self.state.model.clone()))
    }

    /// Concludes setting variables that have all been checked: inputs make the outputs stale that depend on them;
    /// parameters make the model initialize again, or retune.
    fn after_set(&mut self, changed: Changed, old: Option<Box<M>>) -> Outcome {
        if self.state.phase != Phase::StepComplete {
            // The initial state may depend on both.
            self.state.uninitialized |= changed.inputs() | changed.parameters();
            return Ok(Status::Ok);
        }
        if changed.parameters() {
            if let Err(failure) = self.state.model.retuned() {
                if let Some(old) = old {
                    self.state.model = *old;
                }
                let undone = self.state.model.retuned();
                return Err(Refusal::error(undone.err().unwrap_or(failure).to_string()));
            }
            self.state.stale = all();
        } else if changed.inputs() {
            self.state.stale |= self.layout.input_dependent;
        }
        Ok(Status::Ok)
    }

    /// As [`after_set`](Self::after_set) for variables that live in `Access`es: integers, Booleans and strings.
    fn set_each<T: Copy>(
        &mut self,
        slots: impl Fn(&Layout<M>) -> &[Slot],
        what: &str,
        references: &[u32],
        values: &[T],
        accept: impl Fn(&Variable<M>, &T) -> Result<(), String>,
        write: impl Fn(&Access<M>, &mut M, T),
    ) -> Outcome {
        self.check(Call::Set, what)?;
        let layout = Arc::clone(&self.layout);
        let mut changed = Changed::default();
        for (reference, value) in references.iter().zip(values) {
            let slot = find(slots(&layout), *reference)?;
            self.check_settable(slot)?;
            let variable = &layout.variables[slot.variable as usize];
            accept(variable, value).map_err(|why| Refusal::error(format!("{}: {why}", variable.name)))?;
            changed.add(slot.causality);
        }
        let old = self.before_tuning(changed);
        for (reference, value) in references.iter().zip(values) {
            let slot = find(slots(&layout), *reference)?;
            write(&layout.variables[slot.variable as usize].access, &mut self.state.model, *value);
        }
        self.after_set(changed, old)
    }

    /// Runs what the variables need and reads them.
    fn get_each<T>(
        &mut self,
        slots: impl Fn(&Layout<M>) -> &[Slot],
        what: &str,
        references: &[u32],
        values: &mut [T],
        read: impl Fn(&Access<M>, &mut M) -> T,
    ) -> Outcome {
        self.check(Call::Get, what)?;
        let layout = Arc::clone(&self.layout);
        let mut wanted = 0;
        for reference in references {
            wanted |= find(slots(&layout), *reference)?.evaluation;
        }
        self.evaluate(wanted)?;
        for (reference, value) in references.iter().zip(values) {
            let slot = find(slots(&layout), *reference)?;
            *value = read(&layout.variables[slot.variable as usize].access, &mut self.state.model);
        }
        Ok(Status::Ok)
    }

    fn real(&self, reference: u32) -> Result<&RealSlot<M>, Refusal> {
        self.layout.reals.get(reference as usize).ok_or_else(|| no_such(reference))
    }

    /// Why a real variable cannot have a value. Apart from the loop that checks, which is on the way of every step.
    #[cold]
    fn no_real_to_set(&self, reference: u32, value: f64) -> Refusal {
        match self.real(reference) {
            Ok(real) if real.slot.settable & self.state.phase.settable_bit() == 0 => self.not_settable(&real.slot),
            Ok(real) => out_of_range(self.name(&real.slot), value, real.min, real.max),
            Err(refusal) => refusal,
        }
    }

    /// Checks a step's start and size against the clock.
    fn check_step(&self, time: f64, size: f64) -> Result<(), Refusal> {
        if !(size.is_finite() && size > 0.0) {
            return Err(Refusal::error(format!("communicationStepSize is {size:?}, it must be positive and finite")));
        }
        if !time.is_finite() {
            return Err(Refusal::error(format!("currentCommunicationPoint is {time:?}, it must be finite")));
        }
        let now = self.state.time;
        // A host may compute the points as start + i·h or by adding up: they differ by some units in the last place.
        let tolerance = 1e-6 * size + 16.0 * f64::EPSILON * now.abs();
        if (time - now).abs() > tolerance {
            return Err(Refusal::error(format!(
                "currentCommunicationPoint is {time:?}, but the last step ended at {now:?}; \
                 fmi2SetFMUstate leads back to an earlier time"
            )));
        }
        let end = time + size;
        if end <= time {
            return Err(Refusal::error(format!(
                "communicationStepSize {size:?} is too small to change the time {time:?}"
            )));
        }
        if !end.is_finite() {
            return Err(Refusal::error(format!(
                "communicationStepSize {size:?} is too large: the step from {time:?} has no finite end"
            )));
        }
        if let Some(stop) = self.state.experiment.and_then(|e| e.stop_time)
            && end > stop + tolerance + 16.0 * f64::EPSILON * stop.abs()
        {
            return Err(Refusal::error(format!("the step ends at {end:?}, past the stop time {stop:?}")));
        }
        Ok(())
    }

    /// Checks that no input leaves its range on its ramp.
    fn check_ramps(&mut self, size: f64) -> Result<(), Refusal> {
        for reference in &self.layout.ramps {
            let real = &self.layout.reals[*reference as usize];
            let Some(ramp) = &real.ramp else { continue };
            let slope = *ramp(&mut self.state.model);
            let end = *(real.lens)(&mut self.state.model) + slope * size;
            if !real.accepts(end) {
                let refusal = out_of_range(self.name(&real.slot), end, real.min, real.max);
                let end = format!("; it would be at the end of this step, rising by {slope:?} per second");
                return Err(Refusal::error(refusal.message + &end));
            }
        }
        Ok(())
    }

    /// The inputs' ramps have been used: the inputs stand at their ends.
    fn finish_ramps(&mut self, size: f64) {
        for reference in &self.layout.ramps {
            let real = &self.layout.reals[*reference as usize];
            if let Some(ramp) = &real.ramp {
                let slope = std::mem::take(ramp(&mut self.state.model));
                // Adding zero would turn −0 into +0.
                if slope != 0.0 {
                    *(real.lens)(&mut self.state.model) += slope * size;
                }
            }
        }
        self.state.ramped = false;
    }
}

/// What kinds of variables a call sets.
#[derive(Clone, Copy, Default)]
struct Changed(u8);

impl Changed {
    fn add(&mut self, causality: Causality) {
        self.0 |= 1 << causality as u8;
    }

    fn has(self, causality: Causality) -> bool {
        self.0 & (1 << causality as u8) != 0
    }

    fn inputs(self) -> bool {
        self.has(Causality::Input)
    }

    fn parameters(self) -> bool {
        self.has(Causality::Parameter)
    }
}

fn find(slots: &[Slot], reference: u32) -> Result<&Slot, Refusal> {
    slots.get(reference as usize).ok_or_else(|| no_such(reference))
}

#[cold]
fn no_such(reference: u32) -> Refusal {
    Refusal::error(format!("there is no variable of this type with value reference {reference}"))
}

impl<M: Model> AnySlave for Slave<M> {
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
        Ok(Status::Ok)
    }

    fn enter_initialization(&mut self) -> Outcome {
        self.check(Call::EnterInitializationMode, "fmi2EnterInitializationMode")?;
        if self.state.experiment.is_none() {
            return Err(Refusal::error("fmi2SetupExperiment must be called before fmi2EnterInitializationMode"));
        }
        self.initialize()?;
        self.state.phase = Phase::Initialization;
        Ok(Status::Ok)
    }

    fn exit_initialization(&mut self) -> Outcome {
        self.check(Call::ExitInitializationMode, "fmi2ExitInitializationMode")?;
        if self.state.uninitialized {
            self.initialize()?;
        }
        self.state.phase = Phase::StepComplete;
        Ok(Status::Ok)
    }

    fn terminate(&mut self) -> Outcome {
        self.check(Call::Terminate, "fmi2Terminate")?;
        self.state.phase = Phase::Terminated;
        Ok(Status::Ok)
    }

    fn reset(&mut self) -> Outcome {
        let old = std::mem::replace(&mut self.state, State::new());
        // A failed model may have left anything there.
        self.direction = None;
        self.strings.clear();
        drop(old);
        Ok(Status::Ok)
    }

    fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Outcome {
        self.check(Call::Get, "fmi2GetReal")?;
        let mut wanted = 0;
        for reference in references {
            match self.layout.reals.get(*reference as usize) {
                Some(real) => wanted |= real.slot.evaluation,
                None => return Err(no_such(*reference)),
            }
        }
        self.evaluate(wanted)?;
        let (reals, model) = (self.layout.reals.as_slice(), &mut self.state.model);
        for (reference, value) in references.iter().zip(values) {
            if let Some(real) = reals.get(*reference as usize) {
                *value = *(real.lens)(model);
            }
        }
        Ok(Status::Ok)
    }

    fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Outcome {
        self.get_each(
            |l| &l.integers,
            "fmi2GetInteger",
            references,
            values,
            |access, model| match access {
                Access::Integer { get, .. } | Access::Enumeration { get, .. } => get(model),
                _ => 0,
            },
        )
    }

    fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Outcome {
        self.get_each(
            |l| &l.booleans,
            "fmi2GetBoolean",
            references,
            values,
            |access, model| match access {
                Access::Boolean(field) => i32::from(*field(model)),
                _ => 0,
            },
        )
    }

    fn get_string(&mut self, references: &[u32]) -> Result<&[CString], Refusal> {
        let mut strings = Vec::new();
        strings
            .try_reserve_exact(references.len())
            .map_err(|_| Refusal::error(format!("fmi2GetString: no memory for {} strings", references.len())))?;
        strings.resize(references.len(), CString::default());
        self.get_each(
            |l| &l.strings,
            "fmi2GetString",
            references,
            &mut strings,
            |access, model| match access {
                Access::String(field) => CString::new(field(model).replace('\0', "")).unwrap_or_default(),
                _ => CString::default(),
            },
        )?;
        self.strings = strings;
        Ok(&self.strings)
    }

    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        self.check(Call::Set, "fmi2SetReal")?;
        let mut changed = Changed::default();
        let now = self.state.phase.settable_bit();
        for (reference, value) in references.iter().zip(values) {
            match self.layout.reals.get(*reference as usize) {
                Some(real) if real.slot.settable & now != 0 && real.accepts(*value) => {
                    changed.add(real.slot.causality);
                }
                _ => return Err(self.no_real_to_set(*reference, *value)),
            }
        }
        let old = self.before_tuning(changed);
        let (reals, model) = (self.layout.reals.as_slice(), &mut self.state.model);
        for (reference, value) in references.iter().zip(values) {
            if let Some(real) = reals.get(*reference as usize) {
                let place = (real.lens)(model);
                *place = *value;
            }
        }
        self.after_set(changed, old)
    }

    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let accept = |variable: &Variable<M>, value: &i32| accept_integer(variable, *value);
        self.set_each(
            |l| &l.integers,
            "fmi2SetInteger",
            references,
            values,
            accept,
            |access, model, value| match access {
                Access::Integer { set, .. } | Access::Enumeration { set, .. } => _ = set(model, value),
                _ => {}
            },
        )
    }

    fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let accept = |_: &Variable<M>, value: &i32| match value {
            0 | 1 => Ok(()),
            _ => Err(format!("{value} is no fmi2Boolean, which is 0 or 1")),
        };
        self.set_each(
            |l| &l.booleans,
            "fmi2SetBoolean",
            references,
            values,
            accept,
            |access, model, value| {
                if let Access::Boolean(field) = access {
                    *field(model) = value != 0;
                }
            },
        )
    }

    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Outcome {
        self.set_each(
            |l| &l.strings,
            "fmi2SetString",
            references,
            values,
            |_, _| Ok(()),
            |access, model, value| {
                if let Access::String(field) = access {
                    value.clone_into(field(model));
                }
            },
        )
    }

    fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome {
        self.check(Call::Set, "fmi2SetRealInputDerivatives")?;
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            let real = self.real(*reference)?;
            let name = self.name(&real.slot);
            if real.ramp.is_none() {
                return Err(Refusal::error(format!("{name} takes no derivatives")));
            }
            if *order != 1 {
                return Err(Refusal::error(format!("derivative of order {order} of {name}: only order 1 is taken")));
            }
            if !value.is_finite() {
                return Err(out_of_range(name, *value, f64::NEG_INFINITY, f64::INFINITY));
            }
        }
        for (reference, value) in references.iter().zip(values) {
            if let Some(ramp) = self.layout.reals.get(*reference as usize).and_then(|real| real.ramp.as_ref()) {
                *ramp(&mut self.state.model) = *value;
            }
        }
        self.state.ramped |= !references.is_empty();
        // The time derivatives of outputs that depend on inputs depend on the inputs' slopes.
        self.state.stale |= self.layout.input_dependent;
        Ok(Status::Ok)
    }

    fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Outcome {
        self.check(Call::GetOutputDerivatives, "fmi2GetRealOutputDerivatives")?;
        let mut wanted = 0;
        for (reference, order) in references.iter().zip(orders) {
            let real = self.real(*reference)?;
            if *order < 1 {
                let name = self.name(&real.slot);
                return Err(Refusal::error(format!(
                    "derivative of order {order} of {name}: the order must be 1 or more"
                )));
            }
            if let Some((_, evaluation)) = &real.rate {
                wanted |= *evaluation;
            } else {
                return Err(Refusal::error(format!("{} provides no derivative", self.name(&real.slot))));
            }
        }
        self.evaluate(wanted)?;
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            let rate = self.layout.reals.get(*reference as usize).and_then(|real| real.rate.as_ref());
            // "If the actual order is lower, the retrieved value is 0."
            *value = match rate {
                Some((rate, _)) if *order == 1 => *rate(&mut self.state.model),
                _ => 0.0,
            };
        }
        Ok(Status::Ok)
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        values: &mut [f64],
    ) -> Outcome {
        self.check(Call::Get, "fmi2GetDirectionalDerivative")?;
        if !M::INFO.directional_derivatives {
            return Err(Refusal::error("this model provides no directional derivatives"));
        }
        for reference in unknowns {
            let slot = &self.real(*reference)?.slot;
            if slot.causality != Causality::Output {
                return Err(Refusal::error(format!("{} is no output: it has no derivative", self.name(slot))));
            }
        }
        for (reference, value) in knowns.iter().zip(seed) {
            let slot = &self.real(*reference)?.slot;
            if slot.causality != Causality::Input {
                return Err(Refusal::error(format!("{} is no input: nothing is derived by it", self.name(slot))));
            }
            if !value.is_finite() {
                return Err(out_of_range(self.name(slot), *value, f64::NEG_INFINITY, f64::INFINITY));
            }
        }
        self.evaluate(0)?;
        if self.state.phase == Phase::Error {
            values.fill(0.0);
            return Ok(Status::Ok);
        }
        let layout = &self.layout;
        let direction = self.direction.get_or_insert_with(Default::default);
        for real in &layout.reals {
            if real.slot.causality != Causality::Parameter {
                *(real.lens)(direction) = 0.0;
            }
        }
        // The same input may be named twice: the directions add up.
        for (reference, value) in knowns.iter().zip(seed) {
            *(layout.reals[*reference as usize].lens)(direction) += value;
        }
        self.state.model.directional_derivative(direction);
        for (reference, value) in unknowns.iter().zip(values) {
            *value = *(layout.reals[*reference as usize].lens)(direction);
        }
        Ok(Status::Ok)
    }

    fn do_step(&mut self, time: f64, size: f64, logger: &Logger) -> Outcome {
        self.check(Call::DoStep, "fmi2DoStep")?;
        self.check_step(time, size)?;
        if self.state.ramped {
            self.check_ramps(size)?;
        }
        // What the model says goes to the logger; the status tells whether the step was done, and masters stop at others.
        let mut warn = |message: std::fmt::Arguments<'_>| logger.log(Status::Warning, Category::Warning, message);
        let result = self.state.model.step(&mut Step::new(time, size, &mut warn));
        self.state.stale = all();
        match result {
            Ok(()) => {
                self.state.time = time + size;
                if self.state.ramped {
                    self.finish_ramps(size);
                }
                Ok(Status::Ok)
            }
            // Only a step can be discarded.
            Err(Failure::Discard(message)) => {
                self.state.phase = Phase::StepFailed;
                Err(Refusal::discard(message))
            }
            Err(Failure::Error(message)) => {
                self.state.phase = Phase::Error;
                Err(Refusal::error(message))
            }
        }
    }

    fn last_successful_time(&self) -> f64 {
        self.state.time
    }

    fn save(&self) -> Snapshot {
        Arc::new(self.state.clone())
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Outcome {
        self.state = Self::own(snapshot)?.clone();
        self.strings.clear();
        Ok(Status::Ok)
    }

    fn encode(&self, snapshot: &Snapshot) -> Result<Vec<u8>, Refusal> {
        Ok(snapshot::encode(self.guid, Self::own(snapshot)?)?)
    }

    fn decode(&self, bytes: &[u8]) -> Result<Snapshot, Refusal> {
        let mut state: State<M> = snapshot::decode(self.guid, bytes)?;
        self.check_decoded(&mut state).map_err(SnapshotError::Content)?;
        state.model.restored().map_err(|failure| SnapshotError::Content(failure.to_string()))?;
        Ok(Arc::new(state))
    }
}

impl<M: Model> Slave<M> {
    /// Checks what a host could not have brought about: a checksum is no proof of where bytes come from. The state of the
    /// model itself is the model's to check, in `restored`.
    fn check_decoded(&self, state: &mut State<M>) -> Result<(), String> {
        if !state.time.is_finite() {
            return Err("its time is not finite".into());
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
                let value = get(&mut state.model);
                accept_integer(variable, value).map_err(|why| format!("{}: {why}", variable.name))?;
            }
        }
        Ok(())
    }

    fn own(snapshot: &Snapshot) -> Result<&State<M>, Refusal> {
        snapshot.downcast_ref().ok_or_else(|| Refusal::error("this FMU state belongs to another model"))
    }
}

fn check_experiment(experiment: &Experiment) -> Result<(), String> {
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

/// Checks the value of an integer or an enumeration.
fn accept_integer<M>(variable: &Variable<M>, value: i32) -> Result<(), String> {
    match &variable.access {
        Access::Enumeration { kind, .. } => {
            if usize::try_from(value).is_ok_and(|v| (1..=kind.items.len()).contains(&v)) {
                Ok(())
            } else {
                Err(format!("{value} is no item of {}, they are numbered from 1 to {}", kind.name, kind.items.len()))
            }
        }
        access => {
            let (min, max) = (variable.min, variable.max);
            let number = f64::from(value);
            let fits = matches!(access, Access::Integer { fits, .. } if fits(value));
            if fits && min.is_none_or(|min| min <= number) && max.is_none_or(|max| number <= max) {
                Ok(())
            } else {
                let bound = |b: Option<f64>| b.map_or("any".to_owned(), |b| b.to_string());
                Err(format!("{value} is out of range, the least is {}, the greatest {}", bound(min), bound(max)))
            }
        }
    }
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
