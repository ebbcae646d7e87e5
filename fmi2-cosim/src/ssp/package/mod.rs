//! An `.ssp` file: a zip archive with system structures at its root, and FMUs and parameters in `resources/`.

mod documents;

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fmi2_import::archive::ArchiveError;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::error::{DocumentError, SspError};
use super::parameters::{ParameterSet, ParameterValue};
use super::read;
use super::resolve::{Resolved, resolve};
use super::structure::{DefaultExperiment, MappingEntry, SystemStructure};
use crate::files::has_extension;
use crate::system::{self, Connections, SourceLine, System};
use documents::Documents;
use fmi2_import::{Fmu, FmuError};

/// The system structure that every package has.
pub const DEFAULT_STRUCTURE: &str = "SystemStructure.ssd";

/// An SSP with its FMUs unpacked to a temporary folder, which is removed together with this value.
#[derive(Debug)]
pub struct Package {
    path: PathBuf,
    document: String,
    structure: SystemStructure,
    component_sets: Vec<Vec<BoundSet>>,
    system_sets: Vec<BoundSet>,
    /// The unpacked FMU of each component; components may share one.
    fmus: Vec<PathBuf>,
    _folder: TempDir,
}

/// A binding with its parameters. A document that is bound more than once is read once.
#[derive(Debug)]
pub(super) struct BoundSet {
    /// The document that has the parameters.
    pub document: String,
    /// The same with the file, as messages name it.
    pub place: Arc<str>,
    pub set: Arc<ParameterSet>,
    pub prefix: String,
    pub mapping: Option<Arc<Vec<MappingEntry>>>,
}

impl BoundSet {
    /// The name that a parameter is applied to, without a mapping.
    pub fn prefixed<'a>(&self, name: &'a str) -> Cow<'a, str> {
        if self.prefix.is_empty() { name.into() } else { format!("{}{name}", self.prefix).into() }
    }

    /// The line of a parameter.
    pub fn line(&self, parameter: &ParameterValue) -> SourceLine {
        SourceLine { file: Arc::clone(&self.place), line: parameter.line.0 as usize }
    }
}

impl Package {
    /// Reads `FILE.ssp`, or one variant of it as `FILE.ssp#VARIANT.ssd`, and unpacks its FMUs.
    ///
    /// # Errors
    /// When the file is not an SSP, is damaged, lacks a file it refers to, or has features that this tool does not support.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, SspError> {
        let (path, document) = split_variant(path.as_ref());
        let mut archive = Documents::open(&path)?;
        let structure = archive.parse(&document, None, read::system_structure)?;

        if structure.system.components.is_empty() {
            let source = DocumentError::Conflict { problem: "the system has no components".into(), line: 1 };
            return Err(SspError::Document { path, document, source: Box::new(source) });
        }

        let system_sets = archive.bound_sets(&document, &structure.system.bindings)?;
        let components = &structure.system.components;
        let component_sets = components
            .iter()
            .map(|component| archive.bound_sets(&document, &component.bindings))
            .collect::<Result<_, _>>()?;

        let folder = tempfile::Builder::new().prefix("fmi2-cosim-").tempdir();
        let folder = folder.map_err(|source| archive.unpack_error(&document, source))?;
        let mut fmus = Vec::new();
        let mut unpacked: HashMap<String, PathBuf> = HashMap::new();
        for component in components {
            let entry = archive.inside(&document, &component.source, component.line)?;
            if let Some(fmu) = unpacked.get(&entry) {
                fmus.push(fmu.clone());
                continue;
            }
            // There may be FMUs of one name in different folders of the archive.
            let own = folder.path().join(unpacked.len().to_string());
            let fmu = own.join(Path::new(&entry).file_name().unwrap_or_default());
            match archive.zip.unpack_file(&entry, &fmu) {
                Ok(()) => {}
                Err(ArchiveError::NotFound) => return Err(archive.not_found(&entry, Some((&document, component.line)))),
                Err(ArchiveError::Read(source)) => return Err(archive.unpack_error(&entry, source)),
                Err(source) => return Err(archive.error(&entry, source)),
            }
            fmus.push(fmu.clone());
            unpacked.insert(entry, fmu);
        }
        Ok(Self { path, document, structure, component_sets, system_sets, fmus, _folder: folder })
    }

    /// The structure of the system.
    #[must_use]
    pub fn structure(&self) -> &SystemStructure {
        &self.structure
    }

    /// Unpacks the FMUs and finds the variables that the connections and parameters mean.
    ///
    /// # Errors
    /// When an FMU cannot be used, or a connection or a parameter does not fit the FMUs.
    pub fn system(&self) -> Result<System, SspError> {
        let components = self.open_fmus()?;
        let descriptions: Vec<_> = components.iter().map(|(_, fmu)| fmu.description()).collect();
        let Resolved { wires, values, mut remarks } = resolve(self, &descriptions)?;
        let DefaultExperiment { start, stop, step, tolerance } = self.structure.experiment;
        let usable = tolerance.filter(|tolerance| system::is_tolerance(*tolerance));
        if let (Some(tolerance), None) = (tolerance, usable) {
            remarks.push(format!(
                "{}, {}: the relative tolerance {tolerance} is no positive number; each FMU has its own",
                self.path.display(),
                self.document
            ));
        }
        let description = self.structure.description.clone();
        Ok(System {
            title: Some(description.unwrap_or_else(|| self.structure.name.clone())),
            description: String::new(),
            connections: Connections::Explicit(wires),
            values,
            settings: Vec::new(),
            inputs: Vec::new(),
            overrides: Vec::new(),
            experiment: system::RunOptions { start, stop, step, tolerance: usable, ..system::RunOptions::default() },
            remarks,
            components,
        })
    }

    fn open_fmus(&self) -> Result<Vec<(String, Fmu)>, SspError> {
        let mut opened: HashMap<&Path, Fmu> = HashMap::new();
        let mut components = Vec::new();
        for (component, file) in self.structure.system.components.iter().zip(&self.fmus) {
            let fmu = match opened.get(file.as_path()) {
                Some(fmu) => fmu.clone(),
                None => Fmu::unpack(file).map_err(|source| self.fmu_error(&component.source, source))?,
            };
            opened.insert(file, fmu.clone());
            components.push((component.name.clone(), fmu));
        }
        Ok(components)
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
#[must_use]
pub fn split_variant(path: &Path) -> (PathBuf, String) {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    match name.split_once(".ssp#") {
        Some((stem, variant)) => (path.with_file_name(format!("{stem}.ssp")), variant.to_owned()),
        None => (path.to_owned(), DEFAULT_STRUCTURE.to_owned()),
    }
}

/// Whether a file is an SSP by its name, or a variant of one.
#[must_use]
pub fn is_ssp(path: &Path) -> bool {
    has_extension(&split_variant(path).0, "ssp")
}

/// The bytes of an archive with these entries. The same content always gives the same bytes: entries have no time
/// stamps.
///
/// # Errors
/// When an entry is larger than an archive of SSP 1.0 can hold.
pub fn archive<'a>(entries: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> io::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default()).unix_permissions(0o644);
    for (name, content) in entries {
        // FMUs are compressed archives themselves: compressing them again gains nothing.
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
}
