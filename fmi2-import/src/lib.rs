//! An FMI 2.0 importer for co-simulation: opens any `.fmu`, reads its description, loads its library, runs instances.
//!
//! * [`Fmu`] opens the archive and hands out instances;
//! * [`ModelDescription`] is what `modelDescription.xml` says;
//! * [`Instance`] is one running slave, behind safe calls whose errors carry the slave's own messages;
//! * [`library`] is the C interface itself;
//! * [`archive`] and [`document`] read files of strangers within limits.
//!
//! ```no_run
//! use fmi2_import::{Experiment, Fmu};
//!
//! let fmu = Fmu::open("dist/DualArmPlant.fmu")?;
//! let theta1 = fmu.description().variable("theta1").expect("the plant has hub angles").value_reference;
//! let mut plant = fmu.instantiate("plant")?;
//! plant.setup_experiment(Experiment::default())?;
//! plant.enter_initialization_mode()?;
//! plant.exit_initialization_mode()?;
//! plant.do_step(0.0, 1e-4)?;
//! let mut angle = [0.0];
//! plant.get_real(&[theta1], &mut angle)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod archive;
mod binary;
pub mod description;
pub mod document;
mod error;
mod fmu;
mod instance;
pub mod library;
mod platform;
mod value;
#[doc(hidden)]
pub mod xml;

pub use description::{Causality, DescriptionError, Initial, ModelDescription, Variability, Variable, VariableType};
pub use error::{CallError, FmuError};
pub use fmu::{Contents, Fmu, Unpacked};
pub use instance::{Experiment, Instance, LogMessage, SavedState};
pub use library::{Status, ValueReference};
pub use platform::platform;
pub use value::{Mismatch, Value};
