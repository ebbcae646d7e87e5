//! Arguments that several commands share: where the FMUs are, where results go.

use std::path::PathBuf;

use clap::Args;

use super::Failure;
use super::package::package_all;
use crate::build::Platforms;

/// The folder of the packaged FMUs.
#[derive(Debug, Clone, Args)]
pub struct FmuFolder {
    /// Folder with the packaged FMUs
    #[arg(long, default_value = "dist", value_name = "FOLDER")]
    pub fmus: PathBuf,
}

/// Options of commands that build the FMUs first and write results.
#[derive(Debug, Clone, Args)]
pub struct Job {
    /// Folder for the results; it is created if need be
    #[arg(long, short, default_value = "results", value_name = "FOLDER")]
    pub out: PathBuf,
    #[command(flatten)]
    pub folder: FmuFolder,
    /// Use the FMUs as they are in that folder, instead of building them
    #[arg(long)]
    pub no_package: bool,
}

impl Default for FmuFolder {
    fn default() -> Self {
        Self { fmus: "dist".into() }
    }
}

impl Default for Job {
    fn default() -> Self {
        Self { out: "results".into(), folder: FmuFolder::default(), no_package: false }
    }
}

impl Job {
    /// Builds and packages the FMUs and systems, unless the user wants those that are there.
    pub fn package(&self, quiet: bool) -> Result<(), Failure> {
        if !self.no_package {
            package_all(&self.folder.fmus, &Platforms::default(), quiet)?;
        }
        Ok(())
    }
}
