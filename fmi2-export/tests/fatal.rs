//! A model that says that nothing of the FMU can be used any more: `fmi2Fatal` (FMI 2.0.4, section 2.1.3).
//!
//! That is for good as long as the library is loaded, so each case runs in a process of its own.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::process::Command;
use std::ptr::null_mut;
use std::sync::{Mutex, PoisonError};

use fmi2_export::ffi::types::{CallbackFunctions, EventInfo, LoggerCallback, Status};
use fmi2_export::{
    Declare, EventUpdate, Experiment, Failure, Info, Model, ModelExchange, Moment, Resources, Step, Variables,
};
use serde::{Deserialize, Serialize};

#[path = "common/linked.rs"]
mod linked;
use linked::*;

const OK: Status = Status::Ok;
const FATAL: Status = Status::Fatal;

/// x' = 0, and where the name of the case says so the end of everything.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Reactor {
    x: f64,
    x_dot: f64,
    tunable: f64,
}

/// Where the shared part of all instances breaks.
fn breaks(place: &str) -> Result<(), Failure> {
    let case = std::env::var("CASE").unwrap_or_default();
    if case == place { Err(Failure::fatal(format_args!("100 % broken in {place}"))) } else { Ok(()) }
}

impl Declare for Reactor {
    const INFO: Info = Info { name: "Reactor", description: "Shares what can break", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let nothing = variables.evaluation(|_| {});
        variables.output("x", nothing, |m| &mut m.x).state().description("State");
        variables.local("der(x)", nothing, |m| &mut m.x_dot).derivative_of("x").description("Its rate");
        variables.parameter("tunable", |m| &mut m.tunable).tunable().description("Parameter");
        variables.model_exchange();
    }
}

impl Model for Reactor {
    fn resources(&mut self, _: &Resources) -> Result<(), Failure> {
        breaks("instantiation")
    }

    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        breaks("initialization")
    }

    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        breaks("step")
    }

    fn retuned(&mut self) -> Result<(), Failure> {
        breaks("tuning")
    }
}

impl ModelExchange for Reactor {
    fn states_set(&mut self) -> Result<(), Failure> {
        breaks("states")
    }

    fn new_discrete_states(&mut self, _: &mut Moment<'_>) -> Result<EventUpdate, Failure> {
        breaks("event").map(|()| EventUpdate::default())
    }
}

fmi2_export::export!(Reactor);

/// Status, category and text of all messages.
static LOG: Mutex<Vec<(Status, String, String)>> = Mutex::new(Vec::new());

/// Variadic functions cannot be defined in Rust; the callee may ignore the variadic part, and none is passed.
unsafe extern "C" fn record(
    _: *mut c_void,
    _: *const c_char,
    status: Status,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: both are C strings of the caller.
    let text = |s: *const c_char| unsafe { CStr::from_ptr(s) }.to_str().unwrap().to_owned();
    LOG.lock().unwrap_or_else(PoisonError::into_inner).push((status, text(category), text(message)));
}

fn said() -> Vec<(Status, String, String)> {
    std::mem::take(&mut LOG.lock().unwrap())
}

/// An instance of a host that has logging off.
fn instantiate(kind: c_int) -> C {
    // SAFETY: the types differ in the variadic part only, of which nothing is passed.
    let logger: LoggerCallback = unsafe { std::mem::transmute(record as *const c_void) };
    let callbacks = CallbackFunctions { logger: Some(logger), ..NO_CALLBACKS };
    let guid = CString::new(FMUS.models()[0].description().unwrap().guid).unwrap();
    // SAFETY: all pointers are valid for the call.
    unsafe { fmi2Instantiate(c"reactor".as_ptr(), kind, guid.as_ptr(), c"".as_ptr(), &raw const callbacks, 0, 0) }
}

/// Every call on an instance that a host could think of.
fn calls(c: C) -> [Status; 16] {
    let (vr, mut value, mut state, mut info) = (0, 0.0, null_mut(), EventInfo::default());
    // SAFETY: all pointers are valid for the call.
    unsafe {
        [
            fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            fmi2EnterInitializationMode(c),
            fmi2ExitInitializationMode(c),
            fmi2GetReal(c, &raw const vr, 1, &raw mut value),
            fmi2SetReal(c, &1, 1, &1.0),
            fmi2DoStep(c, 0.0, 1.0, 1),
            fmi2Reset(c),
            fmi2GetFMUstate(c, &raw mut state),
            fmi2SetFMUstate(c, state),
            fmi2EnterEventMode(c),
            fmi2NewDiscreteStates(c, &raw mut info),
            fmi2EnterContinuousTimeMode(c),
            fmi2SetTime(c, 0.0),
            fmi2SetContinuousStates(c, &0.0, 1),
            fmi2GetDerivatives(c, &raw mut value, 1),
            fmi2GetContinuousStates(c, &raw mut value, 1),
        ]
    }
}

