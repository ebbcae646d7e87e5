#![doc = include_str!("../README.md")]

mod archive;
mod arguments;
mod build;
mod document;
mod licenses;
pub mod platform;
mod program;
pub mod requirements;
mod response;
pub mod toolchain;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use fmi2_export::{DeclarationError, Description};
use fmi2_export::{ExportedModel, Library};

pub use archive::Archive;
pub use build::BuildError;
pub use response::{Beside, OfTime, Panel, Response, ResponseError};

use document::Origin;
use platform::Platform;

/// The author's part of a model's documentation, beside its declarations. Every field is optional.
#[derive(Clone, Copy, Debug)]
pub struct Document<'a> {
    /// Name of the model.
    pub model: &'a str,
    /// The description of the model in Markdown, with formulas in LaTeX between `$`, or `$$` on separate lines. Headings
    /// start at the second level (`##`). Images are [`files`](Self::files) below `documentation/`.
    pub text: &'a str,
    /// The icon that tools show, as PNG: becomes `model.png`. It needs its own background: pages and tools may be dark.
    pub icon: &'a [u8],
    /// The licence's text: becomes `documentation/licenses/license.txt`.
    pub license: &'a str,
    /// A run whose results the page shows.
    pub response: Option<Response<'a>>,
    /// The command that made the archive; `cargo fmi2 package` if empty.
    pub command: &'a str,
    /// Further files.
    pub files: &'a [File<'a>],
    /// Further pages, to which the text can link.
    pub articles: &'a [Article<'a>],
    /// Targets of the text's links and images as they are beside its own file, and what they become on the page, so that the text can
    /// be read in the repository as well: `("../../docs/errata.md", "errata.html")`.
    pub links: &'a [(&'a str, &'a str)],
}

impl Document<'_> {
    /// An empty document, for the remaining fields of a definition:
    /// `Document { model: "Lag", text: "…", ..Document::new() }`.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            model: "",
            text: "",
            icon: &[],
            license: "",
            response: None,
            command: "",
            files: &[],
            articles: &[],
            links: &[],
        }
    }
}

impl Default for Document<'_> {
    fn default() -> Self {
        Self::new()
    }
}

/// A file to put into a model's archive beside the generated files.
#[derive(Clone, Copy, Debug)]
pub struct File<'a> {
    /// Path in the archive, e.g. `documentation/figure.svg`.
    pub path: &'a str,
    /// Its content.
    pub content: &'a [u8],
}

/// A page besides `documentation/index.html`.
#[derive(Clone, Copy, Debug)]
pub struct Article<'a> {
    /// Path in the archive, e.g. `documentation/history.html`.
    pub path: &'a str,
    /// Its title.
    pub title: &'a str,
    /// Its origin, in a sentence below the title.
    pub about: &'a str,
    /// Markdown with LaTeX formulas, with a heading of the first level. The text may come from another place: links to
    /// files that the archive does not have become plain text.
    pub text: &'a str,
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
        /// The existing models.
        known: Vec<&'static str>,
    },
    /// A part of a document that an FMU cannot contain.
    #[error("document of {model}: {problem}")]
    Document {
        /// The model.
        model: &'static str,
        /// The fault, and what to do.
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
    /// The program could not write to standard output.
    #[error("cannot write to standard output: {0}")]
    StandardOutput(std::io::Error),
    /// A platform has no name in FMI 2.0, or cannot be built for here.
    #[error("{0}")]
    Platform(String),
    /// A file is not a library for these models.
    #[error("{}: {problem}", path.display())]
    Library {
        /// Which one.
        path: PathBuf,
        /// The fault, and what to do.
        problem: String,
    },
    /// An archive cannot be merged.
    #[error("cannot merge {}: {problem}", path.display())]
    Merge {
        /// Which one.
        path: PathBuf,
        /// Why not.
        problem: String,
    },
    /// Two models would have the same file.
    #[error("two models are called {one} and {other}, so that one's archive would replace the other's: rename one")]
    SameName {
        /// One model.
        one: &'static str,
        /// The other one.
        other: &'static str,
    },
    /// An archive of that name exists already and belongs to another model.
    #[error("{} is {whose}: choose another folder (--out), or remove it", path.display())]
    Taken {
        /// Its path.
        path: PathBuf,
        /// Its owner.
        whose: String,
    },
}

impl PackageError {
    fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { action, path, source }
    }
}

/// The packaging program: parses the command line, executes it, reports errors. See `--help`.
#[must_use]
pub fn main(library: &'static Library, documents: &[Document<'_>]) -> ExitCode {
    match program::run(library, documents) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if matches!(error, PackageError::Usage(_)) { 2 } else { 1 })
        }
    }
}

/// Writes `NAME.fmu` into a folder. The file appears under its name only when it is complete. The same library, model and
/// document give the same bytes.
///
/// # Errors
/// If it cannot be written, if the document contradicts the model, or if FMI 2.0 does not know the platform.
pub fn write(
    model: &'static dyn ExportedModel,
    description: &Description,
    binary: &[u8],
    document: &Document<'_>,
    folder: &Path,
) -> Result<PathBuf, PackageError> {
    let here = Platform::here().ok_or_else(|| PackageError::Platform("FMI 2.0 does not name this platform".into()))?;
    let mut archive = Archive::new();
    archive.add("modelDescription.xml", description.xml.as_bytes());
    archive.add(program::library_path(here, description.name), binary);
    archive.add(requirements::PATH, requirements::text(&[(here, binary)]).as_bytes());
    for (path, content) in document::files(model, description, document, &Origin::new("", vec![here]))? {
        archive.add(path, &content);
    }
    let path = folder.join(format!("{}.fmu", description.name));
    archive.write(&path)?;
    Ok(path)
}
