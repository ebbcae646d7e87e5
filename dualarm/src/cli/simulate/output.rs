//! Where the rows go: nowhere, to a file in the format of its extension, or to standard output as CSV.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};

use crate::cli::printable::one_line;
use crate::cli::{Failure, process};
use fmi2_cosim::files::{self, NewFile};
use fmi2_cosim::record::{Column, CsvSink, ParquetSink, Sink};

/// Takes the recorded rows.
pub enum Output {
    /// The user did not ask for rows.
    None,
    /// A file that appears when the run is over.
    Csv(CsvSink<NewFile>),
    /// The same, by columns; boxed, since it is much larger than the others.
    Parquet(Box<ParquetSink>),
    /// Standard output.
    Pipe(CsvSink<BufWriter<&'static File>>),
}

/// What a file says about the program that wrote it.
const TOOL: &str = concat!("dualarm ", env!("CARGO_PKG_VERSION"));

/// What the rows are written as.
enum Format {
    Csv,
    Parquet,
}

impl Format {
    /// The one that a file's name promises.
    fn of(path: &Path) -> Result<Self, Failure> {
        let Some(extension) = path.extension() else { return Ok(Self::Csv) };
        match extension.to_string_lossy().to_lowercase().as_str() {
            "csv" | "txt" | "dat" => Ok(Self::Csv),
            "parquet" => Ok(Self::Parquet),
            _ if path.metadata().is_ok_and(|metadata| !metadata.is_file()) => Ok(Self::Csv),
            other => Err(Failure::usage(format!(
                "-o {}: this tool writes .csv and .parquet files, not .{other}; most tools that read .{other} read one of them",
                path.display()
            ))),
        }
    }
}

/// Whether these words after `-o` mean standard output.
pub fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == "-" || files::is_standard_output(path)
}

impl Output {
    /// Whether rows can be written there: in a format that the name promises, and not onto what the run reads.
    pub fn check(path: Option<&Path>, inputs: &[PathBuf]) -> Result<(), Failure> {
        let Some(path) = path.filter(|path| !is_standard_output(path)) else { return Ok(()) };
        Format::of(path)?;
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
            return Ok(Self::Pipe(sink));
        }
        let file = NewFile::create(path)?;
        Ok(match Format::of(path)? {
            Format::Parquet => Self::Parquet(Box::new(ParquetSink::new(file, columns, TOOL)?)),
            Format::Csv => Self::Csv(CsvSink::new(file, columns)?),
        })
    }

    /// Whether standard output carries the rows.
    pub fn is_pipe(&self) -> bool {
        matches!(self, Self::Pipe(_))
    }

    /// What to tell the user about a row that could not be written.
    pub fn failure(&self, error: io::Error) -> Failure {
        match self {
            Self::Csv(sink) => sink.error(error).into(),
            Self::Parquet(sink) => sink.error(error).into(),
            _ => lost(error),
        }
    }

    /// Ends the output; a file appears at its place.
    pub fn finish(self) -> Result<(), Failure> {
        match self {
            Self::None => {}
            Self::Csv(sink) => sink.finish()?,
            Self::Parquet(sink) => sink.finish()?,
            Self::Pipe(sink) => sink.into_inner().and_then(|mut writer| writer.flush()).map_err(lost)?,
        }
        Ok(())
    }
}

/// Rows that did not reach standard output. A reader that has seen enough (`| head`) still did not get all of them.
#[allow(clippy::needless_pass_by_value)] // it is given to map_err
fn lost(error: io::Error) -> Failure {
    Failure::failed(match error.kind() {
        io::ErrorKind::BrokenPipe => "the reader of standard output has gone before it had all rows".to_owned(),
        _ => format!("cannot write to standard output: {error}"),
    })
}

impl Sink for Output {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        match self {
            Self::None => Ok(()),
            Self::Csv(sink) => sink.row(time, values),
            Self::Parquet(sink) => sink.row(time, values),
            Self::Pipe(sink) => sink.row(time, values),
        }
    }
}
