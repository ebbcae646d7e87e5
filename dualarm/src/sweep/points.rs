//! Points from a file: a column for each parameter, a row for each draw.

use std::fs::File;
use std::path::{Path, PathBuf};

use fmi2_cosim::files::{has_extension, read_text};
use fmi2_import::Value;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

/// A table of points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points {
    /// Its name in messages.
    pub file: String,
    /// Names and values: numbers are reals, everything else texts.
    pub columns: Vec<(String, Vec<Value>)>,
    /// How many rows there are.
    pub rows: usize,
}

/// The file cannot be read as a table.
#[derive(Debug, thiserror::Error)]
#[error("cannot read the points {}: {reason}", path.display())]
pub struct PointsError {
    path: PathBuf,
    reason: String,
}

impl Points {
    /// Reads a file: Parquet if its extension is `.parquet`, CSV with a header otherwise.
    ///
    /// # Errors
    /// When it is not such a table.
    pub fn read(path: &Path) -> Result<Self, PointsError> {
        let failure = |reason: String| PointsError { path: path.to_owned(), reason };
        let name = path.display().to_string();
        if has_extension(path, "parquet") {
            return Self::read_parquet(&name, path).map_err(failure);
        }
        let text = read_text(path).map_err(|error| failure(error.to_string()))?;
        Self::parse_csv(&name, &text).map_err(failure)
    }

    /// Reads CSV with a header; `file` is its name in messages.
    ///
    /// # Errors
    /// A fault of the text.
    pub fn parse_csv(file: &str, text: &str) -> Result<Self, String> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let header = reader.headers().map_err(|error| error.to_string())?.clone();
        let mut points = Self::with(file, header.iter().map(str::to_owned).collect())?;
        for record in reader.records() {
            let record = record.map_err(|error| error.to_string())?;
            for ((_, column), text) in points.columns.iter_mut().zip(&record) {
                column.push(text.parse().map_or_else(|_| Value::from(text), Value::Real));
            }
            points.rows += 1;
        }
        Ok(points)
    }

    fn read_parquet(file: &str, path: &Path) -> Result<Self, String> {
        let text = |error: parquet::errors::ParquetError| error.to_string();
        let reader = SerializedFileReader::new(File::open(path).map_err(|error| error.to_string())?).map_err(text)?;
        let fields = reader.metadata().file_metadata().schema().get_fields();
        let mut points = Self::with(file, fields.iter().map(|field| field.name().to_owned()).collect())?;
        for row in reader.get_row_iter(None).map_err(text)? {
            let row = row.map_err(text)?;
            for ((_, column), (_, field)) in points.columns.iter_mut().zip(row.get_column_iter()) {
                column.push(value(field));
            }
            points.rows += 1;
        }
        Ok(points)
    }

    fn with(file: &str, names: Vec<String>) -> Result<Self, String> {
        for (index, name) in names.iter().enumerate() {
            if names[..index].contains(name) {
                return Err(format!("it has two columns \"{name}\""));
            }
        }
        let columns = names.into_iter().map(|name| (name, Vec::new())).collect();
        Ok(Self { file: file.to_owned(), columns, rows: 0 })
    }
}

/// A cell: numbers of all sizes are reals, as a variable takes them.
fn value(field: &Field) -> Value {
    #[allow(clippy::cast_precision_loss)] // as a real has it
    let number = match field {
        Field::Double(value) => *value,
        Field::Float(value) => f64::from(*value),
        Field::Byte(value) => f64::from(*value),
        Field::Short(value) => f64::from(*value),
        Field::Int(value) => f64::from(*value),
        Field::Long(value) => *value as f64,
        Field::UByte(value) => f64::from(*value),
        Field::UShort(value) => f64::from(*value),
        Field::UInt(value) => f64::from(*value),
        Field::ULong(value) => *value as f64,
        Field::Bool(value) => return Value::Boolean(*value),
        Field::Str(value) => return Value::Text(value.clone()),
        other => return Value::Text(other.to_string()),
    };
    Value::Real(number)
}
