//! What a tool loads from `NabfcController.fmu`, `PdsController.fmu` and `PdController.fmu`.

pub use controller_fmu::*;
