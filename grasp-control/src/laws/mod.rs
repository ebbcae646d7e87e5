//! The control laws, one module each.

pub mod encoders;
mod gain_set;
pub mod nabfc;
pub mod pd;
pub mod pds;
pub mod root_strain;

pub use gain_set::{Changes, GainSet, Tables};

use parameter_table::Range;

/// A gain: zero or positive.
pub(crate) const GAIN: Range = Range::new(0.0, 1e6);
/// Something that divides: positive.
pub(crate) const DIVISOR: Range = Range::new(1e-9, 1e9);
