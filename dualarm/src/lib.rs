//! `dualarm`: packages the dual-arm grasp FMUs, co-simulates any FMI 2.0 FMUs and compares the paper's controllers.
//!
//! No model is linked in. FMUs are loaded at run time through their C interface, as any other importer would:
//!
//! * [`fmi`] is the importer, [`master`] steps FMUs together on a [`grid`], with [`wiring`] by equal names,
//!   [`settings`] by name and [`signal`]s over time; [`record`] keeps the results.
//! * A [`system`] is what the master runs; a [`scenario`] file describes one.
//! * [`mod@package`] builds the project's own FMUs, [`grasp`] names them, [`metrics`] judges a run, [`figures`],
//!   [`report`] and [`page`] show it, the page with the models' [`parameters`].
//! * [`ssp`] reads and writes systems of FMUs in one file; [`mod@release`] lays FMUs out with their reference solutions.
//! * [`mod@verify`] holds the FMUs against exact and independent solutions.
//! * [`cli`] is the command line, [`files`] writes files whole or not at all.

pub mod cli;
mod drive;
pub mod figures;
pub mod files;
pub mod fmi;
pub mod grasp;
pub mod grid;
pub mod master;
pub mod metrics;
pub mod package;
pub mod page;
pub mod parameters;
pub mod record;
pub mod release;
pub mod report;
pub mod scenario;
pub mod settings;
pub mod signal;
pub mod ssp;
pub mod system;
pub mod verify;
pub mod wiring;
