//! What a run leaves behind: rows of values over time, kept in memory or written as CSV.

use std::io::{self, Write};
use std::path::PathBuf;

use crate::files::{NewFile, WriteError};

/// One recorded variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The variable's name; `Component.name` where several components have that name.
    pub name: String,
    /// Its unit.
    pub unit: Option<String>,
}

/// Takes the rows of a run.
pub trait Sink {
    /// Takes one row: the time in s and one value per column (booleans as 0 and 1).
    ///
    /// # Errors
    /// When the row cannot be kept.
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()>;
}

/// Keeps nothing.
impl Sink for () {
    fn row(&mut self, _: f64, _: &[f64]) -> io::Result<()> {
        Ok(())
    }
}

/// Two sinks at once.
impl<A: Sink, B: Sink> Sink for (A, B) {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.0.row(time, values)?;
        self.1.row(time, values)
    }
}

impl<S: Sink + ?Sized> Sink for &mut S {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        (**self).row(time, values)
    }
}

impl<S: Sink> Sink for Option<S> {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.as_mut().map_or(Ok(()), |sink| sink.row(time, values))
    }
}

/// Rows in memory.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    columns: Vec<Column>,
    times: Vec<f64>,
    values: Vec<f64>,
}

impl Table {
    /// An empty table.
    #[must_use]
    pub fn new(columns: Vec<Column>) -> Self {
        Self { columns, times: Vec::new(), values: Vec::new() }
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Time of each row in s.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// All values of one column, if there is one of that name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.columns.iter().position(|column| column.name == name)?;
        Some(self.values.iter().skip(index).step_by(self.columns.len()).copied().collect())
    }

    /// Row by row.
    pub fn rows(&self) -> impl Iterator<Item = (f64, &[f64])> {
        let width = self.columns.len();
        self.times.iter().enumerate().map(move |(row, time)| (*time, &self.values[row * width..][..width]))
    }

    /// Writes all rows as CSV.
    ///
    /// # Errors
    /// When the file cannot be written; nothing is left behind then.
    pub fn write_csv(&self, path: impl Into<PathBuf>) -> Result<(), WriteError> {
        let mut sink = CsvSink::new(NewFile::create(path)?, &self.columns)?;
        for (time, values) in self.rows() {
            if let Err(source) = sink.row(time, values) {
                return Err(sink.error(source));
            }
        }
        sink.finish()
    }
}

impl Sink for Table {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.times.push(time);
        self.values.extend_from_slice(values);
        Ok(())
    }
}

/// Passes on only some columns.
#[derive(Debug)]
pub struct Pick<S> {
    indices: Vec<usize>,
    picked: Vec<f64>,
    /// Takes the picked columns.
    pub sink: S,
}

impl Pick<Table> {
    /// A table of those of `columns` that `wanted` accepts.
    pub fn new(columns: &[Column], wanted: impl Fn(&str) -> bool) -> Self {
        let indices: Vec<_> = (0..columns.len()).filter(|&index| wanted(&columns[index].name)).collect();
        let picked = indices.iter().map(|&index| columns[index].clone()).collect();
        Self { picked: vec![0.0; indices.len()], indices, sink: Table::new(picked) }
    }
}

impl<S: Sink> Sink for Pick<S> {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        for (picked, &index) in self.picked.iter_mut().zip(&self.indices) {
            *picked = values[index];
        }
        self.sink.row(time, &self.picked)
    }
}

/// Passes on only the rows at multiples of an interval, and the first and the last one.
#[derive(Debug)]
pub struct Every<S> {
    interval: f64,
    stop: f64,
    schedule: Option<Schedule>,
    /// Takes these rows.
    pub sink: S,
}

impl<S> Every<S> {
    /// Rows `interval` s apart, and the one at `stop`, for `sink`.
    pub fn new(interval: f64, stop: f64, sink: S) -> Self {
        Self { interval, stop, schedule: None, sink }
    }
}

impl<S: Sink> Sink for Every<S> {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let interval = self.interval;
        let schedule = self.schedule.get_or_insert_with(|| Schedule::new(time, interval));
        if schedule.is_due(time) || time >= self.stop { self.sink.row(time, values) } else { Ok(()) }
    }
}

/// Rows as CSV: a header with `time` and the names, then one line per row in the shortest digits that read back exactly.
pub struct CsvSink<W: Write> {
    writer: csv::Writer<W>,
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
    pub fn finish(mut self) -> Result<(), WriteError> {
        if let Err(source) = self.writer.flush() {
            return Err(self.error(source));
        }
        match self.writer.into_inner() {
            Ok(file) => file.finish(),
            Err(_) => unreachable!("the buffer was flushed before"),
        }
    }
}

impl<W: Write> CsvSink<W> {
    /// CSV to anything that takes bytes; write the header next.
    pub fn to(writer: W) -> Self {
        Self { writer: csv::Writer::from_writer(writer), digits: String::new() }
    }

    /// Hands back the writer.
    ///
    /// # Errors
    /// When what is still buffered cannot be written.
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

/// The error below the CSV writer's, whose kind says whether a reader has gone.
fn plain(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// Which communication points are recorded: the first one at or after each multiple of the interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Schedule {
    start: f64,
    interval: f64,
    next: f64,
}

impl Schedule {
    /// Points that miss their instant by this fraction of the interval are on time.
    const ROUNDING: f64 = 1e-6;

    pub(crate) fn new(start: f64, interval: f64) -> Self {
        Self { start, interval, next: 0.0 }
    }

    pub(crate) fn is_due(&mut self, time: f64) -> bool {
        if self.interval <= 0.0 {
            return true;
        }
        let position = (time - self.start) / self.interval + Self::ROUNDING;
        let due = position >= self.next;
        if due {
            self.next = position.floor() + 1.0;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let column = |name: &str| Column { name: name.into(), unit: None };
        let mut table = Table::new(vec![column("a"), column("b,c")]);
        for row in 0..6 {
            let time = f64::from(row) * 0.1;
            table.row(time, &[time * 2.0, -1e-9]).unwrap();
        }
        table
    }

    #[test]
    fn csv_reads_back_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let mut every = Every::new(0.2, 0.5, Table::new(table().columns().to_vec()));
        for (time, values) in table().rows() {
            every.row(time, values).unwrap();
        }
        every.sink.write_csv(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "time,a,\"b,c\"\n0,0,-1e-9\n0.2,0.4,-1e-9\n0.4,0.8,-1e-9\n0.5,1,-1e-9\n");
    }

    #[test]
    fn columns_are_found_by_name_and_can_be_picked() {
        assert_eq!(table().column("a").unwrap()[5].to_bits(), 1.0_f64.to_bits());
        assert_eq!(table().column("x"), None);
        let mut pick = Pick::new(table().columns(), |name| name == "b,c");
        pick.row(0.0, &[1.0, 2.0]).unwrap();
        assert_eq!(pick.sink.column("b,c"), Some(vec![2.0]));
    }

    #[test]
    fn the_schedule_tolerates_rounding_but_skips_nothing() {
        let mut schedule = Schedule::new(0.0, 1e-3);
        let due = (0..=50_000_u32).filter(|&step| schedule.is_due(f64::from(step) * 1e-4)).count();
        assert_eq!(due, 5_001);
        let mut odd = Schedule::new(0.0, 0.25);
        let due: Vec<_> = (0..=10_u32).filter(|&step| odd.is_due(f64::from(step) * 0.1)).collect();
        assert_eq!(due, [0, 3, 5, 8, 10]);
    }
}
