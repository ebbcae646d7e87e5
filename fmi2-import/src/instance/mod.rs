//! One running slave. Every call is safe. A status other than OK or Warning becomes an error with the messages that the
//! slave logged.

mod calls;
mod derivatives;
mod log;
mod state;
mod step;
mod values;

use std::ffi::{CString, c_int, c_void};
use std::ptr::NonNull;
use std::sync::Arc;

use crate::description::{CoSimulation, ModelDescription};
use crate::error::CallError;
use crate::floating_point::guarded;
use crate::fmu::Loaded;
use crate::library::{CallbackFunctions, Component, Functions, Status};
pub use calls::Calls;
pub use log::LogMessage;
use log::{Log, messages_of, with_names};
pub use state::SavedState;

type Result<T> = std::result::Result<T, CallError>;

/// Arguments of `fmi2SetupExperiment`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Experiment {
    /// Start time in s.
    pub start: f64,
    /// Stop time in s, if known in advance.
    pub stop: Option<f64>,
    /// Relative tolerance, if the slave should use one.
    pub tolerance: Option<f64>,
}

/// One running slave. Dropping it ends it in the order that the standard demands.
pub struct Instance {
    component: NonNull<c_void>,
    phase: Phase,
    name: String,
    log: Log,
    _callbacks: Box<CallbackFunctions>, // the slave may keep the pointer
    loaded: Arc<Loaded>,
}

// SAFETY: FMI 2.0 asks only that calls of one instance do not overlap; they may come from different threads. The log is
// behind a mutex.
unsafe impl Send for Instance {}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Before the end of initialisation.
    Setup,
    /// Between the end of initialisation and termination.
    Running,
    /// Terminated, or failed: only to be freed (or reset).
    Over,
    /// Nothing may be called any more.
    Lost,
}

/// `fmi2CoSimulation`
const CO_SIMULATION: c_int = 1;

impl Instance {
    pub(super) fn new(loaded: Arc<Loaded>, name: &str) -> Result<Self> {
        let c_string = |text: &str| {
            CString::new(text).map_err(|_| CallError::ZeroByte { instance: name.to_owned(), text: text.to_owned() })
        };
        let (c_name, guid, resources) =
            (c_string(name)?, c_string(&loaded.description.guid)?, c_string(&loaded.resources)?);
        let log = Log::new(name);
        let callbacks = Box::new(log.callbacks());
        // SAFETY: all pointers are valid for the call, log and callbacks for the life of the instance. Logging is on, so
        // that errors can say why.
        let component = guarded(|| unsafe {
            (loaded.functions.instantiate)(
                c_name.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.as_ptr(),
                &raw const *callbacks,
                0,
                1,
            )
        });
        let Some(component) = NonNull::new(component) else {
            let messages = messages_of(&log, &loaded.description);
            return Err(CallError::Instantiate { instance: name.to_owned(), messages });
        };
        Ok(Self { component, phase: Phase::Setup, name: name.to_owned(), log, _callbacks: callbacks, loaded })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The description of the FMU.
    #[must_use]
    pub fn description(&self) -> &ModelDescription {
        &self.loaded.description
    }

    /// The same, for callers that continue to call the instance.
    #[must_use]
    pub fn shared_description(&self) -> Arc<ModelDescription> {
        Arc::clone(&self.loaded.description)
    }

    /// The newest messages of the slave, oldest first; they are forgotten here.
    pub fn take_log(&mut self) -> Vec<LogMessage> {
        let messages: Vec<_> = self.log.messages().drain(..).collect();
        messages
            .into_iter()
            .map(|message| LogMessage { text: with_names(&message.text, &self.loaded.description), ..message })
            .collect()
    }

    /// `fmi2SetDebugLogging`: whether the slave logs more than its errors, and in which of the categories of
    /// [`ModelDescription::log_categories`]; an empty list means all.
    ///
    /// # Errors
    /// When the slave refuses, or a category has a zero byte inside.
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Result<Status> {
        let c_string = |text: &&str| {
            CString::new(*text)
                .map_err(|_| CallError::ZeroByte { instance: self.name.clone(), text: (*text).to_owned() })
        };
        let categories = categories.iter().map(c_string).collect::<Result<Vec<_>>>()?;
        let pointers: Vec<_> = categories.iter().map(|category| category.as_ptr()).collect();
        let set = self.functions().set_debug_logging;
        // SAFETY: living component, as many C strings as stated, which live until the end of this function.
        let status =
            guarded(|| unsafe { set(self.component.as_ptr(), c_int::from(on), pointers.len(), pointers.as_ptr()) });
        self.check("fmi2SetDebugLogging", status)
    }

    /// `fmi2SetupExperiment`: start and stop time.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn setup_experiment(&mut self, experiment: Experiment) -> Result<Status> {
        let Experiment { start, stop, tolerance } = experiment;
        let (with_stop, with_tolerance) = (c_int::from(stop.is_some()), c_int::from(tolerance.is_some()));
        let (stop, tolerance) = (stop.unwrap_or(0.0), tolerance.unwrap_or(0.0));
        // SAFETY: plain values, living component.
        let status = guarded(|| unsafe {
            (self.functions().setup_experiment)(
                self.component.as_ptr(),
                with_tolerance,
                tolerance,
                start,
                with_stop,
                stop,
            )
        });
        self.check("fmi2SetupExperiment", status)
    }

