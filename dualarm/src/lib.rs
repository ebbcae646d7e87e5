//! `dualarm`: packages the dual-arm grasp FMUs, co-simulates any FMI 2.0 FMUs and compares the paper's controllers.
//!
//! Every run uses FMUs: [`fmi2_import`] loads them through their C interface, like any other importer, and [`fmi2_cosim`]
//! runs them. Only the analysis of the equations links the physics. This crate contains everything about the grasp:
//!
//! * [`grasp`] names its parts, scenarios and systems, and evaluates a run;
//! * [`mod@build`] makes the project's own FMUs and their release layout with reference solutions;
//! * [`comparison`] is the main command: runs, tables, figures, page;
//! * [`report`] shows runs and matrices;
//! * [`tune`] searches for gains, [`sweep`] makes many runs of one system;
//! * [`mod@verify`] compares the FMUs with exact and independent solutions;
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

/// The name and version of this program, as files state it.
pub(crate) const TOOL: &str = concat!("dualarm ", env!("CARGO_PKG_VERSION"));
