//! What laws are built from.

pub mod adaptation;
pub mod exponential;
pub(crate) mod four;
pub mod lowpass;
pub mod observer;
pub mod rbf;
pub(crate) mod sat;
pub(crate) mod slope;
