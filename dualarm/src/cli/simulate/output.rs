//! Where the rows go: nowhere, to a file in the format of its extension, or to standard output as CSV.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};

use crate::TOOL;
use crate::cli::printable::one_line;
use crate::cli::{Failure, process};
use fmi2_cosim::files;
use fmi2_cosim::record::{Column, CsvSink, FileSink, Sink};

/// Takes the recorded rows.
pub enum Output {
    /// No rows were requested.
    None,
    /// A file that appears when the run is over.
    File(FileSink),
    /// Standard output.
    Pipe(Box<CsvSink<BufWriter<&'static File>>>),
}

/// Whether there is a format that the file's name promises.
fn check_format(path: &Path) -> Result<(), Failure> {
    let Some(extension) = path.extension() else { return Ok(()) };
    match extension.to_string_lossy().to_lowercase().as_str() {
        "csv" | "txt" | "dat" | "parquet" => Ok(()),
        _ if path.metadata().is_ok_and(|metadata| !metadata.is_file()) => Ok(()),
        _ => Err(Failure::usage(format!(
            "-o {}: here -o takes a .csv or .parquet file, for the outputs over time; curves and the arms in motion: --report \
             {}",
            path.display(),
            path.with_extension("html").display()
        ))),
    }
}

/// Whether these words after `-o` mean standard output.
pub fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == "-" || files::is_standard_output(path)
}

impl Output {
    /// Checks that rows can be written there: the extension must be that of a known format, and the file must not be one
    /// that the run reads.
    pub fn check(path: Option<&Path>, inputs: &[PathBuf]) -> Result<(), Failure> {
        let Some(path) = path.filter(|path| !is_standard_output(path)) else { return Ok(()) };
        check_format(path)?;
        match inputs.iter().find(|input| files::are_same(input, path)) {
            Some(input) => Err(Failure::usage(format!(
                "-o {} would overwrite {}, which this run reads",
                path.display(),
                input.display()
            ))),
            None => Ok(()),
        }
    }

    /// Begins the output with the names of its columns; `-` is standard output.
    pub fn new(path: Option<&Path>, columns: &[Column]) -> Result<Self, Failure> {
        let Some(path) = path else { return Ok(Self::None) };
        if is_standard_output(path) {
            process::check_standard_output()
                .map_err(|error| Failure::failed(format!("cannot write to standard output: {error}")))?;
            let standard_output = process::standard_output();
            let mut sink = CsvSink::to(BufWriter::new(standard_output));
            let mut columns = columns.to_vec();
            if standard_output.is_terminal() {
                for column in &mut columns {
                    column.name = one_line(&column.name).into_owned();
                }
            }
            sink.header(&columns)?;
            return Ok(Self::Pipe(Box::new(sink)));
        }
        check_format(path)?;
        Ok(Self::File(FileSink::new(path, columns, TOOL)?))
    }

    /// Whether standard output carries the rows.
    pub fn is_pipe(&self) -> bool {
        matches!(self, Self::Pipe(_))
    }

    /// The failure for a row that could not be written.
    pub fn failure(&self, error: io::Error) -> Failure {
        match self {
            Self::File(sink) => sink.error(error).into(),
            _ => lost(error),
        }
    }

    /// Ends the output; a file appears at its place.
    pub fn finish(self) -> Result<(), Failure> {
        match self {
            Self::None => {}
            Self::File(sink) => sink.finish()?,
            Self::Pipe(sink) => sink.into_inner().and_then(|mut writer| writer.flush()).map_err(lost)?,
        }
        Ok(())
    }
}

/// The failure for rows that did not reach standard output. A reader that stops early (`| head`) did not get all of them
/// either.
#[allow(clippy::needless_pass_by_value)] // it is given to map_err
fn lost(error: io::Error) -> Failure {
    Failure::failed(match error.kind() {
        io::ErrorKind::BrokenPipe => "the reader of standard output has gone before it had all rows".to_owned(),
        _ => format!("cannot write to standard output: {error}"),
    })
}

impl Sink for Output {
    fn wants(&mut self, _: f64) -> bool {
        !matches!(self, Self::None)
    }

    fn idle(&mut self) -> f64 {
        if matches!(self, Self::None) { f64::INFINITY } else { f64::NEG_INFINITY }
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        match self {
            Self::None => Ok(()),
            Self::File(sink) => sink.row(time, values),
            Self::Pipe(sink) => sink.row(time, values),
        }
    }
}
