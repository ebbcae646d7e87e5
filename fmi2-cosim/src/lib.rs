//! Co-simulates FMI 2.0 FMUs.
//!
//! * A [`system`] defines which FMUs run together, how they are connected and which values are set; a [`scenario`] file or
//!   an [`ssp`] archive describes one.
//! * [`master`] steps the FMUs of a system together on a [`grid`], with [`wiring`] by equal names and in convertible
//!   [`units`], [`settings`] by name and [`signal`]s over time.
//! * [`run`] does all of this for one system and calls an observer. [`names`] suggests corrections of misspelt names.
//!   [`record`] stores the results. [`files`] writes files completely or not at all.

#![forbid(unsafe_code)]

pub mod files;
pub mod grid;
pub mod master;
pub mod names;
pub mod record;
pub mod run;
pub mod scenario;
pub mod settings;
pub mod signal;
pub mod ssp;
pub mod system;
pub mod units;
pub mod wiring;
