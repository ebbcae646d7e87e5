//! A program that links a model sees its own panics, but not those that the model's calls catch.

use std::ffi::CString;
use std::panic::catch_unwind;
use std::ptr::null;
use std::sync::Mutex;

use fmi2_export::ffi::types::Status;
use fmi2_export::{Declare, Experiment, Failure, Info, Model, Step, Variables};
use serde::{Deserialize, Serialize};

/// Panics in the call that the input names.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Fragile {
    u: f64,
    y: f64,
}

impl Declare for Fragile {
    const INFO: Info = Info { name: "Fragile", description: "Panics", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|m| m.y = m.u);
        variables.input("u", |m| &mut m.u).description("A step panics if it is positive");
        variables.output("y", outputs, |m| &mut m.y).description("The input");
    }
}

impl Model for Fragile {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        assert!(self.u <= 0.0, "inside a step");
        Ok(())
    }
}

impl Drop for Fragile {
    fn drop(&mut self) {
        assert!(self.u <= 0.0, "inside the destructor");
    }
}

fmi2_export::export!(Fragile);

#[path = "common/linked.rs"]
mod linked;
use linked::*;

/// Messages of the panics that this program's hook has seen.
static SEEN: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn seen() -> Vec<String> {
    std::mem::take(&mut SEEN.lock().unwrap())
}

/// Panics outside of any call, as a failing assertion of a test does.
fn panic_outside() {
    catch_unwind(|| panic!("outside")).unwrap_err();
}

fn instance() -> C {
    let guid = CString::new(FMUS.models()[0].description().unwrap().guid).unwrap();
    // SAFETY: as a host does.
    let c = unsafe { fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &NO_CALLBACKS, 0, 0) };
    assert!(!c.is_null());
    c
}

/// Its destructor frees an instance, and makes and frees another one, while its thread panics.
struct Guard(C);
impl Drop for Guard {
    fn drop(&mut self) {
        // SAFETY: as a host does.
        unsafe {
            fmi2FreeInstance(self.0);
            fmi2FreeInstance(instance());
        }
    }
}

#[test]
fn panics_are_silent_inside_a_call_and_loud_outside() {
    std::panic::set_hook(Box::new(|info| {
        SEEN.lock().unwrap().push(info.payload_as_str().unwrap_or_default().to_owned());
    }));
    let (first, second) = (instance(), instance());
    panic_outside();
    assert_eq!(seen(), ["outside"], "with living instances");
    // SAFETY: as a host does.
    unsafe {
        assert_eq!(fmi2SetupExperiment(first, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(first), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(first), Status::Ok);
        assert_eq!(fmi2SetReal(first, &0, 1, &1.0), Status::Ok);
        assert_eq!(fmi2DoStep(first, 0.0, 0.5, 1), Status::Error);
        assert!(seen().is_empty(), "inside a step");
        panic_outside();
        assert_eq!(seen(), ["outside"], "after a caught panic");
        fmi2FreeInstance(first);
        assert!(seen().is_empty(), "inside the destructor");
        fmi2FreeInstance(second);
    }
    panic_outside();
    assert_eq!(seen(), ["outside"], "after the last instance");

    catch_unwind(|| {
        let _guard = Guard(instance());
        panic!("unwinding");
    })
    .unwrap_err();
    assert_eq!(seen(), ["unwinding"]);
    drop(std::panic::take_hook());
}
