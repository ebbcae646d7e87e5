#![doc = include_str!("../README.md")]
#![deny(clippy::undocumented_unsafe_blocks)]

// The macros say `::fmi2_export`, which in the documentation's and this crate's own tests is this crate.
extern crate self as fmi2_export;

mod access;
mod any_model;
mod builder;
mod categories;
mod checksum;
mod declarations;
mod difference;
mod enumeration;
mod exchange;
mod exchange_phase;
mod export;
#[doc(hidden)]
pub mod ffi;
mod handles;
mod identity;
mod info;
#[doc(hidden)]
pub mod integration;
mod interface;
mod layout;
mod library;
mod model;
mod naming;
mod out;
#[doc(hidden)]
pub mod packaging;
mod pairs;
mod phase;
mod place;
mod problems;
mod resources;
mod served;
mod slave;
mod snapshot;
mod states;
mod status;
mod unit;
mod variable;
mod variables;
mod view;
mod xml;

pub use access::{Scalar, Shape};
pub use builder::VariableBuilder;
pub use enumeration::Enumeration;
pub use exchange::{Completed, EventUpdate, ModelExchange, Moment};
pub use fmi2_export_derive::{Declare, model};
#[doc(hidden)]
pub use identity::fixed as fixed_guid;
pub use info::{DefaultExperiment, Info};
pub use layout::DeclarationError;
#[doc(hidden)]
pub use library::Described;
pub use library::{ExportedModel, Library};
pub use model::{Conclusion, Declare, Experiment, Failure, Model, Step};
/// Tables of parameters and states, which a crate of equations can have without this one.
pub use parameter_table::{self, Owner, Parameter, Range, StateVariable, parameter};
pub use place::Field;
pub use resources::Resources;
#[doc(hidden)]
pub use serde;
#[doc(hidden)]
pub use served::{Exported, Served};
pub use snapshot::SnapshotError;
pub use unit::{Unit, UnitError};
pub use variable::{Causality, DependencyKind, Variability};
pub use variables::{Evaluation, Variables};
pub use xml::{Description, describe};
