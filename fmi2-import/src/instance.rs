//! One running slave. Every call is safe; a status other than OK or Warning becomes an error that carries what the
//! slave logged.

use std::collections::VecDeque;
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{self, NonNull};
use std::sync::{Arc, Mutex, PoisonError};

use super::description::{BaseType, ModelDescription};
use super::error::CallError;
use super::fmu::Loaded;
use super::library::{CallbackFunctions, Functions, LAST_SUCCESSFUL_TIME, Status, TERMINATED, ValueReference, text};

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

/// One message of a slave.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogMessage {
    /// How serious it is.
    pub status: Status,
    /// The slave's category.
    pub category: String,
    /// The text; value references in it are replaced by names.
    pub text: String,
}

/// A state of an instance, saved inside the slave. Give it back with [`Instance::free_state`].
#[derive(Debug)]
pub struct SavedState {
    state: *mut c_void,
    owner: NonNull<c_void>,
}

/// One running slave. Dropping it ends it in the order the standard wants.
pub struct Instance {
    component: NonNull<c_void>,
    phase: Phase,
    name: String,
    log: Box<Log>,
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

/// Messages of a slave, the newest [`Log::CAPACITY`] of them.
#[derive(Default)]
struct Log(Mutex<VecDeque<LogMessage>>);

impl Log {
    const CAPACITY: usize = 64;

    fn messages(&self) -> std::sync::MutexGuard<'_, VecDeque<LogMessage>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

unsafe extern "C" {
    fn fmi2_import_logger(
        environment: *mut c_void,
        instance: *const c_char,
        status: c_int,
        category: *const c_char,
        format: *const c_char,
        ...
    );
    fn fmi2_import_allocate(count: usize, size: usize) -> *mut c_void;
    fn fmi2_import_free(memory: *mut c_void);
}

/// Receives a formatted message from the C half of the logger.
#[unsafe(no_mangle)]
extern "C" fn fmi2_import_log(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the log of a living instance, which hands it to its slave and outlives it.
    let Some(log) = (unsafe { environment.cast::<Log>().as_ref() }) else { return };
    // SAFETY: the C half passes on C strings (or null).
    let (category, text) = unsafe { (text(category), text(message)) };
    let mut messages = log.messages();
    if messages.len() == Log::CAPACITY {
        messages.pop_front();
    }
    messages.push_back(LogMessage { status: Status::from_c(status), category, text });
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
        let log = Box::<Log>::default();
        let callbacks = Box::new(CallbackFunctions {
            logger: fmi2_import_logger,
            allocate_memory: fmi2_import_allocate,
            free_memory: fmi2_import_free,
            step_finished: None,
            component_environment: ptr::from_ref::<Log>(&log).cast_mut().cast(),
        });
        // SAFETY: all pointers are valid for the call, log and callbacks for the life of the instance. Logging is on, so
        // that errors can say why.
        let component = unsafe {
            (loaded.functions.instantiate)(
                c_name.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.as_ptr(),
                &raw const *callbacks,
                0,
                1,
            )
        };
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

    /// What the FMU says about itself.
    #[must_use]
    pub fn description(&self) -> &ModelDescription {
        &self.loaded.description
    }

    /// The newest messages of the slave, oldest first; they are forgotten here.
    pub fn take_log(&mut self) -> Vec<LogMessage> {
        let messages: Vec<_> = self.log.messages().drain(..).collect();
        messages
            .into_iter()
            .map(|message| LogMessage { text: with_names(&message.text, &self.loaded.description), ..message })
            .collect()
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
        let status = unsafe {
            (self.functions().setup_experiment)(
                self.component.as_ptr(),
                with_tolerance,
                tolerance,
                start,
                with_stop,
                stop,
            )
        };
        self.check("fmi2SetupExperiment", status)
    }

    /// `fmi2EnterInitializationMode`.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn enter_initialization_mode(&mut self) -> Result<Status> {
        // SAFETY: living component.
        let status = unsafe { (self.functions().enter_initialization_mode)(self.component.as_ptr()) };
        self.check("fmi2EnterInitializationMode", status)
    }

