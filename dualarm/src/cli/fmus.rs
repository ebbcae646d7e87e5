//! Arguments that several commands share: where the FMUs are, where results go.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};

use super::Failure;
use super::package::package_all;
use crate::build::Platforms;
use fmi2_cosim::files::has_extension;

/// The folder of the packaged FMUs.
#[derive(Debug, Clone, Args)]
pub struct FmuFolder {
    /// Folder with the packaged FMUs
    #[arg(long, default_value_os_t = usual_folder(), value_name = "FOLDER")]
    pub fmus: PathBuf,
}

/// The folder of FMUs beside this program, as downloads have it: there nothing is built.
fn shipped_folder() -> Option<PathBuf> {
    let folder = std::env::current_exe().ok()?.parent()?.join("fmus");
    folder.is_dir().then_some(folder)
}

/// The default folder of FMUs.
fn usual_folder() -> PathBuf {
    shipped_folder().unwrap_or_else(|| "dist".into())
}

/// Options of commands that build the FMUs first and write results.
#[derive(Debug, Clone, Args)]
pub struct Job {
    /// Folder for the results; it is created if need be
    #[arg(long, short, default_value = "results", value_name = "FOLDER", value_parser = folder())]
    pub out: PathBuf,
    #[command(flatten)]
    pub folder: FmuFolder,
    /// Use the FMUs as they are in that folder, instead of building them
    #[arg(long)]
    pub no_package: bool,
}

/// Reads the folder into which a command writes all its files: a name that only files have is a mistake, unless
/// a slash at its end says that it is one.
pub fn folder() -> impl TypedValueParser<Value = PathBuf> {
    const FILES: [&str; 11] = ["csv", "parquet", "html", "md", "svg", "png", "pdf", "json", "fmu", "ssp", "toml"];
    PathBufValueParser::new().try_map(|path| {
        let is_said = path.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
        if !is_said && !path.is_dir() && FILES.iter().any(|ending| has_extension(&path, ending)) {
            return Err("this is the name of a file; a folder is wanted, which gets all files that the command writes");
        }
        Ok(path)
    })
}

impl Default for FmuFolder {
    fn default() -> Self {
        Self { fmus: usual_folder() }
    }
}

impl Default for Job {
    fn default() -> Self {
        Self { out: "results".into(), folder: FmuFolder::default(), no_package: false }
    }
}

impl Job {
    /// Builds and packages the FMUs and systems, unless the user chooses the existing ones, or they came with this program.
    pub fn package(&self, quiet: bool) -> Result<(), Failure> {
        if !self.no_package && shipped_folder().is_none_or(|shipped| shipped != self.folder.fmus) {
            package_all(&self.folder.fmus, &Platforms::default(), None, quiet)?;
        }
        Ok(())
    }
}
