//! `NabfcController.fmu`, `PdsController.fmu` and `PdController.fmu`: the FMI face of [`grasp_control`], which is where
//! the laws are.

mod fmu;

pub use fmu::{Controller, FMUS, FmuLaw, NabfcController, PdController, PdsController};