    /// `fmi2ExitInitializationMode`: the slave is ready to step.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn exit_initialization_mode(&mut self) -> Result<Status> {
        // SAFETY: living component.
        let status = unsafe { (self.functions().exit_initialization_mode)(self.component.as_ptr()) };
        let status = self.check("fmi2ExitInitializationMode", status)?;
        self.phase = Phase::Running;
        Ok(status)
    }

    /// `fmi2DoStep`: from `time` to `time + step`.
    ///
    /// # Errors
    /// When the slave does not complete the step.
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<Status> {
        // SAFETY: living component. No state before `time` will be restored.
        let status = unsafe { (self.functions().do_step)(self.component.as_ptr(), time, step, 1) };
        self.check("fmi2DoStep", status)
    }

    /// `fmi2Terminate`: the simulation is over, values can still be read.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn terminate(&mut self) -> Result<Status> {
        self.phase = Phase::Over;
        // SAFETY: living component.
        let status = unsafe { (self.functions().terminate)(self.component.as_ptr()) };
        self.check("fmi2Terminate", status)
    }

    /// `fmi2Reset`: back to the state after instantiation; also the way out after an error.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn reset(&mut self) -> Result<Status> {
        // SAFETY: living component.
        let status = unsafe { (self.functions().reset)(self.component.as_ptr()) };
        let status = self.check("fmi2Reset", status)?;
        self.phase = Phase::Setup;
        Ok(status)
    }

    /// `fmi2GetReal` for many variables at once.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn get_real(&mut self, references: &[ValueReference], values: &mut [f64]) -> Result<Status> {
        assert_eq!(references.len(), values.len());
        if references.is_empty() {
            return Ok(Status::Ok);
        }
        // SAFETY: living component, both arrays have the stated length.
        let status = unsafe {
            (self.functions().get_real)(
                self.component.as_ptr(),
                references.as_ptr(),
                references.len(),
                values.as_mut_ptr(),
            )
        };
        self.check("fmi2GetReal", status)
    }

    /// `fmi2SetReal` for many variables at once.
    ///
    /// # Errors
    /// When the slave refuses a value.
    ///
    /// # Panics
    /// When the slices differ in length.
    #[inline]
    pub fn set_real(&mut self, references: &[ValueReference], values: &[f64]) -> Result<Status> {
        assert_eq!(references.len(), values.len());
        if references.is_empty() {
            return Ok(Status::Ok);
        }
        // SAFETY: living component, both arrays have the stated length.
        let status = unsafe {
            (self.functions().set_real)(self.component.as_ptr(), references.as_ptr(), references.len(), values.as_ptr())
        };
        self.check("fmi2SetReal", status)
    }

    /// `fmi2GetInteger` for many variables at once, integers and enumerations.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn get_integer(&mut self, references: &[ValueReference], values: &mut [i32]) -> Result<Status> {
        assert_eq!(references.len(), values.len());
        if references.is_empty() {
            return Ok(Status::Ok);
        }
        // SAFETY: living component, both arrays have the stated length.
        let status = unsafe {
            (self.functions().get_integer)(
                self.component.as_ptr(),
                references.as_ptr(),
                references.len(),
                values.as_mut_ptr(),
            )
        };
        self.check("fmi2GetInteger", status)
    }

    /// `fmi2SetInteger` for many variables at once, integers and enumerations.
    ///
    /// # Errors
    /// When the slave refuses a value.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn set_integer(&mut self, references: &[ValueReference], values: &[i32]) -> Result<Status> {
        assert_eq!(references.len(), values.len());
        if references.is_empty() {
            return Ok(Status::Ok);
        }
        // SAFETY: living component, both arrays have the stated length.
        let status = unsafe {
            (self.functions().set_integer)(
                self.component.as_ptr(),
                references.as_ptr(),
                references.len(),
                values.as_ptr(),
            )
        };
        self.check("fmi2SetInteger", status)
    }

    /// `fmi2GetBoolean` for many variables.
    ///
    /// # Errors
    /// When the slave refuses.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn get_boolean(&mut self, references: &[ValueReference], values: &mut [bool]) -> Result<Status> {
        assert_eq!(references.len(), values.len());
        let mut worst = Status::Ok;
        let mut c_values = [0; 16]; // booleans are ints in C; in blocks, so that nothing is allocated
        for (references, values) in references.chunks(c_values.len()).zip(values.chunks_mut(c_values.len())) {
            // SAFETY: living component, both arrays have at least the stated length.
            let status = unsafe {
                (self.functions().get_boolean)(
                    self.component.as_ptr(),
                    references.as_ptr(),
                    references.len(),
                    c_values.as_mut_ptr(),
                )
            };
            worst = worst.max(self.check("fmi2GetBoolean", status)?);
            for (value, c_value) in values.iter_mut().zip(&c_values) {
                *value = *c_value != 0;
            }
        }
        Ok(worst)
    }

    /// `fmi2SetBoolean` for many variables.
    ///
    /// # Errors
    /// When the slave refuses a value.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn set_boolean(&mut self, references: &[ValueReference], values: &[bool]) -> Result<Status> {
        assert_eq!(references.len(), values.len());
        let mut worst = Status::Ok;
        let mut c_values = [0; 16];
        for (references, values) in references.chunks(c_values.len()).zip(values.chunks(c_values.len())) {
            for (c_value, value) in c_values.iter_mut().zip(values) {
                *c_value = c_int::from(*value);
            }
            // SAFETY: living component, both arrays have at least the stated length.
            let status = unsafe {
                (self.functions().set_boolean)(
                    self.component.as_ptr(),
                    references.as_ptr(),
                    references.len(),
                    c_values.as_ptr(),
                )
            };
            worst = worst.max(self.check("fmi2SetBoolean", status)?);
        }
        Ok(worst)
    }

    /// `fmi2GetString` for one variable.
    ///
    /// # Errors
    /// When the slave refuses.
    pub fn get_string(&mut self, reference: ValueReference) -> Result<String> {
        let mut value = ptr::null();
        // SAFETY: living component, arrays of length 1.
        let status =
            unsafe { (self.functions().get_string)(self.component.as_ptr(), &raw const reference, 1, &raw mut value) };
        self.check("fmi2GetString", status)?;
        // SAFETY: the slave returns a C string, valid until the next call.
        Ok(unsafe { text(value) })
    }

    /// `fmi2SetString` for one variable.
    ///
    /// # Errors
    /// When the slave refuses the value, or the value has a zero byte inside.
    pub fn set_string(&mut self, reference: ValueReference, value: &str) -> Result<Status> {
        let c_value = CString::new(value)
            .map_err(|_| CallError::ZeroByte { instance: self.name.clone(), text: value.to_owned() })?;
        let pointer = c_value.as_ptr();
        // SAFETY: living component, arrays of length 1.
        let status = unsafe {
            (self.functions().set_string)(self.component.as_ptr(), &raw const reference, 1, &raw const pointer)
        };
        self.check("fmi2SetString", status)
    }

    /// `fmi2GetFMUstate`: saves the state inside the slave.
    ///
    /// # Errors
    /// When the slave cannot.
    pub fn save_state(&mut self) -> Result<SavedState> {
        let function = self.optional("fmi2GetFMUstate", self.functions().get_fmu_state)?;
        let mut state = ptr::null_mut();
        // SAFETY: living component; a null state asks for a new one.
        let status = unsafe { function(self.component.as_ptr(), &raw mut state) };
        self.check("fmi2GetFMUstate", status)?;
        Ok(SavedState { state, owner: self.component })
    }

    /// `fmi2SetFMUstate`: back to a saved state.
    ///
    /// # Errors
    /// When the slave cannot, or the state is another instance's.
    pub fn restore_state(&mut self, saved: &SavedState) -> Result<Status> {
        let function = self.optional("fmi2SetFMUstate", self.functions().set_fmu_state)?;
        self.own(saved)?;
        // SAFETY: living component, its own state.
        let status = unsafe { function(self.component.as_ptr(), saved.state) };
        self.check("fmi2SetFMUstate", status)
    }

    /// `fmi2FreeFMUstate`: gives a saved state back.
    ///
    /// # Errors
    /// When the slave cannot, or the state is another instance's.
    #[allow(clippy::needless_pass_by_value)] // it must not be used again
    pub fn free_state(&mut self, saved: SavedState) -> Result<Status> {
        let function = self.optional("fmi2FreeFMUstate", self.functions().free_fmu_state)?;
        self.own(&saved)?;
        let mut state = saved.state;
        // SAFETY: living component, its own state.
        let status = unsafe { function(self.component.as_ptr(), &raw mut state) };
        self.check("fmi2FreeFMUstate", status)
    }

    /// `fmi2SerializeFMUstate`: a saved state as bytes.
    ///
    /// # Errors
    /// When the slave cannot, or the state is another instance's.
    pub fn serialize_state(&mut self, saved: &SavedState) -> Result<Vec<u8>> {
        let size_of = self.optional("fmi2SerializedFMUstateSize", self.functions().serialized_fmu_state_size)?;
        let serialize = self.optional("fmi2SerializeFMUstate", self.functions().serialize_fmu_state)?;
        self.own(saved)?;
        let mut size = 0;
        // SAFETY: living component, its own state.
        let status = unsafe { size_of(self.component.as_ptr(), saved.state, &raw mut size) };
        self.check("fmi2SerializedFMUstateSize", status)?;
        let mut bytes = vec![0; size];
        // SAFETY: living component, its own state, an array of the stated length.
        let status = unsafe { serialize(self.component.as_ptr(), saved.state, bytes.as_mut_ptr(), size) };
        self.check("fmi2SerializeFMUstate", status)?;
        Ok(bytes)
    }

    /// `fmi2DeSerializeFMUstate`: a saved state from bytes.
    ///
    /// # Errors
    /// When the slave cannot.
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<SavedState> {
        let function = self.optional("fmi2DeSerializeFMUstate", self.functions().deserialize_fmu_state)?;
        let mut state = ptr::null_mut();
        // SAFETY: living component, an array of the stated length.
        let status = unsafe { function(self.component.as_ptr(), bytes.as_ptr(), bytes.len(), &raw mut state) };
        self.check("fmi2DeSerializeFMUstate", status)?;
        Ok(SavedState { state, owner: self.component })
    }

    /// `fmi2GetDirectionalDerivative`: d`unknowns` = (∂unknowns/∂knowns) · `seed`.
    ///
    /// # Errors
    /// When the slave cannot.
    ///
    /// # Panics
    /// When matching slices differ in length.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[ValueReference],
        knowns: &[ValueReference],
        seed: &[f64],
        derivative: &mut [f64],
    ) -> Result<Status> {
        assert_eq!((unknowns.len(), knowns.len()), (derivative.len(), seed.len()));
        let function = self.optional("fmi2GetDirectionalDerivative", self.functions().get_directional_derivative)?;
        // SAFETY: living component, arrays of the stated lengths.
        let status = unsafe {
            function(
                self.component.as_ptr(),
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                derivative.as_mut_ptr(),
            )
        };
        self.check("fmi2GetDirectionalDerivative", status)
    }

    /// `fmi2SetRealInputDerivatives`: how inputs go on during the next step.
    ///
    /// # Errors
    /// When the slave cannot.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn set_input_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[i32],
        values: &[f64],
    ) -> Result<Status> {
        assert_eq!((references.len(), references.len()), (orders.len(), values.len()));
        let function = self.optional("fmi2SetRealInputDerivatives", self.functions().set_real_input_derivatives)?;
        // SAFETY: living component, arrays of the stated length.
        let status = unsafe {
            function(self.component.as_ptr(), references.as_ptr(), references.len(), orders.as_ptr(), values.as_ptr())
        };
        self.check("fmi2SetRealInputDerivatives", status)
    }

    /// `fmi2GetRealOutputDerivatives`: how outputs change at the end of the last step.
    ///
    /// # Errors
    /// When the slave cannot.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn output_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<Status> {
        assert_eq!((references.len(), references.len()), (orders.len(), values.len()));
        let function = self.optional("fmi2GetRealOutputDerivatives", self.functions().get_real_output_derivatives)?;
        // SAFETY: living component, arrays of the stated length.
        let status = unsafe {
            function(
                self.component.as_ptr(),
                references.as_ptr(),
                references.len(),
                orders.as_ptr(),
                values.as_mut_ptr(),
            )
        };
        self.check("fmi2GetRealOutputDerivatives", status)
    }

    /// After a discarded step: whether the slave wants the simulation to end.
    pub fn wants_to_end(&mut self) -> bool {
        let mut value = 0;
        // SAFETY: living component.
        self.functions().get_boolean_status.is_some_and(|function| unsafe {
            function(self.component.as_ptr(), TERMINATED, &raw mut value) == 0 && value != 0
        })
    }

    /// After a discarded step: the time up to which the slave got.
    pub fn last_successful_time(&mut self) -> Option<f64> {
        let mut value = 0.0;
        let function = self.functions().get_real_status?;
        // SAFETY: living component.
        let status = unsafe { function(self.component.as_ptr(), LAST_SUCCESSFUL_TIME, &raw mut value) };
        (status == 0).then_some(value)
    }

    #[inline]
    fn functions(&self) -> &Functions {
        &self.loaded.functions
    }

    fn optional<F>(&self, name: &'static str, function: Option<F>) -> Result<F> {
        function.ok_or_else(|| CallError::Unsupported { instance: self.name.clone(), function: name })
    }

    fn own(&self, saved: &SavedState) -> Result<()> {
        if saved.owner == self.component {
            Ok(())
        } else {
            Err(CallError::ForeignState { instance: self.name.clone() })
        }
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
        unsafe {
            if self.phase == Phase::Running {
                (self.functions().terminate)(self.component.as_ptr());
            }
            if self.phase != Phase::Lost {
                (self.functions().free_instance)(self.component.as_ptr());
            }
        }
    }
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance").field("name", &self.name).field("phase", &self.phase).finish_non_exhaustive()
    }
}

