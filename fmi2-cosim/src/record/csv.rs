//! Rows as comma-separated values (RFC 4180).

use std::io::{self, BufWriter, Write};

use super::digits::{self, LONGEST};
use super::{Column, Sink};
use crate::files::{NewFile, WriteError};

/// Rows as CSV: a header with `time` and the names, then one line per row in the shortest digits that read back exactly.
pub struct CsvSink<W: Write> {
    writer: BufWriter<W>,
    text: Text,
}

/// Rows as text. It does not depend on what is written to, so it is compiled here and not by the caller.
#[derive(Default)]
struct Text {
    /// The last row, and the one before it, each with room after it.
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
    /// A separator, and room for a number.
    const MOST: usize = 1 + LONGEST;

    /// The text of a row.
    fn of(&mut self, time: f64, values: &[f64]) -> &[u8] {
        let Self { line, before, last } = self;
        std::mem::swap(line, before);
        let room = Self::MOST * (values.len() + 2);
        if line.len() < room || last.len() != values.len() {
            line.resize(room, 0);
            before.resize(room, 0);
            last.clear();
            last.resize(values.len(), (0, 0, 0));
        }
        // Numbers need no quotes.
        let mut at = put(time, line, 0);
        for ((bits, from, to), value) in last.iter_mut().zip(values) {
            let begin = at;
            // A fifth of all values are those of the row before.
            if value.to_bits() == *bits && from < to {
                // All of the room is copied in one piece.
                let text: &mut [u8] = &mut line[at..at + Self::MOST];
                text.copy_from_slice(&before[*from..*from + Self::MOST]);
                at += *to - *from;
            } else {
                *bits = value.to_bits();
                line[at] = b',';
                at = put(*value, line, at + 1);
            }
            (*from, *to) = (begin, at);
        }
        line[at] = b'\n';
        &line[..=at]
    }
}

/// Writes a number at a place of a line, and returns the place after it.
#[inline]
fn put(value: f64, line: &mut [u8], at: usize) -> usize {
    match line[at..].first_chunk_mut() {
        Some(room) => at + digits::put(value, room),
        None => unreachable!("a line has room for all of its numbers"),
    }
}

/// The error inside the CSV writer's error. Its kind says whether the reader has closed the pipe.
fn plain(error: ::csv::Error) -> io::Error {
    match error.into_kind() {
        ::csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}
