//! An `.ssp` file: a zip archive with system structures at its root, and FMUs and parameters in `resources/`.

use std::fs::{self, File};
use std::io::{self, BufReader, Cursor, Read, Write};
use std::path::{Component as PathPart, Path, PathBuf};

use tempfile::TempDir;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::error::{DocumentError, SspError};
use super::parameters::ParameterSet;
use super::read;
use super::resolve::{Resolved, resolve};
use super::structure::{Binding, Experiment, Line, Mapping, MappingEntry, SystemStructure, Values};
use crate::names::closest;
use crate::system::{self, Connections, System};
use fmi2_import::xml::Fault;
use fmi2_import::{Fmu, FmuError};

/// The system structure that every package has.
pub const DEFAULT_STRUCTURE: &str = "SystemStructure.ssd";

/// An SSP that is read, with its FMUs unpacked to a temporary folder; they vanish with it.
#[derive(Debug)]
pub struct Package {
    path: PathBuf,
    document: String,
    structure: SystemStructure,
    component_sets: Vec<Vec<BoundSet>>,
    system_sets: Vec<BoundSet>,
    fmus: Vec<PathBuf>,
    _folder: TempDir,
}

/// A binding with its parameters at hand.
#[derive(Debug)]
pub(super) struct BoundSet {
    /// The document that has the parameters.
    pub document: String,
    pub set: ParameterSet,
    pub prefix: String,
    pub mapping: Option<Vec<MappingEntry>>,
}

impl Package {
    /// Reads `FILE.ssp`, or one variant of it as `FILE.ssp#VARIANT.ssd`, and unpacks its FMUs.
    ///
    /// # Errors
    /// When the file is no SSP, is damaged, lacks something it refers to, or has something this tool does not support.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, SspError> {
        let (path, document) = split_variant(path.as_ref());
        let mut archive = Archive::open(&path)?;
        let structure = archive.parse(&document, None, read::system_structure)?;

        let system_sets = archive.bound_sets(&document, &structure.system.bindings)?;
        let components = &structure.system.components;
        let component_sets = components
            .iter()
            .map(|component| archive.bound_sets(&document, &component.bindings))
            .collect::<Result<_, _>>()?;

        let folder = tempfile::Builder::new().prefix("fmi2-cosim-").tempdir();
        let folder = folder.map_err(|source| archive.unpack_error(&document, source))?;
        let mut fmus = Vec::new();
        for (index, component) in components.iter().enumerate() {
            let entry = archive.inside(&document, &component.source, component.line)?;
            let bytes = archive.bytes(&entry, Some((&document, component.line)))?;
            // Two components may have FMUs of one name in different folders of the archive.
            let own = folder.path().join(index.to_string());
            let fmu = own.join(Path::new(&entry).file_name().unwrap_or_default());
            let write = fs::create_dir(&own).and_then(|()| fs::write(&fmu, bytes));
            write.map_err(|source| archive.unpack_error(&entry, source))?;
            fmus.push(fmu);
        }
        Ok(Self { path, document, structure, component_sets, system_sets, fmus, _folder: folder })
    }

    /// The file and the document in it, for messages.
    pub(super) fn place(&self, document: &str, line: Line) -> String {
        format!("{}, {document}:{}", self.path.display(), line.0)
    }

    /// What the system consists of.
    #[must_use]
    pub fn structure(&self) -> &SystemStructure {
        &self.structure
    }

    /// Loads the FMUs and finds the variables that the connections and parameters mean.
    ///
    /// # Errors
    /// When an FMU cannot be used, or a connection or a parameter does not fit the FMUs.
    pub fn system(&self) -> Result<System, SspError> {
        let components = self.open_fmus()?;
        let descriptions: Vec<_> = components.iter().map(|(_, fmu)| fmu.description()).collect();
        let Resolved { wires, settings, remarks } = resolve(self, &descriptions)?;
        let Experiment { start, stop, step } = self.structure.experiment;
        let description = self.structure.description.clone();
        Ok(System {
            title: Some(description.unwrap_or_else(|| self.structure.name.clone())),
            connections: Connections::Explicit(wires),
            settings,
            inputs: Vec::new(),
            experiment: system::Experiment { start, stop, step, ..system::Experiment::default() },
            remarks,
            components,
        })
    }

    fn open_fmus(&self) -> Result<Vec<(String, Fmu)>, SspError> {
        let components = self.structure.system.components.iter().zip(&self.fmus);
        components
            .map(|(component, file)| match Fmu::open(file) {
                Ok(fmu) => Ok((component.name.clone(), fmu)),
                Err(source) => Err(self.fmu_error(&component.source, source)),
            })
            .collect()
    }

    pub(super) fn system_sets(&self) -> &[BoundSet] {
        &self.system_sets
    }

    pub(super) fn component_sets(&self, component: usize) -> &[BoundSet] {
        &self.component_sets[component]
    }

    /// Makes an error of the system structure's document.
    pub(super) fn error(&self, source: DocumentError) -> SspError {
        self.error_in(&self.document, source)
    }

    pub(super) fn error_in(&self, document: &str, source: DocumentError) -> SspError {
        SspError::Document { path: self.path.clone(), document: document.to_owned(), source: Box::new(source) }
    }

    fn fmu_error(&self, entry: &str, source: FmuError) -> SspError {
        SspError::Fmu { path: self.path.clone(), entry: entry.to_owned(), source: Box::new(source) }
    }
}

