//! The documents in an open archive: each is found, read and, if it is bound more than once, kept.

use std::collections::HashMap;
use std::io;
use std::path::{Component as PathPart, Path, PathBuf};
use std::sync::Arc;

use fmi2_import::archive::{Archive, ArchiveError};
use fmi2_import::xml::Fault;

use super::BoundSet;
use crate::names::best;
use crate::ssp::error::{DocumentError, SspError};
use crate::ssp::parameters::ParameterSet;
use crate::ssp::read;
use crate::ssp::structure::{Binding, Line, Mapping, MappingEntry, Values};

/// Names in a message.
const SHOWN: usize = 20;

/// An open archive and the documents in it that were read.
pub(super) struct Documents {
    path: PathBuf,
    pub zip: Archive,
    sets: HashMap<String, Arc<ParameterSet>>,
    mappings: HashMap<String, Arc<Vec<MappingEntry>>>,
    places: HashMap<String, Arc<str>>,
}

impl Documents {
    pub fn open(path: &Path) -> Result<Self, SspError> {
        let zip = Archive::open(path).map_err(|error| match error {
            ArchiveError::Read(source) => SspError::Read { path: path.to_owned(), source },
            ArchiveError::UnsafeEntry(entry) => SspError::UnsafeEntry { path: path.to_owned(), entry },
            other => SspError::NotAZip { path: path.to_owned(), reason: other.to_string() },
        })?;
        Ok(Self { path: path.to_owned(), zip, sets: HashMap::new(), mappings: HashMap::new(), places: HashMap::new() })
    }

    /// Content of an entry. If there is none, the error says which document refers to it (`wanted`), and on which line.
    fn bytes(&mut self, entry: &str, wanted: Option<(&str, Line)>) -> Result<Vec<u8>, SspError> {
        match self.zip.read(entry) {
            Ok(bytes) => Ok(bytes),
            Err(ArchiveError::NotFound) => Err(self.not_found(entry, wanted)),
            Err(error) => Err(self.error(entry, error)),
        }
    }

    pub fn error(&self, entry: &str, source: ArchiveError) -> SspError {
        SspError::Entry { path: self.path.clone(), entry: entry.to_owned(), source }
    }

    pub fn not_found(&self, entry: &str, wanted: Option<(&str, Line)>) -> SspError {
        let mut names = self.zip.files();
        if let Some((document, line)) = wanted {
            let similar = best(entry, names.into_iter());
            let what = format!("file {entry} in the archive");
            return self.document_error(document, DocumentError::Unknown { what, similar, line: line.0 });
        }
        names.retain(|name| !name.contains('/') && Path::new(name).extension().is_some_and(|ending| ending == "ssd"));
        names.truncate(SHOWN);
        SspError::NoStructure { path: self.path.clone(), wanted: entry.to_owned(), available: names.join(", ") }
    }

    pub fn parse<T>(
        &mut self,
        entry: &str,
        wanted: Option<(&str, Line)>,
        parse: impl FnOnce(&[u8]) -> Result<T, DocumentError>,
    ) -> Result<T, SspError> {
        let bytes = self.bytes(entry, wanted)?;
        parse(&bytes).map_err(|source| self.document_error(entry, source))
    }

    pub fn bound_sets(&mut self, document: &str, bindings: &[Binding]) -> Result<Vec<BoundSet>, SspError> {
        let mut sets = Vec::new();
        for binding in bindings {
            let wanted = Some((document, binding.line));
            let (source, set) = match &binding.values {
                Values::Inline(set) => (document.to_owned(), Arc::new(set.clone())),
                Values::File(source) => {
                    let entry = self.inside(document, source, binding.line)?;
                    let known = self.sets.get(&entry).cloned();
                    let set = match known {
                        Some(set) => set,
                        None => Arc::new(self.parse(&entry, wanted, read::parameter_set)?),
                    };
                    self.sets.insert(entry.clone(), Arc::clone(&set));
                    (entry, set)
                }
            };
            let mapping = match &binding.mapping {
                None => None,
                Some(Mapping::Inline(entries)) => Some(Arc::new(entries.clone())),
                Some(Mapping::File(source)) => {
                    let entry = self.inside(document, source, binding.line)?;
                    let known = self.mappings.get(&entry).cloned();
                    let mapping = match known {
                        Some(mapping) => mapping,
                        None => Arc::new(self.parse(&entry, wanted, read::parameter_mapping)?),
                    };
                    self.mappings.insert(entry, Arc::clone(&mapping));
                    Some(mapping)
                }
            };
            let place = self.place(&source);
            sets.push(BoundSet { document: source, place, set, prefix: binding.prefix.clone(), mapping });
        }
        Ok(sets)
    }

    /// The name of a document in messages, shared by all messages.
    fn place(&mut self, document: &str) -> Arc<str> {
        if let Some(known) = self.places.get(document) {
            return Arc::clone(known);
        }
        let place: Arc<str> = format!("{}, {document}", self.path.display()).into();
        self.places.insert(document.to_owned(), Arc::clone(&place));
        place
    }

    /// The entry that a relative URI means.
    pub fn inside(&self, document: &str, uri: &str, line: Line) -> Result<String, SspError> {
        let entry = percent_decoded(uri);
        let entry = entry.strip_prefix("./").unwrap_or(&entry);
        let is_relative = !entry.is_empty()
            && !entry.contains(['\\', ':', '#'])
            && Path::new(entry).components().all(|part| matches!(part, PathPart::Normal(_)));
        if is_relative {
            return Ok(entry.to_owned());
        }
        Err(self.document_error(
            document,
            DocumentError::Content(Fault::Value {
                attribute: "source".into(),
                value: uri.to_owned(),
                expected: "a path inside the archive, such as resources/model.fmu",
                line: line.0,
            }),
        ))
    }

    fn document_error(&self, document: &str, source: DocumentError) -> SspError {
        SspError::Document { path: self.path.clone(), document: document.to_owned(), source: Box::new(source) }
    }

    pub fn unpack_error(&self, entry: &str, source: io::Error) -> SspError {
        SspError::Unpack { path: self.path.clone(), entry: entry.to_owned(), source }
    }
}

/// Replaces `%20` and the like by the characters that they encode (RFC 3986, section 2.1).
fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut rest = bytes;
    while let Some((&first, tail)) = rest.split_first() {
        let digits = tail.get(..2).filter(|digits| first == b'%' && digits.iter().all(u8::is_ascii_hexdigit));
        let code = digits.and_then(|digits| u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok());
        decoded.push(code.unwrap_or(first));
        rest = if code.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&decoded).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_are_decoded() {
        assert_eq!(percent_decoded("resources/a%20b%2e%C3%BC.fmu"), "resources/a b.ü.fmu");
        assert_eq!(percent_decoded("100%"), "100%");
        assert_eq!(percent_decoded("%zz%4"), "%zz%4");
    }
}
