//! Reads results again: [CSV](super::CsvSink) and [Parquet](super::ParquetSink) of this tool, and similar files of other
//! tools.
//!
//! The time column is the one called `time` or `t`, in upper or lower case, with or without its unit. Without one it is the first
//! column of numbers. A table is no rows over time if this one has a unit that is not one of time, or, without a unit, beside a column of
//! texts, if it counts rows or does not rise. A CSV may be separated by commas, semicolons (with decimal commas) or tabs. A unit may follow a name in brackets,
//! as in `theta1 [rad]`. Columns of strings are omitted; an empty field is not a number.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::Field;

use super::times::{is_named_time, is_time, no_times};
use super::{Column, Kind, Table};

/// Why a file cannot be read as results.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is of another kind.
    #[error("{} is neither .csv (.txt, .dat) nor .parquet; write results as one of them", .0.display())]
    Kind(PathBuf),
    /// It is a table, but not of values over time.
    #[error("{}: {reason}", path.display())]
    NoTimes {
        /// The file.
        path: PathBuf,
        /// Why no column is one of times.
        reason: String,
    },
    /// Its content does not match its extension.
    #[error("{}: {message}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The fault.
        message: String,
    },
}

/// Results that were read.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved {
    /// The rows.
    pub table: Table,
    /// The name of the time column.
    pub time: String,
}

impl Saved {
    /// Whether that name says that it is one.
    #[must_use]
    pub fn names_time(&self) -> bool {
        is_time(&self.time)
    }
}

/// Reads a file by its extension.
///
/// # Errors
/// When it cannot be read, has no rows, is a table of something else, or its times are not numbers in ascending order.
pub fn read(path: &Path) -> Result<Saved, ReadError> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let columns = match extension.as_deref() {
        Some("csv" | "txt" | "dat") | None => csv(path)?,
        Some("parquet") => parquet(path)?,
        Some(_) => return Err(ReadError::Kind(path.to_owned())),
    };
    let has_numbers = columns.iter().any(|(_, values)| values.is_some());
    if has_numbers
        && !columns.iter().any(is_named_time)
        && let Some(reason) = no_times(&columns)
    {
        return Err(ReadError::NoTimes { path: path.to_owned(), reason });
    }
    saved(columns).map_err(|message| ReadError::Content { path: path.to_owned(), message })
}

/// A column and its values; none if they are strings.
pub(super) type Values = (Column, Option<Vec<f64>>);

/// Finds and checks the time column.
fn saved(columns: Vec<Values>) -> Result<Saved, String> {
    let place = columns.iter().filter(|(_, values)| values.is_some()).position(is_named_time).unwrap_or(0);
    let numbers = columns.into_iter().filter_map(|(column, values)| Some((column, values?)));
    let mut columns: Vec<(Column, Vec<f64>)> = numbers.collect();
    if columns.is_empty() {
        return Err("there is no column of numbers".into());
    }
    let (time, times) = columns.remove(place);
    if times.is_empty() {
        return Err("there are no rows".into());
    }
    if let Some(row) = times.iter().position(|time| !time.is_finite()) {
        return Err(format!("row {} has no time in the column \"{}\"", row + 1, time.name));
    }
    if let Some(row) = times.windows(2).position(|pair| pair[1] < pair[0]) {
        return Err(format!(
            "the times in the column \"{}\" fall from {} to {} at row {}; the column of times must be called time or come first",
            time.name,
            times[row],
            times[row + 1],
            row + 2
        ));
    }
    if let [first, .., last] = times[..]
        && first == last
    {
        return Err(format!("the times in the column \"{}\" are all {first}", time.name));
    }
    let (columns, values): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    Ok(Saved { table: Table { columns, times, values }, time: time.name })
}

/// `name [unit]` in two.
fn described(heading: &str) -> Column {
    let heading = heading.trim();
    let split = heading.strip_suffix(']').and_then(|rest| rest.rsplit_once(" ["));
    match split {
        Some((name, unit)) => Column { name: name.trim().into(), unit: Some(unit.trim().into()), ..Column::default() },
        None => Column { name: heading.into(), ..Column::default() },
    }
}

