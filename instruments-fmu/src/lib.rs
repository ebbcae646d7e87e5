//! Sensors and actuators between the dual-arm plant and its controllers, as FMUs.
//!
//! `GraspInstruments.fmu` passes the plant's measured signals to a controller, `GraspActuators.fmu` passes the controller's
//! commands on. `grasp-instruments` contains the equations; this crate is the FMI interface. There are two FMUs so that a
//! master that runs one FMU after the other, or a block diagram that orders whole blocks, can run plant, instruments,
//! controller and actuators in turn. A single FMU on both sides of the controller would be an algebraic loop, or a step of
//! delay.

mod actuators;
mod instruments;

pub use actuators::{ActuatorProfile, GraspActuators};
pub use instruments::{GraspInstruments, SensorProfile};

fmi2_export::export!(GraspInstruments, GraspActuators);
