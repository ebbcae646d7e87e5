//! Sensors and actuators between the dual-arm plant and its controllers, as FMUs.
//!
//! `GraspInstruments.fmu` shows the plant's measured signals to a controller, `GraspActuators.fmu` passes its commands on.
//! What they do is in `grasp-instruments`; here is the FMI face. They are two FMUs, because a master that runs one FMU after
//! the other, and a block diagram that orders whole blocks, can then run plant, instruments, controller, actuators in
//! turn; one FMU on both sides of the controller would be a loop to them, or a step of delay.

mod actuators;
mod instruments;

pub use actuators::{ActuatorProfile, GraspActuators};
pub use instruments::{GraspInstruments, SensorProfile};

fmi2_export::export!(GraspInstruments, GraspActuators);