/// The complaints of a slave since the log was last read, as the end of an error message.
fn messages_of(log: &Log, description: &ModelDescription) -> String {
    const SHOWN: usize = 5;
    let messages: Vec<_> = log.messages().drain(..).collect();
    let complaints: Vec<_> = messages.iter().filter(|message| message.status > Status::Warning).collect();
    // Some slaves log the reason with status OK.
    let relevant = if complaints.is_empty() { messages.iter().collect() } else { complaints };
    let mut texts: Vec<String> = Vec::new();
    for message in relevant.iter().rev().take(SHOWN).rev() {
        let text = with_names(message.text.trim(), description);
        if !text.is_empty() && !texts.contains(&text) {
            texts.push(text);
        }
    }
    if texts.is_empty() { " (it gives no reason)".into() } else { format!(": {}", texts.join("; ")) }
}

/// Replaces `#r12#` by the name of the real with value reference 12, and `##` by `#` (section 2.1.5 of the standard).
fn with_names(message: &str, description: &ModelDescription) -> String {
    let mut result = String::with_capacity(message.len());
    let mut rest = message;
    while let Some(at) = rest.find('#') {
        result.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix('#') {
            result.push('#');
            rest = after;
        } else if let Some((name, after)) = referenced(rest, description) {
            result.push_str(name);
            rest = after;
        } else {
            result.push('#');
        }
    }
    result.push_str(rest);
    result
}

fn referenced<'a, 'b>(text: &'a str, description: &'b ModelDescription) -> Option<(&'b str, &'a str)> {
    let (inside, after) = text.split_once('#')?;
    let base: &[BaseType] = match inside.chars().next()? {
        'r' => &[BaseType::Real],
        'i' => &[BaseType::Integer, BaseType::Enumeration],
        'b' => &[BaseType::Boolean],
        's' => &[BaseType::String],
        _ => return None,
    };
    let reference: ValueReference = inside[1..].parse().ok()?;
    let variable = description
        .variables
        .iter()
        .find(|variable| variable.value_reference == reference && base.contains(&variable.base_type()))?;
    Some((&variable.name, after))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_references_in_messages_become_names() {
        let description = ModelDescription::parse(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><ModelVariables>
            <ScalarVariable name="x" valueReference="3"><Integer/></ScalarVariable>
            <ScalarVariable name="EI1" valueReference="3"><Real/></ScalarVariable>
            </ModelVariables></fmiModelDescription>"#,
        )
        .unwrap();
        let named = with_names("#r3# must be > 0 (#i3#, ##1, #r9#, 100 #)", &description);
        assert_eq!(named, "EI1 must be > 0 (x, #1, #r9#, 100 #)");
    }
}
