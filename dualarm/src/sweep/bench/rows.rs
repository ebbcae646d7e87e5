//! The trajectory of one run, in a file.

use std::io;
use std::path::Path;

use super::TOOL;
use fmi2_cosim::files::{NewFile, WriteError};
use fmi2_cosim::record::{Column, CsvSink, ParquetSink, Sink};

/// The rows of one run, in a file.
pub(super) enum Rows {
    Csv(Box<CsvSink<NewFile>>),
    Parquet(Box<ParquetSink>),
}

impl Rows {
    pub(super) fn new(path: &Path, columns: &[Column]) -> Result<Self, WriteError> {
        let file = NewFile::create(path)?;
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("parquet")) {
            return Ok(Self::Parquet(Box::new(ParquetSink::new(file, columns, TOOL)?)));
        }
        Ok(Self::Csv(Box::new(CsvSink::new(file, columns)?)))
    }

    pub(super) fn finish(self) -> Result<(), WriteError> {
        match self {
            Self::Csv(sink) => sink.finish(),
            Self::Parquet(sink) => sink.finish(),
        }
    }
}

impl Sink for Rows {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        match self {
            Self::Csv(sink) => sink.row(time, values),
            Self::Parquet(sink) => sink.row(time, values),
        }
    }
}
