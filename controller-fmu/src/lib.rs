//! `NabfcController.fmu`, `PdsController.fmu` and `PdController.fmu`: the FMI interface of [`grasp_control`], which
//! contains the laws.

mod fmu;

pub use fmu::{Controller, FMUS, FmuLaw, NabfcController, PdController, PdsController};
