//! `dualarm`: packages the dual-arm grasp FMUs, co-simulates any FMI 2.0 FMUs and compares the paper's controllers.
//!
//! Every run is one of FMUs: [`fmi2_import`] loads them through their C interface, as any other importer would, and
//! [`fmi2_cosim`] runs them. Only the analysis of the equations links the physics. What is here is about the grasp:
//!
//! * [`grasp`] names its parts, scenarios and systems, and judges a run;
//! * [`mod@build`] makes the project's own FMUs and lays them out with their reference solutions;
//! * [`comparison`] is the main job: runs, tables, figures, page;
//! * [`report`] shows runs and matrices;
//! * [`tune`] searches for gains, [`sweep`] makes many runs of one system;
//! * [`mod@verify`] holds the FMUs against exact and independent solutions;
//! * [`cli`] is the command line.

pub mod build;
pub mod cli;
pub mod comparison;
mod fingerprint;
pub mod grasp;
pub mod report;
pub mod sweep;
pub mod tune;
pub mod verify;

/// What a file says about the program that wrote it.
pub(crate) const TOOL: &str = concat!("dualarm ", env!("CARGO_PKG_VERSION"));
