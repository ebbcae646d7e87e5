//! Proofs about the grasp's control laws. Derivations: `docs/certificates.md`; equation numbers are the paper's.
//!
//! * [`printed`]: whether constants exist that satisfy (71), (82)–(88) for given gains, by exact elimination.
//! * [`corrected`]: why no gains satisfy the conditions with corrected signs, and the undamped motion that refutes Theorem
//!   3 for Δ = 0.
//! * [`root_strain`]: a decay rate and ultimate bounds for the law with root strain in the posture surface, checked in
//!   [interval arithmetic](interval).
//! * [`spectrum`]: the exact eigenvalues of linear loops, counted so that none is missed.
//! * [`law`] and [`controllers`]: any of the project's laws as a sampled linear system.
//! * [`sampled`]: spectral radii of loops whose commands are held over a step.
//! * [`realisation`]: eigenvalues of any stepped linear system from its pulse responses.
//!
//! Everything except [`sampled`] is in continuous time and about the undiscretised beams.
#![forbid(unsafe_code)]
// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]

pub mod controllers;
pub mod corrected;
pub mod decay;
mod grasp;
pub mod interval;
pub mod law;
mod loops;
pub mod monitor;
pub mod printed;
pub mod realisation;
pub mod root_strain;
pub mod sampled;
mod search;
pub mod settings;
pub mod spectrum;

pub use grasp::{Arm, Grasp};
pub use loops::{HubFeedback, LinearLoop, ObjectFeedback};
