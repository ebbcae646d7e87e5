//! `documentation/index.html` and the files around it (FMI 2.0.4, section 2.3), generated from the same declarations as the
//! XML and from the author's texts. The page is one file without scripts and without references to other servers: it
//! contains its style sheet, formulas are `MathML`, charts are SVG.

mod articles;
mod chart;
mod page;
mod states;
mod tables;
mod text;

use fmi2_export::packaging::interface;
use fmi2_export::{Description, ExportedModel, Resources};
use quick_xml::escape::escape;
use tempfile::TempDir;

use self::page::Page;
use crate::platform::{PLATFORMS, Platform};
use crate::response;
use crate::{Document, File, PackageError, requirements};

pub const INDEX: &str = "documentation/index.html";
const ICON: &str = "model.png";
const LICENSE: &str = "documentation/licenses/license.txt";
const RESULTS: &str = "documentation/response.csv";
const INPUTS: &str = "documentation/response_in.csv";
const BESIDE: &str = "documentation/response_beside.csv";
/// The licences of the crates that the library is linked from.
pub const LINKED_LICENSES: &str = "documentation/licenses/linked-crates.txt";
/// Other paths of the archive that the author must not use.
const OURS: [&str; 5] = ["modelDescription.xml", "binaries/", "sources/", LINKED_LICENSES, requirements::PATH];

/// The origin of an archive and its platforms.
pub struct Origin {
    package: &'static str,
    platforms: Vec<&'static Platform>,
}

impl Origin {
    /// The crate of the models, and the platforms that the archive has libraries for.
    pub fn new(package: &'static str, mut platforms: Vec<&'static Platform>) -> Self {
        platforms.sort_by_key(|platform| PLATFORMS.iter().position(|known| known == *platform));
        platforms.dedup();
        Self { package, platforms }
    }

    fn folders(&self) -> String {
        self.platforms.iter().map(|platform| platform.folder).collect::<Vec<_>>().join(", ")
    }

    /// An attribute of the page with the name of the crate, so that a later packaging does not replace another crate's
    /// archive.
    fn mark(&self) -> String {
        if self.package.is_empty() { String::new() } else { format!(" {MARK}\"{}\"", escape(self.package)) }
    }
}

const MARK: &str = "data-crate=";

/// The crate of a page, if the page names it.
pub fn crate_of(page: &str) -> Option<&str> {
    page.split_once(MARK)?.1.split('"').nth(1)
}

/// The files of an archive besides description and library.
///
/// # Errors
/// If the document contradicts the model or the standard.
pub fn files(
    model: &'static dyn ExportedModel,
    description: &Description,
    document: &Document<'_>,
    origin: &Origin,
) -> Result<Vec<(String, Vec<u8>)>, PackageError> {
    let interface = interface(model)?;
    let wrong = |problem| PackageError::Document { model: description.name, problem };
    let text =
        text::read_from(document.text, document.links).map_err(|error| wrong(articles::not_understood(&error)))?;
    // All paths are checked before any file is written.
    let no_path =
        |path: &str| wrong(format!("{path:?} cannot be the path of a further file: it is taken, or no relative path"));
    if let Some(file) = document.files.iter().find(|file| !is_relative(file.path)) {
        return Err(no_path(file.path));
    }
    let run = match &document.response {
        Some(wanted) => {
            // The model may read files from its archive.
            let folder =
                unpacked(document.files).map_err(|error| wrong(format!("cannot unpack its resources: {error}")))?;
            let run = response::run(model, &interface, wanted, &Resources::at(folder.path()))
                .map_err(|source| PackageError::Response { model: description.name, source })?;
            Some((*wanted, run))
        }
        None => None,
    };
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    if !document.icon.is_empty() {
        if !document.icon.starts_with(b"\x89PNG\r\n\x1a\n") {
            return Err(wrong("the icon is no PNG, which FMI 2.0 wants model.png to be".into()));
        }
        files.push((ICON.into(), document.icon.to_vec()));
    }
    let page = Page { interface: &interface, description, document, origin, text: &text, run: run.as_ref() };
    files.push((INDEX.into(), page.to_html().map_err(wrong)?.into_bytes()));
    if !document.license.is_empty() {
        files.push((LICENSE.into(), document.license.into()));
    }
    if let Some((_, run)) = &run {
        files.push((RESULTS.into(), run.results_csv().into_bytes()));
        files.extend(run.inputs_csv().map(|csv| (INPUTS.into(), csv.into_bytes())));
        files.extend(run.beside_csv().map(|csv| (BESIDE.into(), csv.into_bytes())));
    }
    for file in document.files {
        let path = file.path;
        if OURS.iter().any(|ours| path.starts_with(ours)) || files.iter().any(|(taken, _)| taken == path) {
            return Err(no_path(path));
        }
        files.push((path.into(), file.content.to_vec()));
    }
    articles::add(&mut files, description.name, document.articles).map_err(wrong)?;
    if let Some(dead) = text.links.iter().find(|target| !articles::leads_somewhere(&files, target)) {
        return Err(wrong(format!(
            "its text has a link to {dead:?}, which is no address and no file of documentation/"
        )));
    }
    for image in &text.images {
        if !files.iter().any(|(path, _)| path.strip_prefix("documentation/") == Some(image.as_str())) {
            return Err(wrong(format!("the image {image} is not among its files as documentation/{image}")));
        }
    }
    Ok(files)
}

/// Whether an archive can have a file of this path.
fn is_relative(path: &str) -> bool {
    path.split('/').all(|part| !matches!(part, "" | "." | "..")) && !path.contains(['\\', ':'])
}

/// The files below `resources/` in a folder of their own.
fn unpacked(files: &[File<'_>]) -> std::io::Result<TempDir> {
    let folder = TempDir::new()?;
    for file in files {
        let Some(path) = file.path.strip_prefix("resources/") else { continue };
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap_or(folder.path()))?;
        std::fs::write(path, file.content)?;
    }
    Ok(folder)
}