fn csv(path: &Path) -> Result<Vec<Values>, ReadError> {
    let file = |source| ReadError::File { path: path.to_owned(), source };
    let content = |message| ReadError::Content { path: path.to_owned(), message };
    let bytes = std::fs::read(path).map_err(file)?;
    let text = String::from_utf8_lossy(&bytes);
    let text = text.trim_start_matches('\u{feff}');
    let header = text.lines().next().unwrap_or_default();
    let separator = [';', '\t'].into_iter().find(|separator| header.contains(*separator)).unwrap_or(',');
    let has_decimal_commas = separator == ';';
    let mut reader = ::csv::ReaderBuilder::new()
        .delimiter(u8::try_from(separator).unwrap_or(b','))
        .trim(::csv::Trim::All)
        .from_reader(text.as_bytes());
    let headings = reader.headers().map_err(|error| content(error.to_string()))?.clone();
    let mut columns: Vec<Values> = headings.iter().map(|heading| (described(heading), Some(Vec::new()))).collect();
    for record in reader.records() {
        // The message names the line.
        let record = record.map_err(|error| content(error.to_string()))?;
        for ((_, values), field) in columns.iter_mut().zip(&record) {
            let Some(numbers) = values else { continue };
            match number(field, has_decimal_commas) {
                Some(value) => numbers.push(value),
                None => *values = None,
            }
        }
    }
    Ok(columns)
}

/// The number in a field, or `None` if it is a string.
fn number(field: &str, has_decimal_commas: bool) -> Option<f64> {
    if field.is_empty() {
        return Some(f64::NAN);
    }
    if let Ok(value) = field.parse() {
        return Some(value);
    }
    match field {
        "true" | "True" | "TRUE" => Some(1.0),
        "false" | "False" | "FALSE" => Some(0.0),
        _ if has_decimal_commas => field.replacen(',', ".", 1).parse().ok(),
        _ => None,
    }
}

fn parquet(path: &Path) -> Result<Vec<Values>, ReadError> {
    let file = File::open(path).map_err(|source| ReadError::File { path: path.to_owned(), source })?;
    parquet_columns(file).map_err(|error| ReadError::Content {
        path: path.to_owned(),
        message: format!("{error}; uncompressed, gzip and snappy files of flat columns can be read"),
    })
}

