//! Dual-arm grasp plant: two flexible one-link arms squeeze an object between their tips.
//!
//! Each arm is an Euler–Bernoulli beam clamped to a motor hub. The plant is the hybrid PDE–ODE model (2)–(14) of Hejrati,
//! *Neuro-Adaptive Boundary Force Control of Dual One-Link Flexible Arms with Unmodeled Dynamics and Input Constraints*,
//! with its input constraints (18)–(20) and the uncertainties of its Section IV. Equation numbers refer to that paper.
//!
//! # Model
//! With hub angles θ_i, deflections w_i(x, t), object position `y_M` and m = m_1 + m_2 + M:
//!
//! ```text
//! ẅ_i + (EI_i/ρ_i) w_i'''' = x θ̈_i,   w_i(0) = w_i'(0) = w_i''(l) = 0        (8)(9)
//! J_i θ̈_i + EI_i w_i''(0) = τ_i + Δf_i                                        (10)
//! m ÿ_M + Σ EI_i w_i'''(l) = u + ΔF                                           (11)
//! φ_i = l θ_i − w_i(l) − y_M + L/2 = 0                                        (12)
//! λ_i = EI_i w_i'''(l) + m_i ÿ_M                                              (13)(14)
//! ```
//!
//! Δf_i and ΔF are the built-in uncertainties of the parameters `root_uncertainty` and `tip_uncertainty` plus the external
//! disturbances among the [`Inputs`]. With a Kelvin–Voigt coefficient κ, every transmitted moment EI w'' becomes
//! EI (w'' + κ ẇ''): in the beam, on the hub, on the object and in λ_i. The outputs named root moment and tip shear stay
//! the elastic EI w''(0) and EI w'''(l).
//!
//! [`Parameters::contact_model`] can allow the tips to leave the object ([`ContactModel`]). Then (12) holds only while they
//! touch it, the gap between them is an output, and a new contact is an impact.
//!
//! # Discretisation
//! Bending moment and absolute velocity are the two unknown fields of each arm, polynomials of degree k and k−2 over its
//! whole length (k is [`Parameters::order`]). In energy coordinates the free plant is exactly skew-symmetric, so energy is
//! conserved; boundary moments and shears are linear functions of the state; the constraint (12) is an invariant; and
//! convergence in k is spectral.
//!
//! # Time stepping
//! Between communication points the plant is linear and its inputs are known (held, or ramped), so [`Plant::step`] is exact
//! for every step size: accuracy does not depend on it. The step uses modal coordinates and takes time proportional to
//! their number. If contacts open and close, it is exact between the switches, which may be anywhere in a step. Results do
//! not depend on the processor's vector units.
//!
//! # As differential equations
//! [`Plant::derivatives`] and its neighbours define the same plant as an explicit system of ordinary differential equations
//! in minimal coordinates, with event indicators and exact products of its Jacobian, for an external solver.
//!
//! # Modules
//! [`Plant`] is the entry point. It is built on: parameters and their tables, actuators, the beam operators (`beam`), their
//! assembly (`dynamics`), the modal form (`modal`) with the loops of a step, the exponential, the propagator and the kernel
//! for plants without a modal form, and a module for contacts that can open (`contact`).
#![doc = include_str!("../README.md")]
// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]

mod actuator;
mod basis;
mod beam;
mod cache;
mod contact;
mod coordinates;
mod dynamics;
mod exponential;
mod extended;
mod fields;
mod initial;
mod kernel;
mod modal;
mod parameters;
mod plant;
mod propagator;
mod signals;
mod state;
mod state_space;
mod step_sizes;

pub use actuator::Actuator;
pub use beam::DEFLECTION_POINTS;
pub use contact::{Contact, ContactState};
pub use coordinates::Coordinates;
pub use extended::LONGEST_STEP;
pub use fields::{Fields, Node};
/// Re-exported because a [`StateSpace`] holds its matrices.
pub use nalgebra;
pub use parameter_table::{Admissible, InvalidParameter, Parameter, Range, StateVariable};
pub use parameters::{ActuatorModel, Arm, Channel, ContactModel, Face, ORDER_RANGE, Parameters, Start};
pub use plant::Plant;
pub use signals::{Direct, Inputs, Measured, Rates, Uncertainty};
pub use state::{Basis, State, StateError, StepError};
pub use state_space::{StateSpace, held_step};
pub use step_sizes::StepSizes;
