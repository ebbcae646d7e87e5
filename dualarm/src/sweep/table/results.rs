//! The file of a result: Parquet or CSV.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;

use fmi2_cosim::files::{NewFile, WriteError, has_extension};
use parquet::basic::{Compression, ConvertedType, GzipLevel, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::{Column, Field, Kind, unit};
use crate::TOOL;

/// A result under construction.
pub enum Results {
    /// Comma-separated values.
    Csv(Box<csv::Writer<NewFile>>),
    /// By columns.
    Parquet(Box<Parquet>),
}

/// Rows that are not written yet and the file.
pub struct Parquet {
    writer: SerializedFileWriter<NewFile>,
    columns: Vec<Column>,
    rows: Vec<Vec<Field>>,
}

impl Results {
    /// Begins the file: Parquet if its name ends so, CSV otherwise.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn new(path: &Path, columns: &[Column]) -> Result<Self, WriteError> {
        let file = NewFile::create(path)?;
        let failure = |source| WriteError { path: path.to_owned(), source };
        if has_extension(path, "parquet") {
            let parquet = Parquet::new(file, columns).map_err(|error| failure(io::Error::other(error)))?;
            return Ok(Self::Parquet(Box::new(parquet)));
        }
        let mut writer = csv::Writer::from_writer(file);
        let header = writer.write_record(columns.iter().map(|column| &column.name));
        header.map_err(|error| failure(io::Error::other(error)))?;
        Ok(Self::Csv(Box::new(writer)))
    }

    /// Adds a row.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(&mut self, fields: Vec<Field>) -> Result<(), WriteError> {
        match self {
            Self::Csv(writer) => {
                let written = writer.write_record(fields.iter().map(text));
                written.map_err(|error| writer.get_ref().error(io::Error::other(error)))
            }
            Self::Parquet(parquet) => {
                parquet.rows.push(fields);
                if parquet.rows.len() < Parquet::ROWS {
                    return Ok(());
                }
                parquet.write().map_err(|error| parquet.writer.inner().error(io::Error::other(error)))
            }
        }
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// When not everything could be written.
    pub fn finish(self) -> Result<(), WriteError> {
        match self {
            Self::Csv(writer) => {
                let path = writer.get_ref().path().to_owned();
                let file = writer.into_inner();
                file.map_err(|error| WriteError { path, source: io::Error::other(error.to_string()) })?.finish()
            }
            Self::Parquet(mut parquet) => {
                let path = parquet.writer.inner().path().to_owned();
                let failure = |error| WriteError { path: path.clone(), source: io::Error::other(error) };
                parquet.write().map_err(failure)?;
                let Parquet { writer, .. } = *parquet;
                writer
                    .into_inner()
                    .map_err(|error| WriteError { path: path.clone(), source: io::Error::other(error) })?
                    .finish()
            }
        }
    }
}

/// A field of CSV.
fn text(field: &Field) -> String {
    match field {
        Field::None => String::new(),
        Field::Integer(value) => value.to_string(),
        // + 0 makes zero of minus zero, which would print as -0.
        Field::Real(value) => {
            let digits = format!("{:?}", value + 0.0);
            digits.strip_suffix(".0").map_or(digits.clone(), str::to_owned)
        }
        Field::Boolean(value) => u8::from(*value).to_string(),
        Field::Text(value) => value.clone(),
    }
}

impl Parquet {
    /// Rows that are written together.
    const ROWS: usize = 1 << 13;

    fn new(file: NewFile, columns: &[Column]) -> ParquetResult<Self> {
        let field = |column: &Column| {
            let physical = match column.kind {
                Kind::Integer => PhysicalType::INT64,
                Kind::Real => PhysicalType::DOUBLE,
                Kind::Boolean => PhysicalType::BOOLEAN,
                Kind::Text => PhysicalType::BYTE_ARRAY,
            };
            let repetition = if column.optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
            let mut field = Type::primitive_type_builder(&column.name, physical).with_repetition(repetition);
            if column.kind == Kind::Text {
                field = field.with_converted_type(ConvertedType::UTF8);
            }
            Ok(Arc::new(field.build()?))
        };
        let fields = columns.iter().map(field).collect::<ParquetResult<Vec<_>>>()?;
        let schema = Arc::new(Type::group_type_builder("study").with_fields(fields).build()?);
        let units: BTreeMap<&str, &str> =
            columns.iter().filter_map(|column| Some((column.name.as_str(), unit(&column.name)?))).collect();
        let units = serde_json::to_string(&units).map_err(|error| ParquetError::External(Box::new(error)))?;
        let properties = WriterProperties::builder()
            .set_created_by(TOOL.to_owned())
            .set_key_value_metadata(Some(vec![KeyValue::new("units".to_owned(), units)]))
            .set_compression(Compression::GZIP(GzipLevel::default()))
            .build();
        let writer = SerializedFileWriter::new(file, schema, Arc::new(properties))?;
        Ok(Self { writer, columns: columns.to_vec(), rows: Vec::new() })
    }

    /// Writes the collected rows as one row group.
    fn write(&mut self) -> ParquetResult<()> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let rows = std::mem::take(&mut self.rows);
        let mut group = self.writer.next_row_group()?;
        for (place, column) in self.columns.iter().enumerate() {
            let fields = || rows.iter().map(|row| &row[place]);
            let levels: Option<Vec<i16>> =
                column.optional.then(|| fields().map(|field| i16::from(*field != Field::None)).collect());
            let levels = levels.as_deref();
            let Some(mut writer) = group.next_column()? else { break };
            match column.kind {
                Kind::Integer => {
                    let values: Vec<i64> = fields()
                        .filter_map(|field| if let Field::Integer(v) = field { Some(*v) } else { None })
                        .collect();
                    writer.typed::<Int64Type>().write_batch(&values, levels, None)?;
                }
                Kind::Real => {
                    let values: Vec<f64> =
                        fields().filter_map(|field| if let Field::Real(v) = field { Some(*v) } else { None }).collect();
                    writer.typed::<DoubleType>().write_batch(&values, levels, None)?;
                }
                Kind::Boolean => {
                    let values: Vec<bool> = fields()
                        .filter_map(|field| if let Field::Boolean(v) = field { Some(*v) } else { None })
                        .collect();
                    writer.typed::<BoolType>().write_batch(&values, levels, None)?;
                }
                Kind::Text => {
                    let values: Vec<ByteArray> = fields()
                        .filter_map(|field| if let Field::Text(v) = field { Some(v.as_str().into()) } else { None })
                        .collect();
                    writer.typed::<ByteArrayType>().write_batch(&values, levels, None)?;
                }
            }
            writer.close()?;
        }
        group.close()?;
        Ok(())
    }
}
