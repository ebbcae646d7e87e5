//! Faults of a description.

use crate::document::XmlError;
use crate::xml::Fault;

/// Why a `modelDescription.xml` cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// Not UTF-8, which FMI 2.0 prescribes.
    #[error("it is not UTF-8 text, which FMI 2.0 prescribes")]
    Encoding,
    /// Not well-formed XML, or more of it than any description needs.
    #[error(transparent)]
    Xml(#[from] XmlError),
    /// Some other XML document.
    #[error("its root element is <{0}>, not <fmiModelDescription>")]
    Root(String),
    /// Another version of the standard.
    #[error("it is written for FMI {0}; this tool imports FMI 2.0 (export the model again as FMI 2.0 co-simulation)")]
    Version(String),
    /// An attribute or child is absent, or an attribute's value makes no sense.
    #[error(transparent)]
    Content(#[from] Fault),
    /// A variable has no base type.
    #[error("line {line}: variable \"{name}\" has no type (Real, Integer, Boolean, String or Enumeration)")]
    NoType {
        /// The variable.
        name: String,
        /// Line in the file.
        line: u32,
    },
    /// Two definitions of one name that differ.
    #[error("{what} \"{name}\" is defined in two ways")]
    Contradiction {
        /// What is defined.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// Two variables of one name.
    #[error("two variables are called \"{0}\"")]
    Duplicate(String),
}
