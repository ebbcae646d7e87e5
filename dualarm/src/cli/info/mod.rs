//! `dualarm info`

mod document;
mod system;
mod text;

use std::path::PathBuf;

use clap::Args;

use super::fmus::FmuFolder;
use super::meant::instead_of_file;
use super::{Failure, json, print};
use document::Document;
use fmi2_cosim::ssp::package::is_ssp;

const AFTER_HELP: &str = "\
Works for every FMI 2.0 FMU, whoever made it, for any platform, for co-simulation and model exchange. Only reads: no code \
of the FMU runs, unless you ask for it with --load.

Examples:
  dualarm info dist/DualArmPlant.fmu
  dualarm info dist/DualArmGrasp-PD.ssp          components, connections
  dualarm info model.fmu --load
  dualarm info model.fmu --variables | grep -i temperature
  dualarm info model.fmu --json |
    jq '.variables[] | select(.unit == \"rad\") | .name'";

/// Arguments of `dualarm info`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// The FMU, or a system in one file (.ssp; a variant in it as FILE.ssp#VARIANT.ssd)
    #[arg(value_name = "FMU|SSP")]
    file: PathBuf,
    /// List all variables, also internal ones, with type, causality and variability
    #[arg(long)]
    variables: bool,
    /// Also load the library, which runs code of the FMU, to see whether the system can
    #[arg(long)]
    load: bool,
    /// Print everything as JSON
    #[arg(long, conflicts_with = "variables")]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(message) = instead_of_file(&arguments.file, &FmuFolder::default().fmus) {
        return Err(Failure::failed(message));
    }
    if is_ssp(&arguments.file) {
        let document = system::Document::of(&arguments.file)?;
        if arguments.json {
            return json::print(&document);
        }
        print(&document.summary(text::width()));
        return Ok(());
    }
    let document = Document::of(&arguments.file, arguments.load)?;
    if arguments.json {
        return json::print(&document);
    }
    print(&text::summary(&document, arguments.variables, text::width()));
    Ok(())
}
