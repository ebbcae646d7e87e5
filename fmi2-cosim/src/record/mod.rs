//! What a run leaves behind: rows of values over time, kept in memory or written as [CSV](CsvSink) or
//! [Parquet](ParquetSink).

mod csv;
mod parquet;

use std::io;
use std::path::PathBuf;

pub use csv::CsvSink;
pub use parquet::ParquetSink;

use crate::files::{NewFile, WriteError};
use fmi2_import::description::BaseType;

/// One recorded variable.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Column {
    /// The variable's name; `Component.name` where several components have that name.
    pub name: String,
    /// Its unit.
    pub unit: Option<String>,
    /// What its values are.
    pub kind: Kind,
}

/// What the values of a column are; in memory all are `f64`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    /// Real numbers.
    #[default]
    Real,
    /// 32-bit integers, also those of enumerations.
    Integer,
    /// 1 for true, 0 for false.
    Boolean,
}

impl Kind {
    /// The kind of column a variable of this type becomes; `None` for texts, which rows do not have.
    #[must_use]
    pub fn of(base: BaseType) -> Option<Self> {
        match base {
            BaseType::Real => Some(Self::Real),
            BaseType::Integer | BaseType::Enumeration => Some(Self::Integer),
            BaseType::Boolean => Some(Self::Boolean),
            BaseType::String => None,
        }
    }
}

/// Takes the rows of a run.
pub trait Sink {
    /// Takes one row: the time in s and one value per column (booleans as 0 and 1).
    ///
    /// # Errors
    /// When the row cannot be kept.
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()>;

    /// The run is over. This was the last row; who did not keep it may want to.
    ///
    /// # Errors
    /// When the row cannot be kept.
    fn end(&mut self, _time: f64, _values: &[f64]) -> io::Result<()> {
        Ok(())
    }
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

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.0.end(time, values)?;
        self.1.end(time, values)
    }
}

impl<S: Sink + ?Sized> Sink for &mut S {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        (**self).row(time, values)
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        (**self).end(time, values)
    }
}

impl<S: Sink> Sink for Option<S> {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.as_mut().map_or(Ok(()), |sink| sink.row(time, values))
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.as_mut().map_or(Ok(()), |sink| sink.end(time, values))
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
        self.to_csv(NewFile::create(path)?)?.finish()
    }

    /// Writes all rows as CSV to a file, which is finished or added to others next.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn to_csv(&self, file: NewFile) -> Result<NewFile, WriteError> {
        let mut sink = CsvSink::new(file, &self.columns)?;
        for (time, values) in self.rows() {
            if let Err(source) = sink.row(time, values) {
                return Err(sink.error(source));
            }
        }
        sink.into_file()
    }
}

impl Sink for Table {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.times.push(time);
        self.values.extend_from_slice(values);
        Ok(())
    }
}

/// Keeps the newest row only.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Last {
    /// Its values.
    pub values: Vec<f64>,
}

impl Sink for Last {
    fn row(&mut self, _: f64, values: &[f64]) -> io::Result<()> {
        values.clone_into(&mut self.values);
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

impl<S> Pick<S> {
    fn pick(&mut self, values: &[f64]) {
        for (picked, &index) in self.picked.iter_mut().zip(&self.indices) {
            *picked = values[index];
        }
    }
}

impl<S: Sink> Sink for Pick<S> {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.pick(values);
        self.sink.row(time, &self.picked)
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.pick(values);
        self.sink.end(time, &self.picked)
    }
}

/// Passes on only the rows at multiples of an interval, and the first and the last one.
#[derive(Debug)]
pub struct Every<S> {
    interval: f64,
    stop: f64,
    schedule: Option<Schedule>,
    passed: Option<f64>,
    /// Takes these rows.
    pub sink: S,
}

impl<S> Every<S> {
    /// Rows `interval` s apart, and the one at `stop`, for `sink`.
    pub fn new(interval: f64, stop: f64, sink: S) -> Self {
        Self { interval, stop, schedule: None, passed: None, sink }
    }
}

impl<S: Sink> Sink for Every<S> {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let interval = self.interval;
        let schedule = self.schedule.get_or_insert_with(|| Schedule::new(time, interval));
        if schedule.is_due(time) || time >= self.stop {
            self.passed = Some(time);
            return self.sink.row(time, values);
        }
        Ok(())
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        // A run that ends before its time does so between two multiples of the interval.
        if self.passed != Some(time) {
            self.passed = Some(time);
            self.sink.row(time, values)?;
        }
        self.sink.end(time, values)
    }
}

/// Which communication points are recorded: the first one at or after each multiple of the interval.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    start: f64,
    interval: f64,
    next: f64,
}

impl Schedule {
    /// Points that miss their instant by this fraction of the interval are on time.
    const ROUNDING: f64 = 1e-6;

    /// Multiples of `interval` s, counted from `start`.
    #[must_use]
    pub fn new(start: f64, interval: f64) -> Self {
        Self { start, interval, next: 0.0 }
    }

    /// Whether the communication point at `time` s is one of them; to be asked in the order of time.
    pub fn is_due(&mut self, time: f64) -> bool {
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
        let column = |name: &str| Column { name: name.into(), ..Column::default() };
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
