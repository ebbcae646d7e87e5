//! Errors of an SSP, with messages that name the file, the line and the element.

use std::io;
use std::path::PathBuf;

use fmi2_import::FmuError;
use fmi2_import::archive::ArchiveError;
use fmi2_import::document::XmlError;
use fmi2_import::xml::Fault;

/// Why an SSP cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SspError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Not a zip archive, so not an SSP.
    #[error("{} is not an SSP: not a readable zip archive ({reason})", path.display())]
    NotAZip {
        /// The file.
        path: PathBuf,
        /// The message of the zip reader.
        reason: String,
    },
    /// The archive has no such system structure.
    #[error(
        "{} has no {wanted} at its root (it has: {}); name a variant as FILE.ssp#VARIANT.ssd",
        path.display(),
        if available.is_empty() { "no .ssd file" } else { available }
    )]
    NoStructure {
        /// The file.
        path: PathBuf,
        /// The `.ssd` file that was looked for.
        wanted: String,
        /// The `.ssd` files found instead.
        available: String,
    },
    /// An entry would land outside the folder an archive is unpacked to.
    #[error("{} contains the entry \"{entry}\", which points outside the archive; not unpacked", path.display())]
    UnsafeEntry {
        /// The file.
        path: PathBuf,
        /// The entry's name.
        entry: String,
    },
    /// A file in the archive cannot be read.
    #[error("{}, {entry}: {source}", path.display())]
    Entry {
        /// The file.
        path: PathBuf,
        /// Its path in the archive.
        entry: String,
        /// The fault.
        source: ArchiveError,
    },
    /// A document in the archive cannot be used.
    #[error("{}, {document}: {source}", path.display())]
    Document {
        /// The file.
        path: PathBuf,
        /// The document's path in the archive.
        document: String,
        /// The fault.
        source: Box<DocumentError>,
    },
    /// An FMU in the archive cannot be unpacked.
    #[error("cannot unpack {entry} of {} to a temporary folder: {source}", path.display())]
    Unpack {
        /// The file.
        path: PathBuf,
        /// The FMU's path in the archive.
        entry: String,
        /// Why.
        source: io::Error,
    },
    /// An FMU in the archive cannot be used.
    #[error("{}, {entry}: {source}", path.display())]
    Fmu {
        /// The file.
        path: PathBuf,
        /// The FMU's path in the archive.
        entry: String,
        /// The fault.
        source: Box<FmuError>,
    },
}

/// A fault of an `.ssd`, `.ssv` or `.ssm` document.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DocumentError {
    /// Not UTF-8.
    #[error("it is not UTF-8 text")]
    Encoding,
    /// Not well-formed XML, or more of it than any document needs.
    #[error(transparent)]
    Xml(#[from] XmlError),
    /// Some other XML document.
    #[error("its root element is <{found}>, not <{expected}> of SSP 1.0")]
    Root {
        /// The root element.
        found: String,
        /// The expected root element.
        expected: &'static str,
    },
    /// Another version of the standard.
    #[error("it is written for SSP {0}; this tool reads SSP 1.0")]
    Version(String),
    /// An attribute or child is absent, or an attribute's value makes no sense.
    #[error(transparent)]
    Content(#[from] Fault),
    /// The standard allows it, but this tool does not support it.
    #[error("line {line}: {what}: this tool does not support that; {instead}")]
    Unsupported {
        /// The element.
        what: String,
        /// A way to avoid it.
        instead: &'static str,
        /// Line in the file.
        line: u32,
    },
    /// More parameters than any real system has.
    #[error("line {line}: the bindings apply more than {most} parameters; this tool does not read such documents")]
    TooMany {
        /// The largest allowed number.
        most: usize,
        /// Line in the file.
        line: u32,
    },
    /// An unknown name.
    #[error("line {line}: there is no {what}{}", suggestion(.similar.as_deref()))]
    Unknown {
        /// The name, and what it should name.
        what: String,
        /// The closest existing name.
        similar: Option<String>,
        /// Line in the file.
        line: u32,
    },
    /// Two things that must be unique, or that do not fit together.
    #[error("line {line}: {problem}")]
    Conflict {
        /// The conflict, in words.
        problem: String,
        /// Line in the file.
        line: u32,
    },
}

fn suggestion(similar: Option<&str>) -> String {
    similar.map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_default()
}
