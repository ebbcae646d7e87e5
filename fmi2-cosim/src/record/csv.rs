//! Rows as comma-separated values (RFC 4180).

use std::io::{self, BufWriter, Write};

use super::{Column, Sink, digits};
use crate::files::{NewFile, WriteError};

/// Rows as CSV: a header with `time` and the names, then one line per row in the shortest digits that read back exactly.
pub struct CsvSink<W: Write> {
    writer: BufWriter<W>,
    text: Text,
}

/// Rows as text. It does not depend on what is written to, so it is compiled here and not by the caller.
#[derive(Default)]
struct Text {
    /// The last row, and the one before it.
    line: Vec<u8>,
    before: Vec<u8>,
    /// For each column its last value, and where in the last row its text begins and ends.
    last: Vec<(u64, usize, usize)>,
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
        Self { writer: BufWriter::new(writer), text: Text::default() }
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
        self.writer.write_all(self.text.of(time, values))
    }
}

impl Text {
    /// The text of a row.
    fn of(&mut self, time: f64, values: &[f64]) -> &[u8] {
        let Self { line, before, last } = self;
        std::mem::swap(line, before);
        line.clear();
        last.resize(values.len(), (0, 0, 0));
        // Numbers need no quotes.
        digits::push(time, line);
        for (index, value) in values.iter().enumerate() {
            let (bits, from, to) = &mut last[index];
            let begin = line.len();
            // A fifth of all values are those of the row before.
            if value.to_bits() == *bits && from < to {
                line.extend_from_slice(&before[*from..*to]);
            } else {
                *bits = value.to_bits();
                line.push(b',');
                digits::push(*value, line);
            }
            (*from, *to) = (begin, line.len());
        }
        line.push(b'\n');
        line
    }
}

/// The error inside the CSV writer's error. Its kind says whether the reader has closed the pipe.
fn plain(error: ::csv::Error) -> io::Error {
    match error.into_kind() {
        ::csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}
