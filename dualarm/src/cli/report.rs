//! `dualarm report`, and the pages of the commands that run something.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{Failure, print, print_error};
use crate::report::html::{Packed, Page, Run, rows, signals};
use fmi2_cosim::files::{self, FileSet, has_extension};
use fmi2_cosim::record::{self, ReadError};
use grasp_merit::metrics::Metrics;

const AFTER_HELP: &str = "\
Results are CSV or Parquet files with a column of times, of this tool or any other: FMPy, OMSimulator, Simulink, Dymola. \
Runs of a grasp (columns theta1, theta2, y_object, …, also as system.plant.theta1) are shown in motion and judged; of \
other systems the page has linked curves. Several files are overlaid.

Examples:
  dualarm report run.csv                              run.html
  dualarm report mine.csv pds.parquet -o page.html    your controller and ours
  dualarm report a.csv b.csv --names before,after";

/// The number of runs that a page can distinguish by colour.
pub const MOST_RUNS: usize = 8;

/// Arguments of `dualarm report`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Results: .csv or .parquet files
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Write the page to this file (.html); missing folders are created [default: the first file's name with .html]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// What the page calls the runs [default: the files' names]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    names: Vec<String>,
    /// Heading of the page
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    let Arguments { files, output, names, title } = arguments;
    if files.len() > MOST_RUNS {
        return Err(Failure::usage(format!("a page shows up to {MOST_RUNS} runs, not {}", files.len())));
    }
    if !names.is_empty() && names.len() != files.len() {
        return Err(Failure::usage(format!("--names has {} names for {} files", names.len(), files.len())));
    }
    let path = output.clone().unwrap_or_else(|| files[0].with_extension("html"));
    check(&path, files)?;
    let mut runs = Vec::new();
    for (index, file) in files.iter().enumerate() {
        let stem = file.file_stem().map_or_else(|| "run".into(), |stem| stem.to_string_lossy().into_owned());
        let name = names.get(index).cloned().unwrap_or(stem);
        runs.push(saved(file, name, quiet)?);
    }
    let names: Vec<&str> = runs.iter().map(|run| run.title.as_str()).collect();
    let page = Page {
        title: title.clone().unwrap_or_else(|| names.join(", ")),
        lead: "Saved results, read and drawn by dualarm report.".into(),
        runs: &runs,
        rows: "Metrics are of all rows of each file.".into(),
        ..Page::default()
    };
    write(&page, &path)?;
    if !quiet {
        print(&format!("{}\n", path.display()));
    }
    Ok(())
}

/// A file of results as a run.
fn saved(file: &Path, title: String, quiet: bool) -> Result<Run, Failure> {
    let saved = record::read(file)?;
    if !saved.names_time() && !quiet {
        print_error(&format!(
            "warning: {}: no column is called time; the first one of numbers, \"{}\", is taken for the times in s\n",
            file.display(),
            saved.time
        ));
    }
    let mut table = saved.table;
    signals::rename_known(&mut table);
    let metrics = Metrics::of(&table, [None; 3]).ok();
    let (rows, said) = rows::of_saved(&table);
    let notes = vec![format!("{}: {said}", file.display())];
    let rows = Packed::of(&rows, &[]);
    Ok(Run { key: title.clone(), title, rows, metrics, notes, ..Run::default() })
}

/// Checks that a page can be written there: the extension must be that of a page, and the file must not be one of the
/// inputs.
pub fn check(path: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
    if !has_extension(path, "html") {
        return Err(Failure::usage(format!(
            "the page {} must end in .html: it has curves, tables and data in one file",
            path.display()
        )));
    }
    match inputs.iter().find(|input| files::are_same(input, path)) {
        Some(input) => Err(Failure::usage(format!(
            "the page {} would overwrite {}, which is read",
            path.display(),
            input.display()
        ))),
        None => Ok(()),
    }
}

/// Writes a page; it appears whole or not at all.
pub fn write(page: &Page, path: &Path) -> Result<(), Failure> {
    let written = FileSet::new();
    written.write(path, page.to_html())?;
    Ok(written.appear()?)
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::File { .. } => Self::failed(error),
            ReadError::NoTimes { .. } => Self::usage(format!(
                "{error}. `dualarm simulate -o FILE` writes one, and `dualarm sweep STUDY --run N -o FILE` that of one run of a study"
            )),
            _ => Self::usage(error),
        }
    }
}
