//! The C interface of an FMI 2.0 co-simulation library: types, status codes and the table of its functions.
//!
//! Names follow `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::fmt;
use std::path::Path;

use libloading::Library;

use crate::floating_point::guarded;

/// `fmi2Component`: the slave's own handle of an instance.
pub type Component = *mut c_void;
/// `fmi2FMUstate`: the slave's own handle of a saved state.
pub type FmuState = *mut c_void;
/// `fmi2ValueReference`: a variable's handle.
pub type ValueReference = u32;
/// `fmi2Boolean`: 0 is false, everything else true.
pub type Boolean = c_int;

/// `fmi2Status`: how a call went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// All is well.
    Ok,
    /// Something is odd; the simulation can go on.
    Warning,
    /// The call (a step, or a value) was refused; the instance is unchanged.
    Discard,
    /// The instance cannot continue.
    Error,
    /// Every instance of this FMU is lost.
    Fatal,
    /// The step is still being computed.
    Pending,
}

impl Status {
    /// From the C value. Values outside the standard count as `Fatal`, because the state of the instance is unknown.
    #[must_use]
    pub fn from_c(value: c_int) -> Self {
        match value {
            0 => Self::Ok,
            1 => Self::Warning,
            2 => Self::Discard,
            3 => Self::Error,
            5 => Self::Pending,
            _ => Self::Fatal,
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fmi2{self:?}")
    }
}

/// `fmi2CallbackFunctions`. The logger is variadic; its C half formats the message.
#[repr(C)]
pub struct CallbackFunctions {
    /// Receives messages.
    pub logger: unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...),
    /// `calloc`.
    pub allocate_memory: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    /// `free`.
    pub free_memory: unsafe extern "C" fn(*mut c_void),
    /// Called after an asynchronous step; this importer has none.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// Handed back to the logger.
    pub component_environment: *mut c_void,
}

/// Why a library cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LibraryError {
    /// The system's loader refuses it.
    #[error("the system cannot load it: {0}")]
    Load(String),
    /// It is empty.
    #[error("it is empty")]
    Empty,
    /// It is not a library.
    #[error("it is not a shared library")]
    NoLibrary,
    /// It was made for another machine.
    #[error("it is for {found}, and this is {wanted}")]
    Foreign {
        /// The machine it is for.
        found: String,
        /// The machine that is needed here.
        wanted: String,
    },
    /// The file ends earlier than its headers say. The system's loader would still map it, and the process
    /// would die at the first access beyond the end.
    #[error("it is cut off: {length} of at least {promised} bytes are there")]
    CutOff {
        /// The length of the file.
        length: u64,
        /// The length according to its headers.
        promised: u64,
    },
    /// A function every co-simulation FMU must have is absent.
    #[error("it lacks the function {0}, which every FMI 2.0 co-simulation FMU must have")]
    MissingSymbol(&'static str),
    /// It was compiled for other C types or another version of FMI.
    #[error("{function} returns \"{found}\" instead of \"{expected}\"")]
    Incompatible {
        /// The inquiry function.
        function: &'static str,
        /// Its return value.
        found: String,
        /// The return value of an FMI 2.0 library.
        expected: &'static str,
    },
}

/// The message of the system: libloading's own message is only "dlopen failed".
fn root_cause(error: &dyn std::error::Error) -> String {
    std::iter::successors(Some(error), |error| error.source()).last().unwrap_or(error).to_string()
}

macro_rules! functions {
    (
        required { $($name:ident: $symbol:literal ($($argument:ty),*) -> $result:ty;)* }
        optional { $($option:ident: $option_symbol:literal ($($option_argument:ty),*) -> $option_result:ty;)* }
    ) => {
        /// The functions of a loaded library. Functions that this importer does not need are optional, although the
        /// standard demands them of every FMU.
        pub struct Functions {
            $(#[doc = concat!("`", $symbol, "`")]
            pub $name: unsafe extern "C" fn($($argument),*) -> $result,)*
            $(#[doc = concat!("`", $option_symbol, "`")]
            pub $option: Option<unsafe extern "C" fn($($option_argument),*) -> $option_result>,)*
            _library: Library,
        }

        /// The functions that every co-simulation FMU must have.
        pub(crate) const REQUIRED: &[&str] = &[$($symbol),*];

        impl Functions {
            fn of(library: Library) -> Result<Self, LibraryError> {
                // SAFETY: the standard fixes the signature of each symbol; the pointers live as long as the library,
                // which moves into the same value.
                unsafe {
                    Ok(Self {
                        $($name: *library
                            .get($symbol)
                            .map_err(|_| LibraryError::MissingSymbol($symbol))?,)*
                        $($option: library.get($option_symbol).ok().map(|symbol| *symbol),)*
                        _library: library,
                    })
                }
            }
        }
    };
}

