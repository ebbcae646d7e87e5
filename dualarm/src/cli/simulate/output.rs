//! Where the rows go: nowhere, to a file in the format of its extension, or to standard output as CSV.

use std::io::{self, Write};
use std::path::PathBuf;

use crate::cli::Failure;
use fmi2_cosim::files::NewFile;
use fmi2_cosim::record::{Column, CsvSink, ParquetSink, Sink};

/// Takes the recorded rows.
pub enum Output {
    /// Nobody asked for them.
    None,
    /// A file that appears when the run is over.
    Csv(CsvSink<NewFile>),
    /// The same, by columns; boxed, since it is much larger than the others.
    Parquet(Box<ParquetSink>),
    /// Standard output.
    Pipe(CsvSink<io::BufWriter<io::Stdout>>),
}

impl Output {
    /// Begins the output with the names of its columns; `-` is standard output, `.parquet` makes Parquet, everything else
    /// CSV.
    pub fn new(path: Option<PathBuf>, columns: &[Column]) -> Result<Self, Failure> {
        Ok(match path {
            None => Self::None,
            Some(path) if path.as_os_str() == "-" => {
                let mut sink = CsvSink::to(io::BufWriter::new(io::stdout()));
                match sink.header(columns) {
                    // A reader that has already gone is noticed again with the first row.
                    Err(error) if error.kind() != io::ErrorKind::BrokenPipe => return Err(error.into()),
                    _ => {}
                }
                Self::Pipe(sink)
            }
            Some(path) if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("parquet")) => {
                Self::Parquet(Box::new(ParquetSink::new(NewFile::create(path)?, columns)?))
            }
            Some(path) => Self::Csv(CsvSink::new(NewFile::create(path)?, columns)?),
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
            _ => error.into(),
        }
    }

    /// Ends the output; a file appears at its place.
    pub fn finish(self) -> Result<(), Failure> {
        match self {
            Self::None => {}
            Self::Csv(sink) => sink.finish()?,
            Self::Parquet(sink) => sink.finish()?,
            Self::Pipe(sink) => match sink.into_inner().and_then(|mut writer| writer.flush()) {
                Err(error) if error.kind() != io::ErrorKind::BrokenPipe => return Err(error.into()),
                _ => {}
            },
        }
        Ok(())
    }
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
