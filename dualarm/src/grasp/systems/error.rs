//! Why a system cannot be composed.

use std::io;
use std::path::PathBuf;

use crate::grasp::scenarios::{NoController, UnknownScenario};
use fmi2_cosim::files::WriteError;
use fmi2_cosim::scenario::ScenarioError;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::wiring::WiringError;
use fmi2_import::FmuError;
use fmi2_import::description::DescriptionError;

/// Why a system cannot be composed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ComposeError {
    /// Equal names do not determine the connections.
    #[error(transparent)]
    Wiring(#[from] WiringError),
    /// A built-in scenario is not there.
    #[error(transparent)]
    Unknown(#[from] UnknownScenario),
    /// A built-in scenario has no controller to replace.
    #[error(transparent)]
    NoController(#[from] NoController),
    /// A built-in scenario cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A scenario sets a parameter that neither FMU has, or to a value that its type does not allow.
    #[error("the scenario \"{scenario}\" sets {setting}, which fits no variable of the FMUs")]
    Setting {
        /// Title of the scenario.
        scenario: String,
        /// The setting.
        setting: Setting,
    },
    /// An FMU cannot be used.
    #[error(transparent)]
    Fmu(#[from] FmuError),
    /// A file cannot be read.
    #[error("cannot read {}: {source}; `dualarm package` and `cargo xtask describe` make it", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A description cannot be used.
    #[error("cannot use {}: {source}", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// The fault.
        source: DescriptionError,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}
