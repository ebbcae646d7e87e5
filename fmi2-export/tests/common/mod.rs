//! A C client of the example libraries: loads them as a host does and calls the C functions by their symbols.
#![allow(dead_code)] // Each test binary uses a part.
#![allow(clippy::too_many_arguments)] // As the standard has it.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::{Arc, Mutex, OnceLock};

use libloading::Library;

pub mod misbehaving;
pub mod real;

pub const OK: c_int = 0;
pub const WARNING: c_int = 1;
pub const DISCARD: c_int = 2;
pub const ERROR: c_int = 3;

/// Path of an example's library. `cargo test` builds the examples before it runs the tests; `cargo test --test NAME` does
/// not, so `cargo build --release --examples` has to come first then.
pub fn example(name: &str) -> PathBuf {
    let exe = std::env::current_exe().unwrap();
    let file = format!("{}{name}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    exe.parent().unwrap().parent().unwrap().join("examples").join(file)
}

pub type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

#[repr(C)]
pub struct Callbacks {
    pub logger: Option<Logger>,
    pub allocate_memory: *const c_void,
    pub free_memory: *const c_void,
    pub step_finished: *const c_void,
    pub environment: *mut c_void,
}

/// What the logger was told: status, category, message.
pub type Log = Arc<Mutex<Vec<(c_int, String, String)>>>;

/// Variadic functions cannot be defined in Rust; the callee may ignore the variadic part, and none is passed.
unsafe extern "C" fn record(
    environment: *mut c_void,
    _instance: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the log that `Callbacks` was made with, which outlives the instance.
    let log = unsafe { &*environment.cast::<Mutex<Vec<(c_int, String, String)>>>() };
    // SAFETY: both are C strings of the caller.
    let text = |s: *const c_char| unsafe { CStr::from_ptr(s) }.to_str().unwrap().to_owned();
    log.lock().unwrap().push((status, text(category), text(message)));
}

pub struct Fmu {
    pub library: Library,
    functions: Functions,
}

macro_rules! functions {
    ($($name:ident($($arg:ident: $type:ty),*) -> $result:ty;)*) => {
        /// Each function, once it has been called: to look for its name at each call would take longer than most calls,
        /// under valgrind above all.
        #[allow(non_snake_case)]
        #[derive(Default)]
        struct Functions { $(
            $name: OnceLock<unsafe extern "C" fn($($type),*) -> $result>,
        )* }

        #[allow(non_snake_case)]
        impl Fmu { $(
            pub fn $name(&self, $($arg: $type),*) -> $result {
                // SAFETY: the function has this type in FMI 2.0, and `self` keeps the library loaded.
                let function = self.functions.$name.get_or_init(|| unsafe {
                    *self.library.get(stringify!($name)).unwrap()
                });
                // SAFETY: the tests keep the function's rules or break them on purpose.
                unsafe { function($($arg),*) }
            }
        )* }
    };
}

type C = *mut c_void;

functions! {
    fmi2GetTypesPlatform() -> *const c_char;
    fmi2GetVersion() -> *const c_char;
    fmi2Instantiate(name: *const c_char, kind: c_int, guid: *const c_char, resources: *const c_char, callbacks: *const Callbacks, visible: c_int, logging: c_int) -> C;
    fmi2FreeInstance(c: C) -> ();
    fmi2SetDebugLogging(c: C, on: c_int, n: usize, categories: *const *const c_char) -> c_int;
    fmi2SetupExperiment(c: C, tolerance_defined: c_int, tolerance: f64, start: f64, stop_defined: c_int, stop: f64) -> c_int;
    fmi2EnterInitializationMode(c: C) -> c_int;
    fmi2ExitInitializationMode(c: C) -> c_int;
    fmi2Terminate(c: C) -> c_int;
    fmi2Reset(c: C) -> c_int;
    fmi2GetReal(c: C, vr: *const u32, n: usize, value: *mut f64) -> c_int;
    fmi2GetInteger(c: C, vr: *const u32, n: usize, value: *mut c_int) -> c_int;
    fmi2GetBoolean(c: C, vr: *const u32, n: usize, value: *mut c_int) -> c_int;
    fmi2GetString(c: C, vr: *const u32, n: usize, value: *mut *const c_char) -> c_int;
    fmi2SetReal(c: C, vr: *const u32, n: usize, value: *const f64) -> c_int;
    fmi2SetInteger(c: C, vr: *const u32, n: usize, value: *const c_int) -> c_int;
    fmi2SetBoolean(c: C, vr: *const u32, n: usize, value: *const c_int) -> c_int;
    fmi2SetString(c: C, vr: *const u32, n: usize, value: *const *const c_char) -> c_int;
    fmi2GetFMUstate(c: C, state: *mut C) -> c_int;
    fmi2SetFMUstate(c: C, state: C) -> c_int;
    fmi2FreeFMUstate(c: C, state: *mut C) -> c_int;
    fmi2SerializedFMUstateSize(c: C, state: C, size: *mut usize) -> c_int;
    fmi2SerializeFMUstate(c: C, state: C, bytes: *mut u8, size: usize) -> c_int;
    fmi2DeSerializeFMUstate(c: C, bytes: *const u8, size: usize, state: *mut C) -> c_int;
    fmi2GetDirectionalDerivative(c: C, unknowns: *const u32, nu: usize, knowns: *const u32, nk: usize, seed: *const f64, value: *mut f64) -> c_int;
    fmi2SetRealInputDerivatives(c: C, vr: *const u32, n: usize, order: *const c_int, value: *const f64) -> c_int;
    fmi2GetRealOutputDerivatives(c: C, vr: *const u32, n: usize, order: *const c_int, value: *mut f64) -> c_int;
    fmi2DoStep(c: C, time: f64, size: f64, no_set_state_before: c_int) -> c_int;
    fmi2CancelStep(c: C) -> c_int;
    fmi2GetStatus(c: C, kind: c_int, value: *mut c_int) -> c_int;
    fmi2GetRealStatus(c: C, kind: c_int, value: *mut f64) -> c_int;
    fmi2GetIntegerStatus(c: C, kind: c_int, value: *mut c_int) -> c_int;
    fmi2GetBooleanStatus(c: C, kind: c_int, value: *mut c_int) -> c_int;
    fmi2GetStringStatus(c: C, kind: c_int, value: *mut *const c_char) -> c_int;
    fmi2EnterEventMode(c: C) -> c_int;
    fmi2NewDiscreteStates(c: C, info: *mut EventInfo) -> c_int;
    fmi2EnterContinuousTimeMode(c: C) -> c_int;
    fmi2CompletedIntegratorStep(c: C, no_set_state_before: c_int, enter_event_mode: *mut c_int, terminate: *mut c_int) -> c_int;
    fmi2SetTime(c: C, time: f64) -> c_int;
    fmi2SetContinuousStates(c: C, x: *const f64, n: usize) -> c_int;
    fmi2GetDerivatives(c: C, derivatives: *mut f64, n: usize) -> c_int;
    fmi2GetEventIndicators(c: C, indicators: *mut f64, n: usize) -> c_int;
    fmi2GetContinuousStates(c: C, x: *mut f64, n: usize) -> c_int;
    fmi2GetNominalsOfContinuousStates(c: C, x: *mut f64, n: usize) -> c_int;
}

/// `fmi2Type`.
pub const MODEL_EXCHANGE: c_int = 0;
pub const CO_SIMULATION: c_int = 1;

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EventInfo {
    pub again: c_int,
    pub terminate: c_int,
    pub nominals_changed: c_int,
    pub states_changed: c_int,
    pub has_next_time: c_int,
    pub next_time: f64,
}

impl Fmu {
    pub fn load(name: &str) -> Self {
        Self::open(&example(name))
    }

    pub fn open(path: &Path) -> Self {
        // SAFETY: our own library.
        let library = unsafe { Library::new(path) };
        let library = library.unwrap_or_else(|e| panic!("{}: {e}; see `example`", path.display()));
        Self { library, functions: Functions::default() }
    }

    /// The GUIDs of all models in the library, which it tells when it is asked for another one.
    pub fn guids(&self) -> Vec<String> {
        let log = Log::default();
        let component = self.fmi2Instantiate(c"x".as_ptr(), 1, c"".as_ptr(), null(), &callbacks(&log), 0, 0);
        assert!(component.is_null());
        let message = log.lock().unwrap()[0].2.clone();
        message.split('{').skip(1).map(|part| format!("{{{}}}", part.split('}').next().unwrap())).collect()
    }

    /// An instance with a logger that writes into the returned log.
    pub fn instantiate(&self, guid: &str) -> Slave<'_> {
        self.instantiate_as(CO_SIMULATION, guid).unwrap_or_else(|log| panic!("{log:?}"))
    }

    /// As [`instantiate`](Self::instantiate), for an interface that the model may not have; what it says then.
    pub fn instantiate_as(&self, kind: c_int, guid: &str) -> Result<Slave<'_>, Log> {
        let log = Log::default();
        let callbacks = callbacks(&log);
        let guid = CString::new(guid).unwrap();
        let component = self.fmi2Instantiate(c"test".as_ptr(), kind, guid.as_ptr(), null(), &raw const callbacks, 0, 1);
        if component.is_null() { Err(log) } else { Ok(Slave { fmu: self, component, log }) }
    }
}