/// Brings about the case, and looks at what is left.
#[test]
#[ignore = "run by the test below, in a process of its own"]
fn one_case() {
    let Ok(case) = std::env::var("CASE") else { return };
    let kind = c_int::from(!matches!(case.as_str(), "states" | "event"));
    if case == "instantiation" {
        assert!(instantiate(1).is_null());
        let expected = "fmi2Instantiate failed: 100 %% broken in instantiation".to_owned();
        assert_eq!(said(), [(FATAL, "logStatusError".to_owned(), expected)]);
    } else {
        let (c, other) = (instantiate(kind), instantiate(0));
        // One that is between steps, of which this thread has read before: no call of it looks at more than it must.
        let stepping = (case != "initialization").then(|| {
            let c = instantiate(1);
            // SAFETY: a living instance; all pointers are valid for the call.
            unsafe {
                assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
                assert_eq!((fmi2EnterInitializationMode(c), fmi2ExitInitializationMode(c)), (OK, OK));
                (0..3).for_each(|_| assert_eq!(fmi2GetReal(c, &0, 1, &mut 0.0), OK));
            }
            c
        });
        // SAFETY: living instances; all pointers are valid for the call.
        let provoked = unsafe {
            assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
            match (fmi2EnterInitializationMode(c), case.as_str()) {
                (status, "initialization") => status,
                (status, case) => {
                    assert_eq!((status, fmi2ExitInitializationMode(c)), (OK, OK));
                    match case {
                        "step" => fmi2DoStep(c, 0.0, 1.0, 1),
                        "tuning" => fmi2SetReal(c, &2, 1, &1.0),
                        "event" => fmi2NewDiscreteStates(c, &mut EventInfo::default()),
                        "states" => {
                            assert_eq!(fmi2NewDiscreteStates(c, &mut EventInfo::default()), OK);
                            assert_eq!(fmi2EnterContinuousTimeMode(c), OK);
                            fmi2SetContinuousStates(c, &1.0, 1)
                        }
                        _ => panic!("{case}"),
                    }
                }
            }
        };
        assert_eq!(provoked, FATAL);
        assert_eq!(said(), [(FATAL, "logStatusError".to_owned(), format!("100 %% broken in {case}"))]);
        if let Some(stepping) = stepping {
            // SAFETY: a living instance; all pointers are valid for the call.
            assert_eq!(unsafe { fmi2GetReal(stepping, &0, 1, &mut 0.0) }, FATAL);
            assert_eq!(said().len(), 1);
        }
        for instance in [c, other].into_iter().chain(stepping) {
            assert_eq!(calls(instance), [FATAL; 16]);
            let news = said();
            assert_eq!(news.len(), 16, "each refusal is told");
            assert!(news.iter().all(|(status, category, text)| {
                (*status, category.as_str()) == (FATAL, "logStatusError") && text.contains("until it is loaded anew")
            }));
            // SAFETY: a living instance.
            unsafe { fmi2FreeInstance(instance) };
        }
    }
    assert!(said().is_empty());
    assert!(instantiate(kind).is_null(), "nor are there new ones");
    let news = said();
    assert!(news.len() == 1 && news[0].0 == FATAL && news[0].2.contains("fmi2Fatal has been returned"), "{news:?}");
}

#[test]
fn after_fatal_nothing_can_be_called_but_free() {
    for case in ["instantiation", "initialization", "step", "tuning", "states", "event"] {
        let mut test = Command::new(std::env::current_exe().unwrap());
        let done = test.args(["--exact", "one_case", "--ignored", "--nocapture"]).env("CASE", case).output().unwrap();
        assert!(done.status.success(), "{case}: {}", String::from_utf8_lossy(&done.stderr));
        assert!(String::from_utf8_lossy(&done.stdout).contains("1 passed"), "{case}");
    }
}
