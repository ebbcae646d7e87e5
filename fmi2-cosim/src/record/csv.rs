//! Rows as comma-separated values (RFC 4180).

use std::io::{self, BufWriter, Write};

use super::{Column, Sink, digits};
use crate::files::{NewFile, WriteError};

/// Rows as CSV: a header with `time` and the names, then one line per row in the shortest digits that read back exactly.
pub struct CsvSink<W: Write> {
    writer: BufWriter<W>,
    /// The row that is being written.
    line: Line,
    /// The row before it: many values stay as they are.
    before: Line,
}

/// A row as text.
#[derive(Default)]
struct Line {
    text: Vec<u8>,
    values: Vec<f64>,
    /// Where the text of each value ends.
    ends: Vec<usize>,
}

impl Line {
    /// Appends a value and a comma, with the same text as in the row before if it is the same number.
    fn push(&mut self, value: f64, before: &Self) {
        let place = self.values.len();
        match before.values.get(place) {
            Some(known) if known.to_bits() == value.to_bits() => {
                let begin = place.checked_sub(1).map_or(0, |last| before.ends[last]);
                self.text.extend_from_slice(&before.text[begin..before.ends[place]]);
            }
            _ => {
                digits::push(value, &mut self.text);
                self.text.push(b',');
            }
        }
        self.values.push(value);
        self.ends.push(self.text.len());
    }

    fn clear(&mut self) {
        self.text.clear();
        self.values.clear();
        self.ends.clear();
    }
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
        Self { writer: BufWriter::new(writer), line: Line::default(), before: Line::default() }
    }

    /// Returns the writer.
    ///
    /// # Errors
    /// When buffered data cannot be written.
    pub fn into_inner(self) -> io::Result<W> {
        self.writer.into_inner().map_err(io::IntoInnerError::into_error)
    }

    /// Writes the header.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn header(&mut self, columns: &[Column]) -> io::Result<()> {
        let names = std::iter::once("time").chain(columns.iter().map(|column| column.name.as_str()));
        let mut header = ::csv::Writer::from_writer(Vec::new());
        header.write_record(names).map_err(plain)?;
        let header = header.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
        self.writer.write_all(&header)
    }
}

impl<W: Write> Sink for CsvSink<W> {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        // Numbers need no quotes.
        std::mem::swap(&mut self.line, &mut self.before);
        self.line.clear();
        self.line.push(time, &self.before);
        for value in values {
            self.line.push(*value, &self.before);
        }
        // A line ends instead of its last comma.
        let last = self.line.text.len() - 1;
        self.writer.write_all(&self.line.text[..last])?;
        self.writer.write_all(b"\n")
    }
}

/// The error inside the CSV writer's error. Its kind says whether the reader has closed the pipe.
fn plain(error: ::csv::Error) -> io::Error {
    match error.into_kind() {
        ::csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}
