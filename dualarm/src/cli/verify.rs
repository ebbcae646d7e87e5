//! `dualarm verify`

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::package::say;
use super::{Failure, print};
use crate::figures::raster;
use crate::files;
use crate::package::{package, repository};
use crate::verify::{Fmus, verify};

/// Arguments of `dualarm verify`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for verification.md, verification.csv and figures/convergence
    #[arg(long, short, default_value = "results", value_name = "FOLDER")]
    out: PathBuf,
    /// Folder with the packaged FMUs
    #[arg(long, default_value = "dist", value_name = "FOLDER")]
    fmus: PathBuf,
    /// Use the FMUs that are already in that folder
    #[arg(long)]
    no_package: bool,
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    if !arguments.no_package {
        package(repository(), &arguments.fmus, quiet, &mut |doing| say(quiet, doing))?;
    }
    let begin = Instant::now();
    let fmus = Fmus::open(&arguments.fmus)?;
    let result = verify(&fmus, &mut |doing| say(quiet, doing))?;

    let svg = result.figure.figure.to_svg();
    let png = raster::to_png(&svg)
        .map_err(|reason| Failure { code: 1, message: format!("cannot draw {}: {reason}", result.figure.name) })?;
    let figures = arguments.out.join("figures");
    files::write(figures.join(format!("{}.svg", result.figure.name)), svg)?;
    files::write(figures.join(format!("{}.png", result.figure.name)), png)?;
    files::write(arguments.out.join("verification.csv"), result.to_csv())?;
    let report = arguments.out.join("verification.md");
    files::write(&report, result.to_markdown())?;

    if !quiet {
        for (title, table) in result.tables() {
            print(&format!("{title}\n\n{}\n", table.to_terminal()));
        }
        let seconds = begin.elapsed().as_secs_f64();
        print(&format!("{} checks in {seconds:.1} s; {}\n", result.checks.len(), report.display()));
    }
    match result.failures() {
        0 => Ok(()),
        broken => {
            Err(Failure { code: 1, message: format!("{broken} of {} checks are out of bounds", result.checks.len()) })
        }
    }
}
