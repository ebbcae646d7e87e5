//! A model that reads a file which its archive carries: at instantiation, after a reset and for a state from bytes, wherever the
//! host has unpacked it.

use std::ffi::{CString, c_char};
use std::path::Path;
use std::ptr;

use fmi2_export::ffi::types::{CallbackFunctions, Status};
use fmi2_export::{Declare, Failure, Info, Model, Resources, Step, Variables};
use serde::{Deserialize, Serialize};

#[path = "common/linked.rs"]
mod linked;
use linked::*;

/// An output that is what stands in `resources/value.txt`.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Table {
    y: f64,
    /// Not saved: read again.
    #[serde(skip)]
    value: f64,
}

impl Declare for Table {
    const INFO: Info = Info { name: "Table", description: "Reads a file", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|m: &mut Self| m.y = m.value);
        variables.output("y", outputs, |m| &mut m.y).description("What the file says");
    }
}

impl Model for Table {
    fn resources(&mut self, resources: &Resources) -> Result<(), Failure> {
        let text = String::from_utf8(resources.read("value.txt")?).map_err(Failure::error)?;
        self.value = text.trim().parse().map_err(|error| Failure::error(format_args!("value.txt: {error}")))?;
        Ok(())
    }

    fn step(&mut self, _step: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

fmi2_export::export!(Table);

fn functions() -> CallbackFunctions {
    CallbackFunctions {
        logger: None,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: ptr::null_mut(),
    }
}

fn instantiate(location: *const c_char) -> C {
    let guid = CString::new(FMUS.models()[0].description().unwrap().guid).unwrap();
    // SAFETY: all pointers are valid for the call.
    unsafe { fmi2Instantiate(c"table".as_ptr(), 1, guid.as_ptr(), location, &functions(), 0, 0) }
}

/// The output, in initialization mode.
fn value(c: C) -> f64 {
    let mut value = f64::NAN;
    // SAFETY: a live instance, and one value for one reference.
    unsafe {
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2GetReal(c, &0, 1, &raw mut value), Status::Ok);
    }
    value
}

fn write(folder: &Path, text: &str) {
    std::fs::write(folder.join("value.txt"), text).unwrap();
}

#[test]
fn the_file_is_read_wherever_the_host_has_put_it() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("a b%20ü");
    std::fs::create_dir(&folder).unwrap();
    write(&folder, "1.5");
    let path = folder.display().to_string().replace('\\', "/");
    let encoded = path.replace('%', "%25").replace(' ', "%20").replace('ü', "%C3%BC");
    let slash = if path.starts_with('/') { "" } else { "/" };
    for location in [format!("file://{slash}{encoded}"), format!("file:{slash}{encoded}/"), path] {
        let location = CString::new(location).unwrap();
        let c = instantiate(location.as_ptr());
        assert!(!c.is_null(), "{location:?}");
        assert_eq!(value(c), 1.5);
        // SAFETY: a live instance, not used again.
        unsafe { fmi2FreeInstance(c) };
    }
}

#[test]
fn without_the_file_there_is_no_instance() {
    let empty = tempfile::tempdir().unwrap();
    let location = CString::new(format!("file://{}", empty.path().display())).unwrap();
    for location in [ptr::null(), c"".as_ptr(), c"http://host/x".as_ptr(), location.as_ptr()] {
        assert!(instantiate(location).is_null());
    }
}

#[test]
fn a_reset_instance_and_a_state_from_bytes_have_read_it_too() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "2");
    let location = CString::new(folder.path().to_str().unwrap()).unwrap();
    let c = instantiate(location.as_ptr());
    assert_eq!(value(c), 2.0);
    // SAFETY: a live instance; the buffer has the size that was asked for.
    unsafe {
        let (mut state, mut size) = (ptr::null_mut(), 0);
        assert_eq!(fmi2GetFMUstate(c, &raw mut state), Status::Ok);
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &raw mut size), Status::Ok);
        let mut bytes = vec![0; size];
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size), Status::Ok);
        write(folder.path(), "3");
        assert_eq!(fmi2DeSerializeFMUstate(c, bytes.as_ptr(), size, &raw mut state), Status::Ok);
        assert_eq!(fmi2SetFMUstate(c, state), Status::Ok);
        let mut now = f64::NAN;
        assert_eq!(fmi2GetReal(c, &0, 1, &raw mut now), Status::Ok);
        assert_eq!(now, 3.0);
        write(folder.path(), "4");
        assert_eq!(fmi2Reset(c), Status::Ok);
        assert_eq!(value(c), 4.0);
        // What cannot be read leaves the instance as it was.
        write(folder.path(), "no number");
        assert_eq!(fmi2Reset(c), Status::Error);
        assert_eq!(fmi2GetReal(c, &0, 1, &raw mut now), Status::Ok);
        assert_eq!(now, 4.0);
        fmi2FreeInstance(c);
    }
}
