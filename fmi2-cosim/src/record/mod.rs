//! The results of a run: rows of values over time, kept in memory or written as [CSV](CsvSink) or
//! [Parquet](ParquetSink), and [read] again.

mod csv;
mod digits;
mod file;
mod filters;
mod follow;
mod parquet;
mod points;
mod read;
mod singles;
mod table;
mod times;

use std::io;

pub use csv::CsvSink;
pub use file::FileSink;
pub use filters::{Every, Pick, Schedule};
pub use follow::Follow;
pub use parquet::ParquetSink;
pub use points::Points;
pub use read::{ReadError, Saved, read};
pub use singles::{Single, Singles};
pub use table::Table;

use fmi2_import::description::BaseType;

/// One recorded variable.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Column {
    /// The variable's name; `Component.name` where several components have that name.
    pub name: String,
    /// Its unit.
    pub unit: Option<String>,
    /// The kind of its values.
    pub kind: Kind,
}

/// The kind of the values in a column; in memory all are `f64`.
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
    /// The kind of column for a variable of this type; `None` for strings, which rows omit.
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
    /// Whether it wants the row of this time in s, all columns of which are read only if somebody wants them. It is asked once for
    /// each row that may come, in the order of time; what it does not want it may get all the same. The last row nobody is
    /// asked about.
    fn wants(&mut self, _time: f64) -> bool {
        true
    }

    /// The time in s before which it surely does not want any row. Until then it need not be asked.
    fn idle(&mut self) -> f64 {
        f64::NEG_INFINITY
    }

    /// Takes one row: the time in s and one value per column (booleans as 0 and 1).
    ///
    /// # Errors
    /// When the row cannot be stored.
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()>;

    /// Takes the columns that the run [follows](crate::master::Master::follow), if it does, at the next communication points. None is
    /// left out, whether or not there is a row.
    ///
    /// # Errors
    /// When they cannot be stored.
    fn points(&mut self, _points: &Points) -> io::Result<()> {
        Ok(())
    }

    /// Marks the end of the run, with the values of its end. A sink that has not stored them as a row may do so now.
    ///
    /// # Errors
    /// When the row cannot be stored.
    fn end(&mut self, _time: f64, _values: &[f64]) -> io::Result<()> {
        Ok(())
    }
}

/// Keeps nothing.
impl Sink for () {
    fn wants(&mut self, _: f64) -> bool {
        false
    }

    fn idle(&mut self) -> f64 {
        f64::INFINITY
    }

    fn row(&mut self, _: f64, _: &[f64]) -> io::Result<()> {
        Ok(())
    }
}

/// Two sinks at once.
impl<A: Sink, B: Sink> Sink for (A, B) {
    fn wants(&mut self, time: f64) -> bool {
        // Both are asked.
        self.0.wants(time) | self.1.wants(time)
    }

    fn idle(&mut self) -> f64 {
        self.0.idle().min(self.1.idle())
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.0.row(time, values)?;
        self.1.row(time, values)
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        self.0.points(points)?;
        self.1.points(points)
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.0.end(time, values)?;
        self.1.end(time, values)
    }
}

impl<S: Sink + ?Sized> Sink for &mut S {
    fn wants(&mut self, time: f64) -> bool {
        (**self).wants(time)
    }

    fn idle(&mut self) -> f64 {
        (**self).idle()
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        (**self).row(time, values)
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        (**self).points(points)
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        (**self).end(time, values)
    }
}

impl<S: Sink> Sink for Option<S> {
    fn wants(&mut self, time: f64) -> bool {
        self.as_mut().is_some_and(|sink| sink.wants(time))
    }

    fn idle(&mut self) -> f64 {
        self.as_mut().map_or(f64::INFINITY, Sink::idle)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.as_mut().map_or(Ok(()), |sink| sink.row(time, values))
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        self.as_mut().map_or(Ok(()), |sink| sink.points(points))
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.as_mut().map_or(Ok(()), |sink| sink.end(time, values))
    }
}

/// Keeps the last row only.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Last {
    /// Its values.
    pub values: Vec<f64>,
}

impl Sink for Last {
    fn wants(&mut self, _: f64) -> bool {
        false
    }

    fn idle(&mut self) -> f64 {
        f64::INFINITY
    }

    fn row(&mut self, _: f64, _: &[f64]) -> io::Result<()> {
        Ok(())
    }

    fn end(&mut self, _: f64, values: &[f64]) -> io::Result<()> {
        values.clone_into(&mut self.values);
        Ok(())
    }
}