/// Splits `FILE.ssp#VARIANT.ssd`, the notation of SSP 1.0 for a variant of a package.
fn split_variant(path: &Path) -> (PathBuf, String) {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    match name.split_once(".ssp#") {
        Some((stem, variant)) => (path.with_file_name(format!("{stem}.ssp")), variant.to_owned()),
        None => (path.to_owned(), DEFAULT_STRUCTURE.to_owned()),
    }
}

/// Whether a file is an SSP by its name, or a variant of one.
#[must_use]
pub fn is_ssp(path: &Path) -> bool {
    split_variant(path).0.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ssp"))
}

struct Archive {
    path: PathBuf,
    zip: ZipArchive<BufReader<File>>,
}

impl Archive {
    fn open(path: &Path) -> Result<Self, SspError> {
        let read = |source| SspError::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(read)?;
        if file.metadata().map_err(read)?.is_dir() {
            return Err(read(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder")));
        }
        let mut zip = ZipArchive::new(BufReader::new(file))
            .map_err(|error| SspError::NotAZip { path: path.to_owned(), reason: error.to_string() })?;
        for index in 0..zip.len() {
            let entry = zip.by_index_raw(index);
            let entry =
                entry.map_err(|error| SspError::NotAZip { path: path.to_owned(), reason: error.to_string() })?;
            if entry.enclosed_name().is_none() || entry.name_raw().starts_with(b"/") {
                let entry = String::from_utf8_lossy(entry.name_raw()).into_owned();
                return Err(SspError::UnsafeEntry { path: path.to_owned(), entry });
            }
        }
        Ok(Self { path: path.to_owned(), zip })
    }

    /// Content of an entry. When there is none, `wanted` says which document asks for it, and on which line.
    fn bytes(&mut self, entry: &str, wanted: Option<(&str, Line)>) -> Result<Vec<u8>, SspError> {
        let mut bytes = Vec::new();
        let result = match self.zip.by_name(entry) {
            Ok(mut file) => file.read_to_end(&mut bytes).map_err(ZipError::Io),
            Err(error) => Err(error),
        };
        match result {
            Ok(_) => Ok(bytes),
            Err(ZipError::FileNotFound) => Err(self.not_found(entry, wanted)),
            Err(error) => Err(SspError::NotAZip { path: self.path.clone(), reason: format!("{entry}: {error}") }),
        }
    }

    fn not_found(&self, entry: &str, wanted: Option<(&str, Line)>) -> SspError {
        let mut names: Vec<_> = self.zip.file_names().flatten().collect();
        names.sort_unstable();
        if let Some((document, line)) = wanted {
            let similar = closest(entry, names.iter().map(AsRef::as_ref)).first().map(ToString::to_string);
            let what = format!("file {entry} in the archive");
            return self.document_error(document, DocumentError::Unknown { what, similar, line: line.0 });
        }
        names.retain(|name| Path::new(name.as_ref()).extension().is_some_and(|extension| extension == "ssd"));
        names.retain(|name| !name.contains('/'));
        SspError::NoStructure { path: self.path.clone(), wanted: entry.to_owned(), available: names.join(", ") }
    }

    fn parse<T>(
        &mut self,
        entry: &str,
        wanted: Option<(&str, Line)>,
        parse: impl FnOnce(&[u8]) -> Result<T, DocumentError>,
    ) -> Result<T, SspError> {
        let bytes = self.bytes(entry, wanted)?;
        parse(&bytes).map_err(|source| self.document_error(entry, source))
    }

    fn bound_sets(&mut self, document: &str, bindings: &[Binding]) -> Result<Vec<BoundSet>, SspError> {
        let mut sets = Vec::new();
        for binding in bindings {
            let wanted = Some((document, binding.line));
            let (source, set) = match &binding.values {
                Values::Inline(set) => (document.to_owned(), set.clone()),
                Values::File(source) => {
                    let entry = self.inside(document, source, binding.line)?;
                    let set = self.parse(&entry, wanted, read::parameter_set)?;
                    (entry, set)
                }
            };
            let mapping = match &binding.mapping {
                None => None,
                Some(Mapping::Inline(entries)) => Some(entries.clone()),
                Some(Mapping::File(source)) => {
                    let entry = self.inside(document, source, binding.line)?;
                    Some(self.parse(&entry, wanted, read::parameter_mapping)?)
                }
            };
            sets.push(BoundSet { document: source, set, prefix: binding.prefix.clone(), mapping });
        }
        Ok(sets)
    }

    /// The entry that a relative URI means.
    fn inside(&self, document: &str, uri: &str, line: Line) -> Result<String, SspError> {
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

    fn unpack_error(&self, entry: &str, source: io::Error) -> SspError {
        SspError::Unpack { path: self.path.clone(), entry: entry.to_owned(), source }
    }
}

/// `%20` and the like as the characters they stand for (RFC 3986, section 2.1).
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

/// The bytes of an archive with these entries. The same content always gives the same bytes: entries carry no time of
/// day.
///
/// # Errors
/// When an entry is larger than an archive of SSP 1.0 can hold.
pub fn archive<'a>(entries: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> io::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default()).unix_permissions(0o644);
    for (name, content) in entries {
        // FMUs are archives themselves: nothing to gain.
        let is_packed = Path::new(name).extension().is_some_and(|extension| extension == "fmu");
        let method = if is_packed { CompressionMethod::Stored } else { CompressionMethod::Deflated };
        zip.start_file(name, options.compression_method(method))?;
        zip.write_all(content)?;
    }
    Ok(zip.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_follow_a_number_sign() {
        let split = |path: &str| split_variant(Path::new(path));
        assert_eq!(split("a/b.ssp"), ("a/b.ssp".into(), DEFAULT_STRUCTURE.to_owned()));
        assert_eq!(split("a/b.ssp#Fast.ssd"), ("a/b.ssp".into(), "Fast.ssd".to_owned()));
        assert!(is_ssp(Path::new("b.SSP")) && is_ssp(Path::new("b.ssp#x.ssd")) && !is_ssp(Path::new("b.fmu")));
    }

    #[test]
    fn uris_are_decoded() {
        assert_eq!(percent_decoded("resources/a%20b%2e%C3%BC.fmu"), "resources/a b.ü.fmu");
        assert_eq!(percent_decoded("100%"), "100%");
        assert_eq!(percent_decoded("%zz%4"), "%zz%4");
    }
}
