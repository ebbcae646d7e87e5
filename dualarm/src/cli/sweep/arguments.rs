//! The command line of `dualarm sweep`.

use std::ffi::OsString;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::fmus::FmuFolder;
use crate::cli::{Failure, numbers};
use crate::sweep::SweepError;
use crate::sweep::plan::{OtherPoints, Plan};
use crate::sweep::study::Coordinates;

const AFTER_HELP: &str = "\
A study file (TOML) says which system runs how often, and what is drawn for each run: docs/studies.md. The result has one \
row a run, in the order of runs; it does not depend on the number of workers, nor on interruptions: the same command \
goes on where the last one was ended. A run that fails is a row with its error. FMUs that crash, exit or hang need \
--isolated.

Examples:
  dualarm sweep study.toml                        on all cores
  dualarm sweep study.toml -o out.csv --report out.html
  dualarm sweep study.toml --isolated --timeout 5 runs in processes of their own
  dualarm sweep study.toml --runs 0..100          the first hundred only
  dualarm sweep study.toml --run 42 -o 42.parquet one run, with its trajectory
  dualarm sweep study.toml --points saltelli.csv --unit
                                                  points of your own
  python examples/sweep_dask.py study.toml        the same on a cluster";

/// Arguments of `dualarm sweep`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
#[allow(clippy::struct_excessive_bools)] // each is a switch of the command line
pub struct Arguments {
    /// Study file (.toml)
    pub study: PathBuf,
    /// Write the rows to this file, as Parquet if it ends in .parquet, as CSV if in .csv; of --run, its trajectory
    /// [default: results/STUDY.parquet]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Keep the rows that are done in this file [default: beside the output, .jsonl]
    #[arg(long, value_name = "FILE", conflicts_with = "run")]
    pub state: Option<PathBuf>,
    /// How many runs at once [default: as many as there are processors]
    #[arg(long, value_name = "COUNT", value_parser = numbers::count)]
    pub workers: Option<usize>,
    /// Give runs worker processes, which may crash and hang: each of that is a row, and the worker is replaced
    #[arg(long)]
    pub isolated: bool,
    /// How long a run may take, in s; with --isolated, which it implies [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    pub timeout: Option<f64>,
    /// Only these runs, from A to before B
    #[arg(long, value_name = "A..B", value_parser = range, conflicts_with = "run")]
    pub runs: Option<Range<u64>>,
    /// Simulate one run again and write its trajectory to --output [default: results/STUDY-run-N.parquet]
    #[arg(long, value_name = "N", value_parser = numbers::index, conflicts_with_all = ["trajectories", "report", "isolated", "timeout"])]
    pub run: Option<u64>,
    /// Write the trajectory of every run to this folder
    #[arg(long, value_name = "FOLDER")]
    pub trajectories: Option<PathBuf>,
    /// Take the points from this table (.csv, .parquet) instead of the study's
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// The numbers of --points are coordinates from 0 to 1 in the study's ranges, not values
    #[arg(long, requires = "points")]
    pub unit: bool,
    /// Write a page to look at the runs in a browser to this file (.html); missing folders are created
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub folder: FmuFolder,
    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
    /// Be a worker: read numbers of runs, one a line, answer each with its row as JSON
    #[arg(long, hide = true)]
    pub worker: bool,
}

fn range(text: &str) -> Result<Range<u64>, String> {
    let ends = text.split_once("..").map(|(low, high)| (low.trim().parse(), high.trim().parse()));
    match ends {
        Some((Ok(low), Ok(high))) if low < high => Ok(low..high),
        _ => Err("write A..B with whole numbers, A below B".into()),
    }
}

impl Arguments {
    pub fn plan(&self) -> Result<Plan, SweepError> {
        let coordinates = if self.unit { Coordinates::Unit } else { Coordinates::Values };
        Plan::read(&self.study, self.points.as_deref().map(|file| OtherPoints { file, coordinates }))
    }

    /// The time a run may take, if there is a limit.
    pub fn limit(&self) -> Result<Option<Duration>, Failure> {
        const DEFAULT: f64 = 60.0;
        let seconds = self.timeout.or(self.isolated.then_some(DEFAULT));
        let limit = |seconds: f64| match Duration::try_from_secs_f64(seconds) {
            Ok(limit) if !limit.is_zero() => Ok(limit),
            _ => Err(Failure::usage("--timeout must be a positive number of seconds")),
        };
        seconds.map(limit).transpose()
    }

    /// A file in `results` that is named after the study.
    pub fn default_output(&self, rest: &str) -> PathBuf {
        let stem = self.study.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        PathBuf::from("results").join(stem + rest)
    }

    /// The options that make a run of this study, to be typed again.
    pub fn options(&self) -> Vec<OsString> {
        let mut words: Vec<OsString> = vec!["sweep".into(), self.study.clone().into()];
        if let Some(points) = &self.points {
            words.extend(["--points".into(), points.clone().into()]);
        }
        if self.unit {
            words.push("--unit".into());
        }
        if self.folder.fmus != FmuFolder::default().fmus {
            words.extend(["--fmus".into(), self.folder.fmus.clone().into()]);
        }
        words
    }
}
