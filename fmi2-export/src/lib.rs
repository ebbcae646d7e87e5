#![doc = include_str!("../README.md")]

mod access;
mod builder;
mod enumeration;
mod export;
pub mod ffi;
mod interface;
mod layout;
mod logger;
mod model;
mod naming;
#[doc(hidden)]
pub mod packaging;
mod parameter;
mod phase;
mod problems;
mod slave;
mod snapshot;
mod unit;
mod variable;
mod variables;
mod xml;

pub use access::Scalar;
pub use builder::VariableBuilder;
pub use enumeration::Enumeration;
pub use layout::DeclarationError;
pub use model::{DefaultExperiment, Experiment, Failure, Info, Model, Step};
pub use parameter::Parameter;
#[doc(hidden)]
pub use serde;
pub use snapshot::SnapshotError;
pub use unit::{Unit, UnitError};
pub use variable::{Causality, DependencyKind, Variability};
pub use variables::{Evaluation, Variables};
pub use xml::{Description, describe};
