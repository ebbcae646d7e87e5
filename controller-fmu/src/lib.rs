//! Force-sensorless grasp control of two flexible arms: NABFC, PDS and PD behind one interface.

// Floats are compared literally where equality is meant literally: the same inputs, the same step size, an exact zero.
#![allow(clippy::float_cmp)]

#[macro_use]
pub mod parameter;
pub mod adaptation;
mod estimator;
pub mod exponential;
mod fmu;
pub mod gains;
pub mod law;
pub mod lowpass;
pub mod nabfc;
mod object_loop;
pub mod pd;
pub mod pds;
mod posture_loop;
pub mod rbf;
mod sat;
pub mod signals;
pub mod target;

pub use fmu::{Controller, FMUS, FmuLaw, NabfcController, PdController, PdsController};
