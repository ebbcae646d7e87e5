//! The work of each fuzz target with its bytes. A target fails by a panic.

#![allow(clippy::missing_panics_doc)] // that is how they fail

mod state;

pub use state::{blob, payload, state};

use fmi2_cosim::ssp::{read, write};
use fmi2_import::ModelDescription;

/// Reads a `modelDescription.xml`; an accepted description is consistent.
pub fn description(data: &[u8]) {
    let Ok(description) = ModelDescription::from_bytes(data) else { return };
    for (index, variable) in description.variables.iter().enumerate() {
        assert_eq!(description.index_of(&variable.name), Some(index), "names are unique");
        let _ = (variable.items(), variable.start(), variable.parse("1"));
    }
}

/// Reads the documents of an SSP; an accepted document can be written, and the result can be read.
pub fn ssp(data: &[u8]) {
    if let Ok(structure) = read::system_structure(data) {
        let written = write::system_structure(&structure);
        assert!(read::system_structure(written.as_bytes()).is_ok(), "{written}");
    }
    if let Ok(set) = read::parameter_set(data) {
        let written = write::parameter_set(&set);
        assert!(read::parameter_set(written.as_bytes()).is_ok(), "{written}");
    }
    let _ = read::parameter_mapping(data);
}
