//! The rows of a study as they are computed, one line of JSON each, so that an interrupted study can be continued.
//!
//! Only the position of each row is kept in memory: 8 bytes for a run. Rows are read back in the order of runs.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{Row, SweepError};
use crate::fingerprint::difference;

/// The rows of a study, on disk.
pub struct Journal {
    path: PathBuf,
    file: File,
    end: u64,
    /// The position of each run's row in the file; 0, the position of the header, means that there is none.
    places: Vec<u64>,
}

impl Journal {
    /// Opens the journal of the study with this fingerprint and number of runs, or begins one.
    ///
    /// # Errors
    /// When the file cannot be read or written, or belongs to another study.
    pub fn open(path: &Path, fingerprint: &str, runs: u64) -> Result<Self, SweepError> {
        let state = |source| SweepError::State { path: path.to_owned(), source };
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(state)?;
        }
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let mut file = options.map_err(state)?;
        if let Err(fs::TryLockError::WouldBlock) = file.try_lock() {
            return Err(state(io::Error::new(io::ErrorKind::ResourceBusy, "another sweep is at work on it")));
        }
        let mut reader = BufReader::new(&file);
        let (mut line, mut end) = (String::new(), 0);
        let mut places = vec![0; usize::try_from(runs).unwrap_or_default()];
        loop {
            line.clear();
            let length = reader.read_line(&mut line).map_err(state)?;
            // A line without its end was being written when the study was ended.
            if !line.ends_with('\n') {
                break;
            }
            if end == 0 {
                let header: Value = serde_json::from_str(&line).map_err(|error| state(error.into()))?;
                let written: Value = serde_json::from_str(fingerprint).map_err(|error| state(error.into()))?;
                if header != written {
                    return Err(SweepError::OtherStudy { path: path.to_owned(), what: difference(&header, &written) });
                }
            } else {
                let row: Row = serde_json::from_str(&line).map_err(|error| state(error.into()))?;
                if let Some(place) = usize::try_from(row.run).ok().and_then(|run| places.get_mut(run)) {
                    *place = end;
                }
            }
            end += length as u64;
        }
        file.set_len(end).map_err(state)?;
        if end == 0 {
            let line = format!("{fingerprint}\n");
            file.seek(SeekFrom::Start(0)).and_then(|_| file.write_all(line.as_bytes())).map_err(state)?;
            end = line.len() as u64;
        }
        Ok(Self { path: path.to_owned(), file, end, places })
    }

    /// Whether it has the row of a run.
    #[must_use]
    pub fn has(&self, run: u64) -> bool {
        usize::try_from(run).ok().and_then(|run| self.places.get(run)).is_some_and(|place| *place > 0)
    }

    /// Adds a row.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(&mut self, row: &Row) -> Result<(), SweepError> {
        let add = |journal: &mut Self| -> io::Result<()> {
            let line = serde_json::to_string(row)? + "\n";
            journal.file.seek(SeekFrom::Start(journal.end))?;
            journal.file.write_all(line.as_bytes())?;
            if let Some(place) = usize::try_from(row.run).ok().and_then(|run| journal.places.get_mut(run)) {
                *place = journal.end;
            }
            journal.end += line.len() as u64;
            Ok(())
        };
        add(self).map_err(|source| SweepError::State { path: self.path.clone(), source })
    }

    /// The row of a run that it has.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn row(&mut self, run: u64) -> Result<Row, SweepError> {
        let read = |journal: &mut Self| -> io::Result<Row> {
            let place = usize::try_from(run).ok().and_then(|run| journal.places.get(run)).copied().unwrap_or_default();
            journal.file.seek(SeekFrom::Start(place))?;
            let mut line = String::new();
            BufReader::with_capacity(1 << 10, (&journal.file).take(journal.end - place)).read_line(&mut line)?;
            Ok(serde_json::from_str(&line)?)
        };
        read(self).map_err(|source| SweepError::State { path: self.path.clone(), source })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::{Figure, Status};

    fn row(run: u64, value: f64) -> Row {
        Row { run, status: Status::Ok, error: None, figures: vec![Some(Figure(value)), None] }
    }

    #[test]
    fn rows_are_known_after_an_interruption_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/study.jsonl");
        let print = r#"{"seed":1,"stop":0.30000000000000004}"#;
        let mut journal = Journal::open(&path, print, 9).unwrap();
        journal.add(&row(7, 0.1 + 0.2)).unwrap();
        journal.add(&row(2, f64::NEG_INFINITY)).unwrap();
        journal.add(&row(3, 1.0)).unwrap();
        drop(journal);
        // The last line is torn.
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, &text[..text.len() - 3]).unwrap();
        let mut journal = Journal::open(&path, print, 9).unwrap();
        assert_eq!((0..9).filter(|run| journal.has(*run)).collect::<Vec<_>>(), [2, 7]);
        assert_eq!((journal.row(7).unwrap(), journal.row(2).unwrap()), (row(7, 0.1 + 0.2), row(2, f64::NEG_INFINITY)));
        journal.add(&row(3, 1.0)).unwrap();
        assert_eq!(journal.row(3).unwrap(), row(3, 1.0));
        drop(journal);
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        let message = Journal::open(&path, r#"{"seed":2}"#, 9).err().unwrap().to_string();
        assert!(message.contains("its seed differs; delete it to begin anew"), "{message}");
    }
}
