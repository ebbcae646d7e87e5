//! How good a run of the grasp was, from its rows: [`metrics`] of the paper's forces and efforts, [`merit`] of all that
//! (17) wants, beside the [shortest possible time](limit); [spans] of quiet and of pulling; a [`tally`] of any one signal.
//!
//! It is a crate of its own because it looks at every step of a run: the tool around it, which does so little that it is
//! compiled without optimisation, would take seconds longer for a matrix of controllers and cases.

#![forbid(unsafe_code)]

pub mod limit;
pub mod merit;
pub mod metrics;
pub mod running;
pub mod spans;
pub mod tally;
