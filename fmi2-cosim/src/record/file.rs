//! Rows in a file of either format.

use std::io;
use std::path::Path;

use super::{Column, CsvSink, ParquetSink, Sink};
use crate::files::{NewFile, WriteError, has_extension};

/// Rows in a file that appears when it is finished: Parquet if its extension is `.parquet`, CSV otherwise. Boxed, since
/// both are large.
pub enum FileSink {
    /// Text, row by row.
    Csv(Box<CsvSink<NewFile>>),
    /// By columns.
    Parquet(Box<ParquetSink>),
}

impl FileSink {
    /// Begins the file; `tool` is the program that a Parquet file names as its creator.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn new(path: &Path, columns: &[Column], tool: &str) -> Result<Self, WriteError> {
        let file = NewFile::create(path)?;
        Ok(if has_extension(path, "parquet") {
            Self::Parquet(Box::new(ParquetSink::new(file, columns, tool)?))
        } else {
            Self::Csv(Box::new(CsvSink::new(file, columns)?))
        })
    }

    /// Makes an error of this file's path.
    #[must_use]
    pub fn error(&self, source: io::Error) -> WriteError {
        match self {
            Self::Csv(sink) => sink.error(source),
            Self::Parquet(sink) => sink.error(source),
        }
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// When not everything could be written.
    pub fn finish(self) -> Result<(), WriteError> {
        match self {
            Self::Csv(sink) => sink.finish(),
            Self::Parquet(sink) => sink.finish(),
        }
    }
}

impl Sink for FileSink {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        match self {
            Self::Csv(sink) => sink.row(time, values),
            Self::Parquet(sink) => sink.row(time, values),
        }
    }
}
