//! The control laws, one module each.

pub mod nabfc;
pub mod pd;
pub mod pds;
