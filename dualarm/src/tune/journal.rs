//! The state of a search: a file of its evaluations, one line each.
//!
//! The method is deterministic. A repeated search therefore requests the same points. The journal returns the costs of
//! those that it has, and the search continues after them as if it had never stopped. Costs are stored with the fewest
//! digits that read back exactly.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::TuneError;
use crate::fingerprint::difference;

/// One evaluation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Entry {
    values: Vec<String>,
    cost: String,
}

/// The evaluations of a search, on disk.
pub struct Journal {
    path: PathBuf,
    file: File,
    known: std::vec::IntoIter<Entry>,
}

impl Journal {
    /// Opens the journal of the search with this fingerprint, or begins one.
    ///
    /// # Errors
    /// When the file cannot be read or written, or belongs to another search.
    pub fn open(path: &Path, fingerprint: &Value) -> Result<Self, TuneError> {
        let state = |source| TuneError::State { path: path.to_owned(), source };
        let text = match fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            text => text.map_err(state)?,
        };
        // A line without its end was being written when the search was interrupted.
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let mut lines = whole.lines();
        let known = match lines.next() {
            None => Vec::new(),
            Some(first) => {
                let header: Value = serde_json::from_str(first).map_err(|error| state(error.into()))?;
                if header != *fingerprint {
                    let what = difference(&header, fingerprint);
                    return Err(TuneError::OtherSearch { path: path.to_owned(), what });
                }
                lines.map(serde_json::from_str).collect::<Result<_, _>>().map_err(|error| state(error.into()))?
            }
        };
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(state)?;
        }
        let mut file = OpenOptions::new().create(true).truncate(false).write(true).open(path).map_err(state)?;
        let mut begin = || -> io::Result<()> {
            file.set_len(whole.len() as u64)?;
            io::Seek::seek(&mut file, io::SeekFrom::End(0))?;
            if whole.is_empty() {
                writeln!(file, "{fingerprint}")?;
            }
            file.flush()
        };
        begin().map_err(state)?;
        Ok(Self { path: path.to_owned(), file, known: known.into_iter() })
    }

    /// The cost of the next evaluation if the journal has it.
    ///
    /// # Errors
    /// When the journal has another point there.
    pub fn next(&mut self, values: &[f64]) -> Result<Option<f64>, TuneError> {
        let Some(entry) = self.known.next() else { return Ok(None) };
        match entry.cost.parse() {
            Ok(cost) if entry.values == digits(values) => Ok(Some(cost)),
            _ => Err(TuneError::OtherSearch { path: self.path.clone(), what: "way through the parameters".into() }),
        }
    }

    /// Adds an evaluation.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(&mut self, values: &[f64], cost: f64) -> Result<(), TuneError> {
        let entry = Entry { values: digits(values), cost: cost.to_string() };
        let mut add = || -> io::Result<()> {
            let line = serde_json::to_string(&entry)? + "\n";
            self.file.write_all(line.as_bytes())?;
            self.file.flush()
        };
        add().map_err(|source| TuneError::State { path: self.path.clone(), source })
    }
}

fn digits(values: &[f64]) -> Vec<String> {
    values.iter().map(f64::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_was_added_is_known_after_an_interruption() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/search.jsonl");
        let print = json!({ "seed": 1 });
        let mut journal = Journal::open(&path, &print).unwrap();
        assert_eq!(journal.next(&[1.0]).unwrap(), None);
        journal.add(&[0.1 + 0.2], 1.0 / 3.0).unwrap();
        journal.add(&[2.0], 4.0).unwrap();
        drop(journal);
        // The last line is torn.
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, &text[..text.len() - 3]).unwrap();
        let mut journal = Journal::open(&path, &print).unwrap();
        assert_eq!(journal.next(&[0.1 + 0.2]).unwrap(), Some(1.0 / 3.0));
        assert_eq!(journal.next(&[2.0]).unwrap(), None);
        journal.add(&[2.0], 4.0).unwrap();
        drop(journal);
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        let mut journal = Journal::open(&path, &print).unwrap();
        assert!(journal.next(&[9.0]).is_err());
        let message = Journal::open(&path, &json!({ "seed": 2 })).err().unwrap().to_string();
        assert!(message.contains("its seed differs; delete it to begin anew"), "{message}");
    }
}
