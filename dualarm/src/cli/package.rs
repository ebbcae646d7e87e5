//! `dualarm package`

use std::path::PathBuf;

use clap::Args;

use super::{Failure, print};
use crate::package::{package, repository};

/// Arguments of `dualarm package`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for the .fmu files
    #[arg(long, short, default_value = "dist", value_name = "FOLDER")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    let fmus = package(repository(), &arguments.out, quiet, &mut |doing| say(quiet, doing))?;
    if !quiet {
        for path in fmus {
            let size = std::fs::metadata(&path).map_or(0, |file| file.len());
            print(&format!("{}  {:.2} MB\n", path.display(), size as f64 / 1e6));
        }
    }
    Ok(())
}

/// One line on stderr about what is being done. Cargo draws its own bar below it.
pub fn say(quiet: bool, doing: &str) {
    if !quiet {
        eprintln!("{doing} …");
    }
}
