//! `dualarm verify`

use std::time::Instant;

use clap::Args;

use super::fmus::Job;
use super::package::say;
use super::{Failure, print};
use crate::figures::raster;
use crate::files;
use crate::verify::{Fmus, verify};

/// Arguments of `dualarm verify`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    job: Job,
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    arguments.job.package(quiet)?;
    let begin = Instant::now();
    let fmus = Fmus::open(&arguments.job.folder.fmus)?;
    let result = verify(&fmus, &mut |doing| say(quiet, doing))?;

    let svg = result.figure.figure.to_svg();
    let png = raster::to_png(&svg)
        .map_err(|reason| Failure { code: 1, message: format!("cannot draw {}: {reason}", result.figure.name) })?;
    let figures = arguments.job.out.join("figures");
    files::write(figures.join(format!("{}.svg", result.figure.name)), svg)?;
    files::write(figures.join(format!("{}.png", result.figure.name)), png)?;
    files::write(arguments.job.out.join("verification.csv"), result.to_csv())?;
    let report = arguments.job.out.join("verification.md");
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
