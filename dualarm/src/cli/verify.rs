//! `dualarm verify`

use std::path::Path;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::fmus::Job;
use super::package::say;
use super::{Failure, json, print, width};
use crate::verify::{Check, Fmus, verify};
use charts::raster;
use fmi2_cosim::files::FileSet;

/// Arguments of `dualarm verify`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    job: Job,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// The document of `--json`; `docs/tool.md` describes the keys.
#[derive(Serialize)]
struct Document<'a> {
    command: &'static str,
    version: &'static str,
    /// In s.
    wall_time: f64,
    failures: usize,
    checks: Vec<CheckDocument<'a>>,
    report: &'a Path,
}

#[derive(Serialize)]
struct CheckDocument<'a> {
    subject: &'static str,
    check: &'a str,
    exact: &'a str,
    found: &'a str,
    error: f64,
    bound: f64,
    unit: &'static str,
    passes: bool,
}

impl<'a> From<&'a Check> for CheckDocument<'a> {
    fn from(check: &'a Check) -> Self {
        Self {
            subject: check.subject.title(),
            check: &check.what,
            exact: &check.exact,
            found: &check.found,
            error: check.error,
            bound: check.bound,
            unit: check.unit,
            passes: check.passes(),
        }
    }
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    arguments.job.package(quiet)?;
    let begin = Instant::now();
    let fmus = Fmus::open(&arguments.job.folder.fmus)?;
    let result = verify(&fmus, &mut |doing| say(quiet, doing))?;

    let svg = result.figure.figure.to_svg();
    let png = raster::to_png(&svg)
        .map_err(|reason| Failure::failed(format!("cannot draw {}: {reason}", result.figure.name)))?;
    let figures = arguments.job.out.join("figures");
    let written = FileSet::new();
    written.write(figures.join(format!("{}.svg", result.figure.name)), svg)?;
    written.write(figures.join(format!("{}.png", result.figure.name)), png)?;
    written.write(arguments.job.out.join("verification.csv"), result.to_csv())?;
    let report = arguments.job.out.join("verification.md");
    written.write(&report, result.to_markdown())?;
    written.appear()?;

    if arguments.json {
        json::print(&Document {
            command: "verify",
            version: env!("CARGO_PKG_VERSION"),
            wall_time: begin.elapsed().as_secs_f64(),
            failures: result.failures(),
            checks: result.checks.iter().map(CheckDocument::from).collect(),
            report: &report,
        })?;
    } else if !quiet {
        for (title, table) in result.tables() {
            print(&format!("{title}\n\n{}\n", table.to_terminal(width())));
        }
        let seconds = begin.elapsed().as_secs_f64();
        print(&format!("{} checks in {seconds:.1} s; {}\n", result.checks.len(), report.display()));
    }
    match result.failures() {
        0 => Ok(()),
        broken => Err(Failure::failed(format!("{broken} of {} checks are out of bounds", result.checks.len()))),
    }
}
