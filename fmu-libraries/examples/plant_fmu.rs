//! What a tool loads from `DualArmPlant.fmu`.

pub use plant_fmu::*;