pub fn callbacks(log: &Log) -> Callbacks {
    // SAFETY: a variadic callee that reads no variadic arguments may be a function with the fixed ones on all platforms
    // whose C calling convention passes the fixed arguments alike, which those that FMI knows do.
    let logger = unsafe { std::mem::transmute::<*const (), Logger>(record as *const ()) };
    Callbacks {
        logger: Some(logger),
        allocate_memory: null(),
        free_memory: null(),
        step_finished: null(),
        environment: Arc::as_ptr(log).cast_mut().cast(),
    }
}

/// An instance, freed at the end.
pub struct Slave<'f> {
    pub fmu: &'f Fmu,
    pub component: *mut c_void,
    pub log: Log,
}

impl Drop for Slave<'_> {
    fn drop(&mut self) {
        self.fmu.fmi2FreeInstance(self.component);
    }
}

impl Slave<'_> {
    pub fn initialize(&self) {
        assert_eq!(self.fmu.fmi2SetupExperiment(self.component, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(self.fmu.fmi2EnterInitializationMode(self.component), OK);
        assert_eq!(self.fmu.fmi2ExitInitializationMode(self.component), OK, "{:?}", self.log);
    }

    pub fn get(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(self.fmu.fmi2GetReal(self.component, &raw const reference, 1, &raw mut value), OK, "{:?}", self.log);
        value
    }

    pub fn set(&self, reference: u32, value: f64) -> c_int {
        self.fmu.fmi2SetReal(self.component, &raw const reference, 1, &raw const value)
    }

    pub fn step(&self, time: f64, size: f64) -> c_int {
        self.fmu.fmi2DoStep(self.component, time, size, 1)
    }

    /// Of an instance for model exchange: initializes and updates the discrete states, into continuous-time mode.
    pub fn start(&self) {
        self.initialize();
        self.update();
    }

    /// From event mode into continuous-time mode; what the last update said.
    pub fn update(&self) -> EventInfo {
        let mut info = EventInfo { again: 1, ..EventInfo::default() };
        while info.again != 0 {
            assert_eq!(self.fmu.fmi2NewDiscreteStates(self.component, &raw mut info), OK, "{:?}", self.log);
        }
        assert_eq!(self.fmu.fmi2EnterContinuousTimeMode(self.component), OK);
        info
    }

    pub fn set_time(&self, time: f64) -> c_int {
        self.fmu.fmi2SetTime(self.component, time)
    }

    pub fn set_states(&self, x: &[f64]) -> c_int {
        self.fmu.fmi2SetContinuousStates(self.component, x.as_ptr(), x.len())
    }

    pub fn states(&self, count: usize) -> Vec<f64> {
        let mut x = vec![f64::NAN; count];
        assert_eq!(self.fmu.fmi2GetContinuousStates(self.component, x.as_mut_ptr(), count), OK, "{:?}", self.log);
        x
    }

    pub fn derivatives(&self, count: usize) -> Vec<f64> {
        let mut x = vec![f64::NAN; count];
        assert_eq!(self.fmu.fmi2GetDerivatives(self.component, x.as_mut_ptr(), count), OK, "{:?}", self.log);
        x
    }

    pub fn indicators(&self, count: usize) -> Vec<f64> {
        let mut z = vec![f64::NAN; count];
        assert_eq!(self.fmu.fmi2GetEventIndicators(self.component, z.as_mut_ptr(), count), OK, "{:?}", self.log);
        z
    }

    /// The last message logged.
    pub fn message(&self) -> String {
        self.log.lock().unwrap().last().map(|(_, _, message)| message.clone()).unwrap_or_default()
    }

    /// Resets, initializes and steps.
    pub fn start_again(&self) {
        assert_eq!(self.fmu.fmi2Reset(self.component), OK);
        self.initialize();
        assert_eq!(self.step(0.0, 0.1), OK, "{:?}", self.log);
    }

    /// The serialised state.
    pub fn blob(&self) -> Vec<u8> {
        let mut state = self.save();
        let bytes = self.serialize(state);
        assert_eq!(self.fmu.fmi2FreeFMUstate(self.component, &raw mut state), OK);
        bytes
    }

    /// Reads a blob and makes it the instance's state; the status of the first call that fails.
    pub fn load(&self, bytes: &[u8]) -> c_int {
        let mut state = null_mut();
        let status = self.fmu.fmi2DeSerializeFMUstate(self.component, bytes.as_ptr(), bytes.len(), &raw mut state);
        if status != OK {
            assert!(state.is_null());
            return status;
        }
        let status = self.fmu.fmi2SetFMUstate(self.component, state);
        assert_eq!(self.fmu.fmi2FreeFMUstate(self.component, &raw mut state), OK);
        status
    }

    pub fn set_integer(&self, reference: u32, value: c_int) -> c_int {
        self.fmu.fmi2SetInteger(self.component, &raw const reference, 1, &raw const value)
    }

    pub fn messages(&self) -> Vec<(c_int, String, String)> {
        self.log.lock().unwrap().clone()
    }

    pub fn save(&self) -> *mut c_void {
        let mut state = null_mut();
        assert_eq!(self.fmu.fmi2GetFMUstate(self.component, &raw mut state), OK);
        state
    }

    pub fn serialize(&self, state: *mut c_void) -> Vec<u8> {
        let mut size = 0;
        assert_eq!(self.fmu.fmi2SerializedFMUstateSize(self.component, state, &raw mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!(self.fmu.fmi2SerializeFMUstate(self.component, state, bytes.as_mut_ptr(), size), OK);
        bytes
    }
}

/// Sizes of steps from 5e-324 s to 2 s, up and down.
pub fn sizes_of_all_magnitudes() -> impl Iterator<Item = f64> {
    (0..60).map(|i| match i {
        0 => 5e-324,
        1 => 1e-300,
        i => f64::powi(2.0, -(i * 7 % 40) + 1),
    })
}
