//! `NabfcController.fmu`, `PdsController.fmu` and `PdController.fmu`: the library of [`controller_model`]'s models, and the program that
//! packages it.

pub use controller_model::{Controller, FMUS, FmuLaw, NabfcController, PdController, PdsController};

fmi2_export::export!(in controller_model);
