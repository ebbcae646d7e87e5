#![doc = include_str!("../README.md")]
//! Equation numbers are those of Hejrati, *Neuro-Adaptive Boundary Force Control of Dual One-Link Flexible Arms with
//! Unmodeled Dynamics and Input Constraints*.

// Floats are compared literally where equality is meant literally: the same inputs, the same step size, an exact zero.
#![allow(clippy::float_cmp)]

pub mod blocks;
pub mod continuous;
mod law;
pub mod laws;
mod signals;
mod target;

pub use law::{CommandJacobian, Law, StepError, inner};
pub use parameter_table::{InvalidParameter, Parameter, Range, StateVariable};
pub use signals::{Commands, Errors, INPUT_NAMES, INPUTS, Inputs, Measurements, References};
pub use target::{Arms, ErrorJacobian, TargetJacobian, Targets};
