//! System Structure and Parameterization (SSP) 1.0.1: FMUs, their connections and their parameters in one `.ssp` file.
//!
//! * [`structure`] and [`parameters`] are the two documents, as values; [`write`](mod@write) and [`read`] convert them to
//!   XML and back.
//! * [`package`] is the archive that holds them and the FMUs; [`Package::system`] makes the system that the master runs.

mod error;
pub mod package;
pub mod parameters;
pub mod read;
mod resolve;
pub mod structure;
pub mod write;
mod xml;

pub use error::{DocumentError, SspError};
pub use package::Package;
pub use structure::SystemStructure;

/// XML namespaces of the standard and of the annotations that tools read their step size from.
pub(crate) mod namespace {
    pub const SSC: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
    pub const SSD: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";
    pub const SSV: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
    pub const SSM: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping";
    pub const OMS: &str = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
    pub const OSP: &str = "http://opensimulationplatform.com/SSP/OSPAnnotations";
}
