#![doc = include_str!("../README.md")]

mod archive;
mod arguments;
mod build;
mod document;
mod response;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use fmi2_export::{DeclarationError, Description};
use fmi2_export::{ExportedModel, Library};

pub use archive::{Archive, platform_folder};
pub use build::BuildError;
pub use response::{OfTime, Panel, Response, ResponseError};

use arguments::{Command, HELP, parse};

/// What a model's author says of it besides its declarations. Every part is optional.
#[derive(Clone, Copy, Debug)]
pub struct Document<'a> {
    /// Name of the model.
    pub model: &'a str,
    /// What it models and how, in Markdown; formulas in LaTeX between `$`, or `$$` on lines of their own. Headings start
    /// at the second level (`##`). Images are [`files`](Self::files) below `documentation/`.
    pub text: &'a str,
    /// The icon that tools show, as PNG: becomes `model.png`. It brings its own ground: pages and tools may be dark.
    pub icon: &'a [u8],
    /// The licence's text: becomes `documentation/licenses/license.txt`.
    pub license: &'a str,
    /// A run whose results the page shows.
    pub response: Option<Response<'a>>,
    /// How the archive was made, as one would type it; `cargo fmi2 package` if empty.
    pub command: &'a str,
    /// Further files.
    pub files: &'a [File<'a>],
}

impl Document<'_> {
    /// Nothing, to fill up a definition with: `Document { model: "Lag", text: "…", ..Document::new() }`.
    #[must_use]
    pub const fn new() -> Self {
        Self { model: "", text: "", icon: &[], license: "", response: None, command: "", files: &[] }
    }
}

impl Default for Document<'_> {
    fn default() -> Self {
        Self::new()
    }
}

/// A file to put into a model's archive besides what is generated.
#[derive(Clone, Copy, Debug)]
pub struct File<'a> {
    /// Path in the archive, e.g. `documentation/figure.svg`.
    pub path: &'a str,
    /// Its content.
    pub content: &'a [u8],
}

/// Why packaging failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PackageError {
    /// The command line could not be understood.
    #[error("{0}; --help tells what is possible")]
    Usage(String),
    /// A model's declarations contradict themselves.
    #[error(transparent)]
    Declaration(#[from] DeclarationError),
    /// The library could not be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// There is a document for a model that the library does not have.
    #[error("there is a document for {model:?}, but the models of this library are {}", known.join(", "))]
    NoSuchModel {
        /// The document's model.
        model: String,
        /// The models there are.
        known: Vec<&'static str>,
    },
    /// A part of a document cannot become part of an FMU.
    #[error("document of {model}: {problem}")]
    Document {
        /// The model.
        model: &'static str,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// The run for the page's figure failed.
    #[error("response in the document of {model}: {source}")]
    Response {
        /// The model.
        model: &'static str,
        /// Why.
        source: ResponseError,
    },
    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        /// `read`, `write` or `create`.
        action: &'static str,
        /// Which one.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// FMI 2.0 has no name for binaries of this platform.
    #[error("FMI 2.0 names no folder for binaries of {os} on {arch}")]
    Platform {
        /// Operating system.
        os: &'static str,
        /// Processor architecture.
        arch: &'static str,
    },
}

impl PackageError {
    fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { action, path, source }
    }
}

/// The packaging program: parses the command line, does what it says, reports errors. See `--help`.
#[must_use]
pub fn main(library: &'static Library, documents: &[Document<'_>]) -> ExitCode {
    match run(library, documents) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if matches!(error, PackageError::Usage(_)) { 2 } else { 1 })
        }
    }
}

fn run(library: &'static Library, documents: &[Document<'_>]) -> Result<(), PackageError> {
    let command = parse()?;
    if matches!(command, Command::Help) {
        print!("{HELP}");
        return Ok(());
    }
    let models = library.models();
    let descriptions: Vec<Description> = models.iter().map(|model| model.description()).collect::<Result<_, _>>()?;
    check_names(documents, &descriptions)?;
    match command {
        Command::Help => {}
        Command::Describe { out } => {
            create(&out)?;
            for description in &descriptions {
                let path = out.join(format!("{}.xml", description.name));
                std::fs::write(&path, &description.xml).map_err(PackageError::file("write", &path))?;
                println!("{}", path.display());
            }
        }
        Command::Package { out, library } => {
            // First what can be wrong with the documents: building takes longer.
            let none = Document::new();
            let document = |name| documents.iter().find(|document| document.model == name).unwrap_or(&none);
            let extras = models
                .iter()
                .zip(&descriptions)
                .map(|(model, description)| document::files(*model, description, document(description.name)));
            let extras = extras.collect::<Result<Vec<_>, _>>()?;
            let library = match library {
                Some(path) => path,
                None => build::library()?,
            };
            let binary = std::fs::read(&library).map_err(PackageError::file("read", &library))?;
            create(&out)?;
            for (description, files) in descriptions.iter().zip(&extras) {
                println!("{}", assemble(description, &binary, files, &out)?.display());
            }
        }
    }
    Ok(())
}

fn check_names(documents: &[Document<'_>], descriptions: &[Description]) -> Result<(), PackageError> {
    let known: Vec<&'static str> = descriptions.iter().map(|description| description.name).collect();
    match documents.iter().find(|document| !known.contains(&document.model)) {
        Some(stray) => Err(PackageError::NoSuchModel { model: stray.model.to_owned(), known }),
        None => Ok(()),
    }
}

fn create(folder: &Path) -> Result<(), PackageError> {
    std::fs::create_dir_all(folder).map_err(PackageError::file("create", folder))
}

/// Writes `NAME.fmu` into a folder. The file appears under its name only when it is complete. The same library, model and
/// document give the same bytes.
///
/// # Errors
/// If it cannot be written, if the document is at odds with the model, or if FMI 2.0 does not know the platform.
pub fn write(
    model: &'static dyn ExportedModel,
    description: &Description,
    binary: &[u8],
    document: &Document<'_>,
    folder: &Path,
) -> Result<PathBuf, PackageError> {
    assemble(description, binary, &document::files(model, description, document)?, folder)
}

fn assemble(
    description: &Description,
    binary: &[u8],
    files: &[(String, Vec<u8>)],
    folder: &Path,
) -> Result<PathBuf, PackageError> {
    let path = folder.join(format!("{}.fmu", description.name));
    let extension = std::env::consts::DLL_EXTENSION;

    let mut archive = Archive::new();
    archive.add("modelDescription.xml", description.xml.as_bytes());
    archive.add(format!("binaries/{}/{}.{extension}", platform_folder()?, description.name), binary);
    for (path, content) in files {
        archive.add(path, content);
    }
    archive.write(&path)?;
    Ok(path)
}