    /// `fmi2EnterInitializationMode`.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn enter_initialization_mode(&mut self) -> Result<Status> {
        // SAFETY: living component.
        let status = guarded(|| unsafe { (self.functions().enter_initialization_mode)(self.component.as_ptr()) });
        self.check("fmi2EnterInitializationMode", status)
    }

    /// `fmi2ExitInitializationMode`: the slave is ready to step.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn exit_initialization_mode(&mut self) -> Result<Status> {
        // SAFETY: living component.
        let status = guarded(|| unsafe { (self.functions().exit_initialization_mode)(self.component.as_ptr()) });
        let status = self.check("fmi2ExitInitializationMode", status)?;
        self.phase = Phase::Running;
        Ok(status)
    }

    /// `fmi2Terminate`: the simulation is over, values can still be read.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn terminate(&mut self) -> Result<Status> {
        self.phase = Phase::Over;
        // SAFETY: living component.
        let status = guarded(|| unsafe { (self.functions().terminate)(self.component.as_ptr()) });
        self.check("fmi2Terminate", status)
    }

    /// `fmi2Reset`: restores the state after instantiation; also possible after an error.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn reset(&mut self) -> Result<Status> {
        // SAFETY: living component.
        let status = guarded(|| unsafe { (self.functions().reset)(self.component.as_ptr()) });
        let status = self.check("fmi2Reset", status)?;
        self.phase = Phase::Setup;
        Ok(status)
    }

    /// The slave's own handle, for calls of [`functions`](Self::functions) by hand: unchecked, with the slave's floating-point environment,
    /// and without messages. It lives as long as this instance.
    #[inline]
    #[must_use]
    pub fn component(&self) -> Component {
        self.component.as_ptr()
    }

    /// The C functions of the slave's library.
    #[inline]
    #[must_use]
    pub fn functions(&self) -> &Functions {
        &self.loaded.functions
    }

    fn interface(&self) -> Option<&CoSimulation> {
        self.loaded.description.co_simulation.as_ref()
    }

    /// An optional function of the FMU, which may only be called if the description declares the capability.
    fn optional<F>(&self, name: &'static str, function: Option<F>, can: impl Fn(&CoSimulation) -> bool) -> Result<F> {
        function
            .filter(|_| self.interface().is_some_and(can))
            .ok_or_else(|| CallError::Unsupported { instance: self.name.clone(), function: name })
    }

    #[inline]
    fn check(&mut self, function: &'static str, status: c_int) -> Result<Status> {
        if status == 0 { Ok(Status::Ok) } else { self.judge(function, Status::from_c(status)) }
    }

    #[cold]
    fn judge(&mut self, function: &'static str, status: Status) -> Result<Status> {
        match status {
            Status::Ok | Status::Warning => return Ok(status),
            Status::Discard => {}
            Status::Error | Status::Pending => self.phase = Phase::Over,
            Status::Fatal => self.phase = Phase::Lost,
        }
        let messages = messages_of(&self.log, &self.loaded.description);
        Err(CallError::Status { instance: self.name.clone(), function, status, messages })
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: living component; after Fatal the standard forbids every call.
        guarded(|| unsafe {
            if self.phase == Phase::Running {
                (self.functions().terminate)(self.component.as_ptr());
            }
            if self.phase != Phase::Lost {
                (self.functions().free_instance)(self.component.as_ptr());
            }
        });
    }
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance").field("name", &self.name).field("phase", &self.phase).finish_non_exhaustive()
    }
}