functions! {
    required {
        get_types_platform: "fmi2GetTypesPlatform" () -> *const c_char;
        get_version: "fmi2GetVersion" () -> *const c_char;
        set_debug_logging: "fmi2SetDebugLogging" (Component, Boolean, usize, *const *const c_char) -> c_int;
        instantiate: "fmi2Instantiate" (*const c_char, c_int, *const c_char, *const c_char, *const CallbackFunctions, Boolean, Boolean) -> Component;
        free_instance: "fmi2FreeInstance" (Component) -> ();
        setup_experiment: "fmi2SetupExperiment" (Component, Boolean, f64, f64, Boolean, f64) -> c_int;
        enter_initialization_mode: "fmi2EnterInitializationMode" (Component) -> c_int;
        exit_initialization_mode: "fmi2ExitInitializationMode" (Component) -> c_int;
        terminate: "fmi2Terminate" (Component) -> c_int;
        reset: "fmi2Reset" (Component) -> c_int;
        get_real: "fmi2GetReal" (Component, *const ValueReference, usize, *mut f64) -> c_int;
        get_integer: "fmi2GetInteger" (Component, *const ValueReference, usize, *mut c_int) -> c_int;
        get_boolean: "fmi2GetBoolean" (Component, *const ValueReference, usize, *mut Boolean) -> c_int;
        get_string: "fmi2GetString" (Component, *const ValueReference, usize, *mut *const c_char) -> c_int;
        set_real: "fmi2SetReal" (Component, *const ValueReference, usize, *const f64) -> c_int;
        set_integer: "fmi2SetInteger" (Component, *const ValueReference, usize, *const c_int) -> c_int;
        set_boolean: "fmi2SetBoolean" (Component, *const ValueReference, usize, *const Boolean) -> c_int;
        set_string: "fmi2SetString" (Component, *const ValueReference, usize, *const *const c_char) -> c_int;
        do_step: "fmi2DoStep" (Component, f64, f64, Boolean) -> c_int;
    }
    optional {
        get_fmu_state: "fmi2GetFMUstate" (Component, *mut FmuState) -> c_int;
        set_fmu_state: "fmi2SetFMUstate" (Component, FmuState) -> c_int;
        free_fmu_state: "fmi2FreeFMUstate" (Component, *mut FmuState) -> c_int;
        serialized_fmu_state_size: "fmi2SerializedFMUstateSize" (Component, FmuState, *mut usize) -> c_int;
        serialize_fmu_state: "fmi2SerializeFMUstate" (Component, FmuState, *mut u8, usize) -> c_int;
        deserialize_fmu_state: "fmi2DeSerializeFMUstate" (Component, *const u8, usize, *mut FmuState) -> c_int;
        get_directional_derivative: "fmi2GetDirectionalDerivative" (Component, *const ValueReference, usize, *const ValueReference, usize, *const f64, *mut f64) -> c_int;
        set_real_input_derivatives: "fmi2SetRealInputDerivatives" (Component, *const ValueReference, usize, *const c_int, *const f64) -> c_int;
        get_real_output_derivatives: "fmi2GetRealOutputDerivatives" (Component, *const ValueReference, usize, *const c_int, *mut f64) -> c_int;
        get_status: "fmi2GetStatus" (Component, c_int, *mut c_int) -> c_int;
        get_real_status: "fmi2GetRealStatus" (Component, c_int, *mut f64) -> c_int;
        get_boolean_status: "fmi2GetBooleanStatus" (Component, c_int, *mut Boolean) -> c_int;
    }
}

/// `fmi2DoStepStatus`, a kind of status for [`Functions::get_status`].
pub const DO_STEP_STATUS: c_int = 0;
/// `fmi2LastSuccessfulTime`, a kind of status for [`Functions::get_real_status`].
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2Terminated`, a kind of status for [`Functions::get_boolean_status`].
pub const TERMINATED: c_int = 3;

impl Functions {
    /// Loads a library and looks up its functions.
    ///
    /// # Errors
    /// When the system cannot load it, a required function is missing, or it was built for another version of FMI. A
    /// truncated file can kill the process: [`Fmu::unpack`](crate::Fmu::unpack) checks it first.
    pub fn load(path: &Path) -> Result<Self, LibraryError> {
        let functions = Self::of(guarded(|| open(path))?)?;
        // SAFETY: both functions take nothing and return a static C string.
        let inquire = |function: unsafe extern "C" fn() -> *const c_char| guarded(|| unsafe { text(function()) });
        let expect = |function, found: String, expected: &'static str, fits: bool| {
            if fits { Ok(()) } else { Err(LibraryError::Incompatible { function, found, expected }) }
        };
        let platform = inquire(functions.get_types_platform);
        let fits = platform == "default";
        expect("fmi2GetTypesPlatform", platform, "default", fits)?;
        let version = inquire(functions.get_version);
        let fits = version.starts_with("2.0");
        expect("fmi2GetVersion", version, "2.0", fits)?;
        Ok(functions)
    }
}

/// Resolves every symbol at once: a library that lacks a dependency fails here, not in the middle of a simulation.
#[cfg(unix)]
fn open(path: &Path) -> Result<Library, LibraryError> {
    use libloading::os::unix::{Library as UnixLibrary, RTLD_LOCAL, RTLD_NOW};
    // SAFETY: loading runs the library's initialisers; the user asked for this FMU to be run.
    unsafe { UnixLibrary::open(Some(path), RTLD_NOW | RTLD_LOCAL) }
        .map(Into::into)
        .map_err(|error| LibraryError::Load(root_cause(&error)))
}

/// Looks for the library's dependencies in its own folder.
#[cfg(windows)]
fn open(path: &Path) -> Result<Library, LibraryError> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library as WindowsLibrary};
    // The loader accepts paths of 260 characters and more only in their canonical form. Short paths are passed unchanged,
    // because libraries that look for their own folder may not understand that form.
    let canonical = (path.as_os_str().len() >= 260).then(|| path.canonicalize().ok()).flatten();
    let path = canonical.as_deref().unwrap_or(path);
    // SAFETY: loading runs the library's initialisers; the user asked for this FMU to be run.
    unsafe { WindowsLibrary::load_with_flags(path, LOAD_WITH_ALTERED_SEARCH_PATH) }
        .map(Into::into)
        .map_err(|error| LibraryError::Load(root_cause(&error)))
}

/// A C string of the library as text.
///
/// # Safety
/// `pointer` is null or a C string.
pub(super) unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: as the caller promises.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}
