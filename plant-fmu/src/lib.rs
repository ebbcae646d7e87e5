//! `DualArmPlant.fmu`: the FMI face of [`grasp_plant`], which is where the physics is.

mod fmu;

pub use fmu::{DualArmPlant, FMUS};
