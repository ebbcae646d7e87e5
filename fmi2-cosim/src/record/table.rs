//! Rows in memory.

use std::io;
use std::path::PathBuf;

use super::{Column, CsvSink, Points, Sink};
use crate::files::{NewFile, WriteError};

/// Rows in memory, column by column: who looks at a run looks at its signals.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    pub(super) columns: Vec<Column>,
    pub(super) times: Vec<f64>,
    /// As many as columns, each as long as the times.
    pub(super) values: Vec<Vec<f64>>,
}

impl Table {
    /// An empty table.
    #[must_use]
    pub fn new(columns: Vec<Column>) -> Self {
        let values = vec![Vec::new(); columns.len()];
        Self { columns, times: Vec::new(), values }
    }

    /// Makes room for so many further rows at once: what grows little by little takes up to three times the memory for a while.
    #[must_use]
    pub fn with_room(mut self, rows: usize) -> Self {
        self.times.reserve_exact(rows);
        self.values.iter_mut().for_each(|column| column.reserve_exact(rows));
        self
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
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.columns.iter().position(|column| column.name == name)?;
        Some(&self.values[index])
    }

    /// All values of the column at a place.
    ///
    /// # Panics
    /// When there is no such column.
    #[must_use]
    pub fn column_at(&self, index: usize) -> &[f64] {
        &self.values[index]
    }

    /// The times, and all columns with their values.
    pub fn into_columns(self) -> (Vec<f64>, impl Iterator<Item = (Column, Vec<f64>)>) {
        (self.times, self.columns.into_iter().zip(self.values))
    }

    /// The rows and columns that are wanted, in their order.
    #[must_use]
    pub fn part(&self, columns: &[usize], rows: impl Iterator<Item = usize>) -> Self {
        let rows: Vec<usize> = rows.collect();
        let of = |values: &[f64]| rows.iter().map(|&row| values[row]).collect();
        Self {
            columns: columns.iter().map(|&column| self.columns[column].clone()).collect(),
            times: of(&self.times),
            values: columns.iter().map(|&column| of(&self.values[column])).collect(),
        }
    }

    /// Adds a row whose columns are at these places of `values`.
    pub(super) fn push(&mut self, time: f64, values: &[f64], places: &[usize]) {
        self.times.push(time);
        let mut places = places.iter();
        for column in &mut self.values {
            let Some(place) = places.next() else { break };
            column.push(values[*place]);
        }
    }

    /// Adds these points: of each column the values of the column that is at this place of a row, or no numbers if there are none.
    pub(super) fn extend(&mut self, points: &Points, places: &[usize]) {
        self.times.extend_from_slice(points.times());
        for (column, place) in self.values.iter_mut().zip(places) {
            match points.column(*place) {
                Some(values) => column.extend_from_slice(values),
                None => column.resize(self.times.len(), f64::NAN),
            }
        }
    }

    /// Gives a column another name.
    pub fn rename(&mut self, index: usize, name: String) {
        self.columns[index].name = name;
    }

    /// Row by row.
    pub fn rows(&self) -> impl Iterator<Item = (f64, Vec<f64>)> {
        let row = |row: usize| self.values.iter().map(|column| column[row]).collect();
        self.times.iter().enumerate().map(move |(index, time)| (*time, row(index)))
    }

    /// Writes all rows as CSV.
    ///
    /// # Errors
    /// When the file cannot be written; nothing is left behind then.
    pub fn write_csv(&self, path: impl Into<PathBuf>) -> Result<(), WriteError> {
        self.to_csv(NewFile::create(path)?)?.finish()
    }

    /// Writes all rows as CSV to a file, which the caller finishes or adds to others.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn to_csv(&self, file: NewFile) -> Result<NewFile, WriteError> {
        let mut sink = CsvSink::new(file, &self.columns)?;
        for (time, values) in self.rows() {
            if let Err(source) = sink.row(time, &values) {
                return Err(sink.error(source));
            }
        }
        sink.into_file()
    }
}

impl Sink for Table {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.times.push(time);
        for (column, value) in self.values.iter_mut().zip(values) {
            column.push(*value);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Every, Pick};

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
            every.row(time, &values).unwrap();
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
        assert_eq!(pick.table.column("b,c"), Some(&[2.0][..]));
    }
}
