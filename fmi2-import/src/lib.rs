//! An FMI 2.0 importer for co-simulation. It opens any `.fmu`, reads its description, loads its library and runs instances.
//!
//! * [`Fmu`] opens the archive and creates instances;
//! * [`ModelDescription`] is the content of `modelDescription.xml`, [`Variable`] its entry for one variable;
//! * [`Instance`] is one running slave, behind safe calls whose errors contain the slave's own messages;
//! * [`Value`] is a value of any variable.
//!
//! ```no_run
//! use fmi2_import::{Experiment, Fmu};
//!
//! let fmu = Fmu::open("model.fmu")?;
//! let output = fmu.description().variable("y").ok_or("the model has no output y")?;
//! let mut slave = fmu.instantiate("slave")?;
//! slave.setup_experiment(Experiment { stop: Some(1.0), ..Experiment::default() })?;
//! slave.enter_initialization_mode()?;
//! slave.exit_initialization_mode()?;
//! for step in 0..100 {
//!     slave.do_step(f64::from(step) * 0.01, 0.01)?;
//! }
//! println!("y = {}", slave.get(output)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(clippy::undocumented_unsafe_blocks)]

#[doc(hidden)]
pub mod archive;
mod binary;
pub mod description;
#[doc(hidden)]
pub mod document;
mod error;
mod floating_point;
mod fmu;
mod instance;
mod library;
mod platform;
mod tree;
mod value;
#[doc(hidden)]
pub mod xml;

pub use archive::ArchiveError;
pub use description::{Causality, DescriptionError, Initial, ModelDescription, Variability, Variable, VariableType};
pub use document::XmlError;
pub use error::{CallError, FmuError};
pub use floating_point::Environment;
pub use fmu::{Contents, Files, Fmu};
pub use instance::{Calls, Experiment, Instance, LogMessage, SavedState};
pub use library::{Component, Functions, LibraryError, Status, ValueReference};
pub use platform::platform;
pub use value::{Mismatch, Value};
pub use xml::Fault;
