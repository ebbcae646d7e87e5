//! Packaging: from a built library to `.fmu` files, and the command line program that does it.
//!
//! A model crate is a library (`crate-type = ["cdylib", "rlib"]`) with a program beside it:
//!
//! ```ignore
//! // src/main.rs
//! fn main() -> std::process::ExitCode {
//!     fmi2_export::package::main(&my_model::FMUS, &[])
//! }
//! ```
//!
//! `cargo run` then builds the library in release mode and writes `NAME.fmu`.

mod archive;
mod arguments;
mod build;
mod document;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

pub use archive::{Archive, platform_folder};
pub use build::BuildError;

use crate::ffi::Library;
use crate::{DeclarationError, Description};
use arguments::{Command, HELP, parse};

/// A file to put into a model's archive besides what is generated.
#[derive(Clone, Copy, Debug)]
pub struct File {
    /// Name of the model; empty for all models of the library.
    pub model: &'static str,
    /// Path in the archive, e.g. `documentation/figure.svg`. `documentation/content.html` is special: it becomes the
    /// body of the generated `documentation/index.html`, above the table of variables.
    pub path: &'static str,
    /// Its content.
    pub content: &'static [u8],
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
pub fn main(library: &'static Library, files: &[File]) -> ExitCode {
    match run(library, files) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if matches!(error, PackageError::Usage(_)) { 2 } else { 1 })
        }
    }
}

fn run(library: &'static Library, files: &[File]) -> Result<(), PackageError> {
    let descriptions: Vec<Description> =
        library.models().iter().map(|model| model.description()).collect::<Result<_, _>>()?;
    match parse()? {
        Command::Help => print!("{HELP}"),
        Command::Describe { out } => {
            create(&out)?;
            for description in &descriptions {
                let path = out.join(format!("{}.xml", description.name));
                std::fs::write(&path, &description.xml).map_err(PackageError::file("write", &path))?;
                println!("{}", path.display());
            }
        }
        Command::Package { out, library } => {
            let library = match library {
                Some(path) => path,
                None => build::library()?,
            };
            let binary = std::fs::read(&library).map_err(PackageError::file("read", &library))?;
            create(&out)?;
            for description in &descriptions {
                println!("{}", write(description, &binary, files, &out)?.display());
            }
        }
    }
    Ok(())
}

/// Which models' descriptions differ from the files `NAME.xml` in a folder, or have none there. For a test in crates that
/// keep their descriptions under version control, so that a change of the interface shows up in review.
///
/// # Errors
/// If a model's declarations contradict themselves.
pub fn outdated(library: &'static Library, folder: &Path) -> Result<Vec<&'static str>, DeclarationError> {
    let mut names = Vec::new();
    for model in library.models() {
        let description = model.description()?;
        let kept = std::fs::read(folder.join(format!("{}.xml", description.name)));
        if !kept.is_ok_and(|kept| kept == description.xml.as_bytes()) {
            names.push(description.name);
        }
    }
    Ok(names)
}

fn create(folder: &Path) -> Result<(), PackageError> {
    std::fs::create_dir_all(folder).map_err(PackageError::file("create", folder))
}

/// Writes `NAME.fmu` into a folder. The file appears under its name only when it is complete.
///
/// # Errors
/// If it cannot be written, or if FMI 2.0 does not know the platform.
pub fn write(description: &Description, binary: &[u8], files: &[File], folder: &Path) -> Result<PathBuf, PackageError> {
    let path = folder.join(format!("{}.fmu", description.name));
    let ours = || files.iter().filter(|file| file.model.is_empty() || file.model == description.name);
    let content = ours().find(|file| file.path == document::CONTENT).map_or(&b""[..], |file| file.content);
    let extension = std::env::consts::DLL_EXTENSION;

    let mut archive = Archive::new();
    archive.add("modelDescription.xml", description.xml.as_bytes());
    archive.add(format!("binaries/{}/{}.{extension}", platform_folder()?, description.name), binary);
    archive.add("documentation/index.html", document::index(description, &String::from_utf8_lossy(content)).as_bytes());
    for file in ours().filter(|file| file.path != document::CONTENT) {
        archive.add(file.path, file.content);
    }
    archive.write(&path)?;
    Ok(path)
}