fn parquet_columns(file: File) -> ::parquet::errors::Result<Vec<Values>> {
    let reader = SerializedFileReader::new(file)?;
    let metadata = reader.metadata().file_metadata();
    let entries = metadata.key_value_metadata().into_iter().flatten();
    let units = entries.filter(|entry| entry.key == "units").find_map(|entry| entry.value.as_deref());
    let units: BTreeMap<String, String> = units.and_then(|units| serde_json::from_str(units).ok()).unwrap_or_default();
    let mut columns: Vec<Values> = Vec::new();
    for field in metadata.schema().get_fields() {
        let mut column = described(field.name());
        column.unit = units.get(field.name()).cloned().or(column.unit);
        columns.push((column, Some(Vec::new())));
    }
    for row in reader.get_row_iter(None)? {
        let row = row?;
        for ((described, values), (_, field)) in columns.iter_mut().zip(row.get_column_iter()) {
            let Some(numbers) = values else { continue };
            let (kind, value) = match field {
                Field::Double(value) => (Kind::Real, *value),
                Field::Float(value) => (Kind::Real, f64::from(*value)),
                Field::Null => (described.kind, f64::NAN),
                Field::Bool(value) => (Kind::Boolean, f64::from(u8::from(*value))),
                Field::Int(value) => (Kind::Integer, f64::from(*value)),
                Field::Short(value) => (Kind::Integer, f64::from(*value)),
                Field::Byte(value) => (Kind::Integer, f64::from(*value)),
                Field::UInt(value) => (Kind::Real, f64::from(*value)),
                Field::UShort(value) => (Kind::Integer, f64::from(*value)),
                Field::UByte(value) => (Kind::Integer, f64::from(*value)),
                #[allow(clippy::cast_precision_loss)] // beyond 2⁵³ nobody draws them apart
                Field::Long(value) => (Kind::Real, *value as f64),
                #[allow(clippy::cast_precision_loss)] // as above
                Field::ULong(value) => (Kind::Real, *value as f64),
                _ => {
                    *values = None;
                    continue;
                }
            };
            described.kind = kind;
            numbers.push(value);
        }
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::NewFile;
    use crate::record::{ParquetSink, Sink};

    fn read_text(name: &str, text: &str) -> Result<Table, ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        Ok(read(&path)?.table)
    }

    #[test]
    fn what_this_tool_writes_reads_back_exactly() {
        let columns = vec![
            Column { name: "a".into(), unit: Some("N.m".into()), kind: Kind::Real },
            Column { name: "n".into(), unit: None, kind: Kind::Integer },
            Column { name: "b".into(), unit: None, kind: Kind::Boolean },
        ];
        let mut table = Table::new(columns.clone());
        for row in 0..5_u32 {
            table.row(f64::from(row) * 0.1, &[f64::from(row).sqrt(), -f64::from(row), f64::from(row % 2)]).unwrap();
        }
        let folder = tempfile::tempdir().unwrap();
        let (csv, parquet) = (folder.path().join("t.csv"), folder.path().join("t.parquet"));
        table.write_csv(&csv).unwrap();
        let mut sink = ParquetSink::new(NewFile::create(&parquet).unwrap(), &columns, "test").unwrap();
        for (time, values) in table.rows() {
            sink.row(time, &values).unwrap();
        }
        sink.finish().unwrap();
        let from_parquet = read(&parquet).unwrap();
        assert!(from_parquet.names_time());
        assert_eq!(from_parquet.table, table, "with units and kinds");
        let from_csv = read(&csv).unwrap().table;
        assert_eq!((from_csv.times(), from_csv.column("a")), (table.times(), table.column("a")));
    }

    #[test]
    fn files_of_other_tools_are_understood() {
        let german = read_text("a.csv", "\u{feff}Time [s];f [N];who\n0;0,5;x\n1,5;-1e-3;y\n").unwrap();
        assert_eq!(german.times(), [0.0, 1.5]);
        assert_eq!(german.columns(), [Column { name: "f".into(), unit: Some("N".into()), kind: Kind::Real }]);
        assert_eq!(german.column("f").unwrap(), [0.5, -1e-3]);
        let other = read_text("a.txt", "y\tt\tis\n1\t0\ttrue\n\t2\tFalse\n").unwrap();
        assert_eq!((other.times(), other.column("is").unwrap()), (&[0.0, 2.0][..], &[1.0, 0.0][..]));
        assert!(other.column("y").unwrap()[1].is_nan());
    }

    #[test]
    fn times_need_not_be_called_so() {
        for text in [
            "Zeit,x,note\n0,1,a\n1,2,b\n",
            "dt_sum,x,note\n0,1,a\n0.5,2,b\n",
            "phase,Elapsed [s],x\na,0,1\nb,1,2\n",
            "Elapsed [Seconds],x,note\n0,1,a\n1,2,b\n",
            "Elapsed [sec.],x\n0,1\n1,2\n",
            "tau [-],x\n0,1\n1,2\n",
            "time,sim [s],x\n12:00:00,0,1\n12:00:01,1,2\n",
            "n,x\n0,1\n1,2\n",
        ] {
            let times = read_text("a.csv", text).unwrap();
            assert!(times.times()[0] == 0.0 && times.column("x").unwrap() == [1.0, 2.0], "{text}");
        }
    }

    #[test]
    fn what_is_no_result_is_refused_with_the_reason() {
        for (name, text, reason) in [
            ("a.csv", "time,a\n", "there are no rows"),
            ("a.csv", "", "no column of numbers"),
            ("a.csv", "time,a\n0,1\n1,2,3\n", "line: 3"),
            ("a.csv", "time,a\n0,1\n2,1\n1,1\n", "fall from 2 to 1 at row 3"),
            ("a.csv", "time,a\n0,1\n,1\n", "row 2 has no time"),
            ("a.csv", "case,a\nx,1\ny,2\n", "no column is called time, and the column \"case\" holds texts"),
            (
                "a.csv",
                "run,M,status\n0,1,ok\n1,2,ok\n",
                "no column is called time, and the column \"status\" holds texts",
            ),
            ("a.csv", "n,time\n0,0 s\n1,1 s\n", "the column \"time\" holds texts, not numbers"),
            (
                "a.csv",
                "run,M,status\n160,1,ok\n161,2,ok\n",
                "no column is called time, and the column \"status\" holds texts",
            ),
            ("a.csv", "M,note\n2,a\n1,b\n", "no column is called time, and the column \"note\" holds texts"),
            ("a.csv", "M [kg],a\n0,1\n1,2\n", "no column is called time, and the first one, \"M\", has the unit kg"),
            ("a.csv", "M,a\n1,1\n1,2\n", "the times in the column \"M\" are all 1"),
            ("a.xlsx", "", "neither .csv"),
            ("a.parquet", "time", "can be read"),
        ] {
            let message = read_text(name, text).unwrap_err().to_string();
            assert!(message.contains(reason), "{message}");
        }
    }
}
