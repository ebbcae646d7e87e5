//! Rows as comma-separated values (RFC 4180).

use std::io::{self, Write};

use super::digits::{self, LONGEST};
use super::{Column, Sink};
use crate::files::{NewFile, WriteError};

/// Rows as CSV: a header with `time` and the names, then one line per row in the shortest digits that read back exactly.
pub struct CsvSink<W: Write> {
    writer: W,
    text: Text,
    /// Rows are written as soon as they are longer than this.
    most: usize,
}

/// Rows as text, many of which are written at once. It does not depend on what is written to, so it is compiled here and not by the
/// caller.
#[derive(Default)]
struct Text {
    /// The rows that are not written yet, with room after them.
    block: Vec<u8>,
    /// How long these are.
    length: usize,
    /// For each column its last value, and where its text begins and ends.
    last: Vec<(u64, usize, usize)>,
}

impl CsvSink<NewFile> {
    /// Begins the file with the header.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn new(file: NewFile, columns: &[Column]) -> Result<Self, WriteError> {
        // If the run fails, nobody misses the rows that are not written.
        let mut sink = Self { most: Text::FULL, ..Self::to(file) };
        match sink.header(columns) {
            Ok(()) => Ok(sink),
            Err(source) => Err(sink.error(source)),
        }
    }

    /// Makes an error of this file's path.
    #[must_use]
    pub fn error(&self, source: io::Error) -> WriteError {
        self.writer.error(source)
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
        match self.flush() {
            Ok(()) => Ok(self.writer),
            Err(source) => Err(self.error(source)),
        }
    }
}

impl<W: Write> CsvSink<W> {
    /// CSV to anything that takes bytes, which it gets row by row; write the header next.
    pub fn to(writer: W) -> Self {
        Self { writer, text: Text::default(), most: 0 }
    }

    /// Returns the writer.
    ///
    /// # Errors
    /// When the last rows cannot be written.
    pub fn into_inner(mut self) -> io::Result<W> {
        self.flush()?;
        Ok(self.writer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.write_all(self.text.take())?;
        self.writer.flush()
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
        self.text.add(time, values);
        if self.text.length > self.most { self.writer.write_all(self.text.take()) } else { Ok(()) }
    }
}

impl Text {
    /// So many bytes of a file are written at once.
    const FULL: usize = 1 << 17;
    /// A separator, and room for a number.
    const MOST: usize = 1 + LONGEST;

    /// Adds the text of a row.
    fn add(&mut self, time: f64, values: &[f64]) {
        let Self { block, length, last } = self;
        let room = *length + Self::MOST * (values.len() + 2);
        if block.len() < room {
            block.resize(room.max(Self::FULL + Self::FULL / 8), 0);
        }
        last.resize(values.len(), (0, 0, 0));
        // Numbers need no quotes.
        let mut at = put(time, block, *length);
        for ((bits, from, to), value) in last.iter_mut().zip(values) {
            let begin = at;
            // A fifth of all values are those of the row before.
            if value.to_bits() == *bits && from < to {
                // All of the room is copied, which is a few instructions.
                if let Some(text) = block[*from..].first_chunk::<{ Self::MOST }>().copied()
                    && let Some(here) = block[at..].first_chunk_mut()
                {
                    *here = text;
                }
                at += *to - *from;
            } else {
                *bits = value.to_bits();
                block[at] = b',';
                at = put(*value, block, at + 1);
            }
            (*from, *to) = (begin, at);
        }
        block[at] = b'\n';
        *length = at + 1;
    }

    /// The rows, which it has no more.
    fn take(&mut self) -> &[u8] {
        // The next row finds no text of a row before.
        self.last.clear();
        &self.block[..std::mem::take(&mut self.length)]
    }
}

/// Writes a number at a place, and returns the place after it.
#[inline]
fn put(value: f64, text: &mut [u8], at: usize) -> usize {
    match text[at..].first_chunk_mut() {
        Some(room) => at + digits::put(value, room),
        None => unreachable!("there is room for all numbers of a row"),
    }
}

/// The error inside the CSV writer's error. Its kind says whether the reader has closed the pipe.
fn plain(error: ::csv::Error) -> io::Error {
    match error.into_kind() {
        ::csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}
