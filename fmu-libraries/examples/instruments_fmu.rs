//! What a tool loads from `GraspInstruments.fmu` and `GraspActuators.fmu`.

pub use instruments_fmu::*;
