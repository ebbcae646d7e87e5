//! Errors of an FMU, with messages that say what to do.

use std::io;
use std::path::PathBuf;

use super::archive::ArchiveError;
use super::description::DescriptionError;
use super::library::{LibraryError, Status};
use super::value::Mismatch;

/// Why an FMU cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FmuError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Not a zip archive, so not an FMU.
    #[error("{} is not an FMU: not a readable zip archive ({reason})", path.display())]
    NotAZip {
        /// The file.
        path: PathBuf,
        /// What the zip reader says.
        reason: String,
    },
    /// It unpacks to more than any model needs.
    #[error("{}: {source}", path.display())]
    Limit {
        /// The file.
        path: PathBuf,
        /// What there is too much of.
        source: ArchiveError,
    },
    /// A zip archive, but not an FMU.
    #[error("{} is not an FMU: no modelDescription.xml at the root of the archive", path.display())]
    NoDescription {
        /// The file.
        path: PathBuf,
    },
    /// The description cannot be used.
    #[error("{}: cannot use its modelDescription.xml: {source}", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: DescriptionError,
    },
    /// Model exchange only.
    #[error(
        "{} has no co-simulation interface, only model exchange; export the model again as FMI 2.0 co-simulation",
        path.display()
    )]
    NotCoSimulation {
        /// The file.
        path: PathBuf,
    },
    /// The archive has no library for this machine.
    #[error(
        "{} has no library {wanted} for this platform (it has: {available}); export it for this platform",
        path.display()
    )]
    NoBinary {
        /// The file.
        path: PathBuf,
        /// The library that was looked for.
        wanted: String,
        /// The libraries found instead.
        available: String,
    },
    /// An entry would land outside the folder the archive is unpacked to.
    #[error("{} contains the entry \"{entry}\", which points outside the archive; not unpacked", path.display())]
    UnsafeEntry {
        /// The file.
        path: PathBuf,
        /// The entry's name.
        entry: String,
    },
    /// The archive cannot be unpacked.
    #[error("cannot unpack {} to a temporary folder: {source}", path.display())]
    Unpack {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The library cannot be used.
    #[error("{}: cannot use its library {library}: {source}", path.display())]
    Library {
        /// The file.
        path: PathBuf,
        /// The library's name in the archive.
        library: String,
        /// What is wrong.
        source: LibraryError,
    },
}

/// A call of an instance that did not succeed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CallError {
    /// The library, which the first instance loads, cannot be used.
    #[error(transparent)]
    Load(Box<FmuError>),
    /// `fmi2Instantiate` returned no instance.
    #[error("{instance}: the FMU refuses to be instantiated{messages}")]
    Instantiate {
        /// Name of the instance.
        instance: String,
        /// What the FMU logged meanwhile, ready to be appended.
        messages: String,
    },
    /// A function returned a status other than `fmi2OK` or `fmi2Warning`.
    #[error("{instance}: {function} returned {status}{messages}")]
    Status {
        /// Name of the instance.
        instance: String,
        /// The C function.
        function: &'static str,
        /// What it returned.
        status: Status,
        /// What the FMU logged meanwhile, ready to be appended.
        messages: String,
    },
    /// The FMU lacks an optional function.
    #[error("{instance}: the FMU does not offer {function}")]
    Unsupported {
        /// Name of the instance.
        instance: String,
        /// The C function.
        function: &'static str,
    },
    /// A text with a zero byte inside.
    #[error("{instance}: {text:?} has a zero byte inside, which C strings cannot have")]
    ZeroByte {
        /// Name of the instance.
        instance: String,
        /// The text.
        text: String,
    },
    /// A value that does not fit the variable's type.
    #[error("{instance}: {variable} needs {}, not \"{}\"", .source.expected, .source.value)]
    Value {
        /// Name of the instance.
        instance: String,
        /// The variable.
        variable: String,
        /// What was given and what is needed.
        source: Box<Mismatch>,
    },
    /// A saved state of another instance.
    #[error("{instance}: this saved state belongs to another instance")]
    ForeignState {
        /// Name of the instance.
        instance: String,
    },
}

impl CallError {
    /// The status the FMU returned, if it returned one.
    #[must_use]
    pub fn status(&self) -> Option<Status> {
        match self {
            Self::Status { status, .. } => Some(*status),
            _ => None,
        }
    }
}
