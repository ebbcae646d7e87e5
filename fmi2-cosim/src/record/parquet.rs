//! Rows as Apache Parquet: a compressed column per variable, which pandas, Polars, `DuckDB`, MATLAB and others read directly.
//!
//! Booleans and integers keep their types. Parquet has no place for the units of columns (Arrow's schema is not part of
//! it). The units are in the file's key-value metadata: `units` is a JSON object from column name to unit.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;

use ::parquet::basic::{Compression, GzipLevel, Repetition, Type as PhysicalType};
use ::parquet::data_type::{BoolType, DoubleType, Int32Type};
use ::parquet::errors::{ParquetError, Result};
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::Type;

use super::{Column, Kind, Sink};
use crate::files::{NewFile, WriteError};

/// Rows as a Parquet file with the column `time` and one per variable.
pub struct ParquetSink {
    writer: SerializedFileWriter<NewFile>,
    kinds: Vec<Kind>,
    /// Rows that are written together.
    rows: usize,
    /// Values of the rows that are not written yet, column by column, the time first.
    columns: Vec<Vec<f64>>,
}

impl ParquetSink {
    /// Rows that are written together, if there are few columns.
    const MAX_ROWS: usize = 1 << 16;
    /// Values that are kept in memory at most: 32 MiB of them.
    const MAX_VALUES: usize = 1 << 22;
    /// The largest number of compressed columns. Each needs a new compressor of a quarter megabyte, and after it is freed
    /// the allocator's memory stays as large as all of them together: gigabytes for ten thousand columns.
    const MAX_COMPRESSED: usize = 1 << 10;

    /// Begins the file; `created_by` is the name and version of the program, which is stored in the file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn new(file: NewFile, columns: &[Column], created_by: &str) -> std::result::Result<Self, WriteError> {
        let time = Column { name: "time".into(), unit: Some("s".into()), kind: Kind::Real };
        let columns: Vec<&Column> = std::iter::once(&time).chain(columns).collect();
        let path = file.path().to_owned();
        let writer =
            Self::writer(file, &columns, created_by).map_err(|error| WriteError { path, source: plain(error) })?;
        let kinds: Vec<_> = columns.iter().map(|column| column.kind).collect();
        let rows = (Self::MAX_VALUES / kinds.len()).clamp(1, Self::MAX_ROWS);
        Ok(Self { writer, columns: vec![Vec::new(); kinds.len()], kinds, rows })
    }

    fn writer(file: NewFile, columns: &[&Column], created_by: &str) -> Result<SerializedFileWriter<NewFile>> {
        let field = |column: &&Column| {
            let physical = match column.kind {
                Kind::Real => PhysicalType::DOUBLE,
                Kind::Integer => PhysicalType::INT32,
                Kind::Boolean => PhysicalType::BOOLEAN,
            };
            let field = Type::primitive_type_builder(&column.name, physical).with_repetition(Repetition::REQUIRED);
            Ok(Arc::new(field.build()?))
        };
        let fields = columns.iter().map(field).collect::<Result<Vec<_>>>()?;
        let schema = Arc::new(Type::group_type_builder("run").with_fields(fields).build()?);
        let units: BTreeMap<&str, &str> =
            columns.iter().filter_map(|column| Some((column.name.as_str(), column.unit.as_deref()?))).collect();
        let units = serde_json::to_string(&units).map_err(|error| ParquetError::External(Box::new(error)))?;
        let is_wide = columns.len() > Self::MAX_COMPRESSED;
        let properties = WriterProperties::builder()
            .set_created_by(created_by.to_owned())
            .set_compression(if is_wide { Compression::UNCOMPRESSED } else { Compression::GZIP(GzipLevel::default()) })
            .set_dictionary_enabled(false) // simulated values hardly ever repeat
            .set_key_value_metadata(Some(vec![KeyValue::new("units".to_owned(), units)]))
            .build();
        SerializedFileWriter::new(file, schema, Arc::new(properties))
    }

    /// Makes an error of this file's path.
    #[must_use]
    pub fn error(&self, source: io::Error) -> WriteError {
        self.writer.inner().error(source)
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// When not everything could be written.
    pub fn finish(mut self) -> std::result::Result<(), WriteError> {
        let path = self.writer.inner().path().to_owned();
        let file = self.write_rows().and_then(|()| self.writer.into_inner());
        file.map_err(|error| WriteError { path, source: plain(error) })?.finish()
    }

    /// Writes the collected rows as one row group.
    fn write_rows(&mut self) -> Result<()> {
        if self.columns[0].is_empty() {
            return Ok(());
        }
        let mut group = self.writer.next_row_group()?;
        for (kind, values) in self.kinds.iter().zip(&mut self.columns) {
            let Some(mut column) = group.next_column()? else { break };
            match kind {
                Kind::Real => _ = column.typed::<DoubleType>().write_batch(values, None, None)?,
                Kind::Integer => {
                    #[allow(clippy::cast_possible_truncation)] // they were 32-bit integers
                    let integers: Vec<_> = values.iter().map(|value| *value as i32).collect();
                    column.typed::<Int32Type>().write_batch(&integers, None, None)?;
                }
                Kind::Boolean => {
                    let booleans: Vec<_> = values.iter().map(|value| *value != 0.0).collect();
                    column.typed::<BoolType>().write_batch(&booleans, None, None)?;
                }
            }
            column.close()?;
            values.clear();
        }
        group.close()?;
        Ok(())
    }
}

impl Sink for ParquetSink {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        for (column, value) in self.columns.iter_mut().zip(std::iter::once(&time).chain(values)) {
            column.push(*value);
        }
        if self.columns[0].len() == self.rows { self.write_rows().map_err(plain) } else { Ok(()) }
    }
}

/// The error below Parquet's, as far as there is one.
fn plain(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(source) => match source.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other),
        },
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use ::parquet::file::reader::{FileReader, SerializedFileReader};
    use ::parquet::record::RowAccessor;

    use super::*;

    /// Ten thousand columns took gigabytes, a compressor each. Files with many columns are not compressed; files with few
    /// are.
    #[test]
    fn wide_tables_go_without_compressors_and_read_back() {
        for (width, compressed) in [(3, true), (3000, false)] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("t.parquet");
            let column = |n: usize| Column { name: format!("y{n}"), ..Column::default() };
            let columns: Vec<_> = (0..width).map(column).collect();
            let mut sink = ParquetSink::new(NewFile::create(&path).unwrap(), &columns, "test").unwrap();
            let values: Vec<_> = (0..width).map(|n| n as f64).collect();
            for time in [0.0, 0.5] {
                sink.row(time, &values).unwrap();
            }
            sink.finish().unwrap();
            let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
            let chunk = reader.metadata().row_group(0).column(width);
            assert_eq!(chunk.compression() != Compression::UNCOMPRESSED, compressed, "{width} columns");
            let row = reader.get_row_iter(None).unwrap().nth(1).unwrap().unwrap();
            assert_eq!((row.get_double(0).unwrap(), row.get_double(width).unwrap()), (0.5, values[width - 1]));
        }
    }
}
