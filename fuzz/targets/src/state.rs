//! Tampered saved states, passed through the C interface like those of a host.

use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::OnceLock;

use fmi2_export::{Declare, Experiment, Failure, Info, Model, Step, Variables};
use serde::{Deserialize, Serialize};

/// A state with all parts of serialised states: numbers, text, choices, and varying lengths.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Lags {
    u: f64,
    y: f64,
    count: i32,
    is_on: bool,
    label: String,
    mode: Option<u16>,
    states: Vec<f64>,
}

impl Declare for Lags {
    const INFO: Info = Info { name: "Lags", description: "Lags in series", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|m| m.y = m.states.iter().sum());
        variables.input("u", |m| &mut m.u).description("Input");
        variables.output("y", outputs, |m| &mut m.y).description("Sum of the lags");
        variables.parameter("count", |m| &mut m.count).tunable().range(0.0, 9.0).description("A number");
        variables.parameter("is_on", |m| &mut m.is_on).tunable().description("A choice");
        variables.parameter("label", |m| &mut m.label).tunable().description("Words");
    }
}

impl Model for Lags {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        self.states = vec![1.0, 2.0];
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        let mut input = self.u;
        for state in &mut self.states {
            *state += step.size * (input - *state);
            input = *state;
        }
        Ok(())
    }
}

fmi2_export::export!(Lags);

type C = *mut c_void;
type State = *mut c_void;

/// `fmi2CallbackFunctions`.
#[repr(C)]
struct Callbacks {
    logger: *const c_void,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

/// The same functions as a host declares them.
mod host {
    use super::{C, Callbacks, State, c_char, c_int};

    #[allow(clashing_extern_declarations)]
    unsafe extern "C" {
        pub fn fmi2Instantiate(
            name: *const c_char,
            kind: c_int,
            guid: *const c_char,
            resources: *const c_char,
            callbacks: *const Callbacks,
            visible: c_int,
            logging: c_int,
        ) -> C;
        pub fn fmi2FreeInstance(c: C);
        pub fn fmi2SetupExperiment(c: C, tolerant: c_int, tolerance: f64, start: f64, ends: c_int, stop: f64) -> c_int;
        pub fn fmi2EnterInitializationMode(c: C) -> c_int;
        pub fn fmi2ExitInitializationMode(c: C) -> c_int;
        pub fn fmi2DoStep(c: C, time: f64, size: f64, no_set_state_before: c_int) -> c_int;
        pub fn fmi2GetReal(c: C, vr: *const u32, n: usize, values: *mut f64) -> c_int;
        pub fn fmi2GetFMUstate(c: C, state: *mut State) -> c_int;
        pub fn fmi2SetFMUstate(c: C, state: State) -> c_int;
        pub fn fmi2FreeFMUstate(c: C, state: *mut State) -> c_int;
        pub fn fmi2SerializedFMUstateSize(c: C, state: State, size: *mut usize) -> c_int;
        pub fn fmi2SerializeFMUstate(c: C, state: State, bytes: *mut c_char, size: usize) -> c_int;
        pub fn fmi2DeSerializeFMUstate(c: C, bytes: *const c_char, size: usize, state: *mut State) -> c_int;
    }
}

const OK: c_int = 0;
const ERROR: c_int = 3;
/// Bytes before the model's state: format, GUID, length.
const HEADER: usize = 58;
/// Bytes after it.
const CHECKSUM: usize = 4;

/// An initialised instance; the caller has to free it.
fn instance() -> C {
    static GUID: OnceLock<CString> = OnceLock::new();
    let guid = GUID.get_or_init(|| CString::new(FMUS.models()[0].description().expect("declared").guid).expect("text"));
    let callbacks = Callbacks {
        logger: null(),
        allocate_memory: null(),
        free_memory: null(),
        step_finished: null(),
        environment: null_mut(),
    };
    // SAFETY: strings and callbacks live during the calls, and the instance is used by one thread.
    unsafe {
        let c = host::fmi2Instantiate(c"fuzz".as_ptr(), 1, guid.as_ptr(), null(), &raw const callbacks, 0, 0);
        assert!(!c.is_null());
        assert_eq!(host::fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(host::fmi2EnterInitializationMode(c), OK);
        assert_eq!(host::fmi2ExitInitializationMode(c), OK);
        c
    }
}

/// The serialised state of a new instance.
#[must_use]
pub fn blob() -> Vec<u8> {
    let c = instance();
    let (mut state, mut size) = (null_mut(), 0);
    // SAFETY: `c` is an instance, `state` one of its states, and `bytes` has `size` bytes.
    unsafe {
        assert_eq!(host::fmi2GetFMUstate(c, &raw mut state), OK);
        assert_eq!(host::fmi2SerializedFMUstateSize(c, state, &raw mut size), OK);
        let mut bytes = vec![0u8; size];
        assert_eq!(host::fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr().cast(), size), OK);
        assert_eq!(host::fmi2FreeFMUstate(c, &raw mut state), OK);
        host::fmi2FreeInstance(c);
        bytes
    }
}

/// Passes a state whose model part is `data`, with a correct header and checksum, and the bytes unchanged. Each is either
/// refused, or makes an instance that works.
pub fn state(data: &[u8]) {
    static REAL: OnceLock<Vec<u8>> = OnceLock::new();
    let real = REAL.get_or_init(blob);
    let mut sealed = real[..HEADER - 8].to_vec();
    sealed.extend_from_slice(&(data.len() as u64).to_le_bytes());
    sealed.extend_from_slice(data);
    let checksum = crc32fast::hash(&sealed);
    sealed.extend_from_slice(&checksum.to_le_bytes());
    hand_over(&sealed);
    hand_over(data);
}

/// The model's part of a serialised state: a seed.
#[must_use]
pub fn payload(blob: &[u8]) -> &[u8] {
    &blob[HEADER..blob.len() - CHECKSUM]
}

/// Loads a state; if it is accepted, the instance continues.
fn hand_over(bytes: &[u8]) -> bool {
    let c = instance();
    let mut state = null_mut();
    // SAFETY: `c` is an instance, `bytes` are that many, and `state` is used only if there is one.
    unsafe {
        let status = host::fmi2DeSerializeFMUstate(c, bytes.as_ptr().cast(), bytes.len(), &raw mut state);
        let accepted = status == OK && host::fmi2SetFMUstate(c, state) == OK;
        if accepted {
            let (reference, mut value) = (1, 0.0);
            let status = host::fmi2DoStep(c, 0.0, 1e-3, 1);
            assert!((OK..=ERROR).contains(&status), "fmi2DoStep: {status}");
            let status = host::fmi2GetReal(c, &raw const reference, 1, &raw mut value);
            assert!((OK..=ERROR).contains(&status), "fmi2GetReal: {status}");
        }
        if !state.is_null() {
            assert_eq!(host::fmi2FreeFMUstate(c, &raw mut state), OK);
        }
        host::fmi2FreeInstance(c);
        accepted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The header has the length that this file assumes: a state that this file reassembles is accepted.
    #[test]
    fn a_state_that_is_put_together_again_is_accepted() {
        let real = blob();
        let mut sealed = real[..HEADER - 8].to_vec();
        sealed.extend_from_slice(&(payload(&real).len() as u64).to_le_bytes());
        sealed.extend_from_slice(payload(&real));
        let checksum = crc32fast::hash(&sealed);
        sealed.extend_from_slice(&checksum.to_le_bytes());
        assert_eq!(sealed, real);
        assert!(hand_over(&real));
        assert!(!hand_over(&real[..real.len() - 1]));
    }
}
