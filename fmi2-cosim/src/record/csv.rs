//! Rows as comma-separated values (RFC 4180).

use std::io::{self, Write};

use super::{Column, Sink};
use crate::files::{NewFile, WriteError};

/// Rows as CSV: a header with `time` and the names, then one line per row in the shortest digits that read back exactly.
pub struct CsvSink<W: Write> {
    writer: ::csv::Writer<W>,
    digits: String,
}

impl CsvSink<NewFile> {
    /// Begins the file with the header.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn new(file: NewFile, columns: &[Column]) -> Result<Self, WriteError> {
        let mut sink = Self::to(file);
        match sink.header(columns) {
            Ok(()) => Ok(sink),
            Err(source) => Err(sink.error(source)),
        }
    }

    /// Makes an error of this file's path.
    #[must_use]
    pub fn error(&self, source: io::Error) -> WriteError {
        self.writer.get_ref().error(source)
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// When not everything could be written.
    pub fn finish(self) -> Result<(), WriteError> {
        self.into_file()?.finish()
    }

    /// The file with all rows in it.
    ///
    /// # Errors
    /// When not everything could be written.
    pub fn into_file(mut self) -> Result<NewFile, WriteError> {
        if let Err(source) = self.writer.flush() {
            return Err(self.error(source));
        }
        match self.writer.into_inner() {
            Ok(file) => Ok(file),
            Err(_) => unreachable!("the buffer was flushed before"),
        }
    }
}

impl<W: Write> CsvSink<W> {
    /// CSV to anything that takes bytes; write the header next.
    pub fn to(writer: W) -> Self {
        Self { writer: ::csv::Writer::from_writer(writer), digits: String::new() }
    }

    /// Returns the writer.
    ///
    /// # Errors
    /// When buffered data cannot be written.
    pub fn into_inner(self) -> io::Result<W> {
        self.writer.into_inner().map_err(|error| io::Error::new(error.error().kind(), error.error().to_string()))
    }

    /// Writes the header.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn header(&mut self, columns: &[Column]) -> io::Result<()> {
        let names = std::iter::once("time").chain(columns.iter().map(|column| column.name.as_str()));
        self.writer.write_record(names).map_err(plain)
    }

    fn field(&mut self, value: f64) -> io::Result<()> {
        use std::fmt::Write;
        self.digits.clear();
        // + 0 makes zero of minus zero, which would print as -0.
        write!(self.digits, "{:?}", value + 0.0).expect("writing to a string cannot fail");
        let digits = self.digits.strip_suffix(".0").unwrap_or(&self.digits);
        self.writer.write_field(digits).map_err(plain)
    }
}

impl<W: Write> Sink for CsvSink<W> {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.field(time)?;
        for value in values {
            self.field(*value)?;
        }
        self.writer.write_record(None::<&[u8]>).map_err(plain)
    }
}

/// The error inside the CSV writer's error. Its kind says whether the reader has closed the pipe.
fn plain(error: ::csv::Error) -> io::Error {
    match error.into_kind() {
        ::csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}
