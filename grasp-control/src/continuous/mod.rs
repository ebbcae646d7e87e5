//! The laws as ordinary differential equations, for a solver of one's own: no sampling, no step.
//!
//! Every sampled update of a [`Law`] is the solution of differential equations over a step. [`Continuous`] gives these equations,
//! to which the sampled law tends as its step goes to zero, with what a solver needs beside them: event indicators, and exact
//! products of the Jacobian.
//!
//! **Limits on what is learnt.** A learnt disturbance that has reached its limit, and weights on their ball, stay there as long as
//! they are pushed outwards. Whether they do is a discrete state, [`Regimes`], that belongs to the caller and changes in events
//! only ([`Continuous::decide`]): within a regime everything is smooth, nothing chatters, and rounding cannot leave the limit.
//!
//! **Anti-windup.** An integral that stops where its command is beyond the limit has a rate that jumps there, and the command may
//! be pushed back to the jump from both sides. What the sampled law does then has a limit: the command slides along its limit.
//! In differential equations the rate passes from one value to the other within a [`LAYER`] of the limit, which has the same
//! limit and no chatter.
//!
//! **One vector of states for all that can replace each other.** The places of the states and of the indicators do not depend on a
//! law's parameters, only on the number of the networks' nodes; those that a law does not use are zero and stay so.

// Everything that only a host of model exchange needs, here and in the files `continuous` beside the laws, is marked `inline`: the compiler
// then compiles it in the crate that uses it. In the FMUs' libraries that is `controller-model`, which is compiled for size, as this
// crate is not.

mod places;
mod regimes;
mod table;

pub use places::{NABFC_INDICATORS, PDS_INDICATORS, PDS_STATES, nabfc_states};
pub(crate) use places::{indicator, state};
pub use regimes::{Decision, Regimes};
pub(crate) use regimes::{Limit, slides, slides_change};
pub use table::{nabfc_state_variables, pds_state_variables};

use crate::law::Law;
use crate::signals::{Commands, Inputs};
use thiserror::Error;

/// Relative width on both sides of a limit within which an integral's rate passes to zero.
pub const LAYER: f64 = 1e-5;

/// A direction of states and inputs.
#[derive(Debug, Clone, Copy)]
pub struct Direction<'a> {
    /// Change of the states, in their order.
    pub states: &'a [f64],
    /// Change of the inputs.
    pub inputs: &'a Inputs,
}

/// A law as differential equations with direct feedthrough from its inputs to its commands.
///
/// Slices of states have [`PDS_STATES`] or [`nabfc_states`] entries and slices of indicators [`PDS_INDICATORS`] or
/// [`NABFC_INDICATORS`]; shorter ones are a fault of the caller and panic. States after those of a law are zero.
///
/// The methods that only read take `&mut self` for the reason that [`Law`] gives.
pub trait Continuous: Law {
    /// Writes the continuous states.
    fn continuous_states(&self, out: &mut [f64]);

    /// Puts the law into these states. Those that it does not use are not looked at.
    ///
    /// # Errors
    /// If a state is not finite or larger than [`Inputs::LARGEST`]; the law is then as before.
    #[inline]
    fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), StateError> {
        if let Some(index) = states.iter().position(|state| state.is_nan() || state.abs() > Inputs::LARGEST) {
            return Err(StateError { index, value: states[index] });
        }
        self.take_states(states);
        Ok(())
    }

    /// As [`set_continuous_states`](Self::set_continuous_states), for states that are usable.
    fn take_states(&mut self, states: &[f64]);

    /// The commands for these inputs in the present states. Other than [`Law::commands`], which may hold something from the last
    /// step (networks that are evaluated once per step), they follow states and inputs at once.
    #[inline]
    fn present_commands(&mut self, inputs: &Inputs) -> Commands {
        self.commands(inputs)
    }

    /// Exact change of [`present_commands`](Self::present_commands). At a kink it is that of one of its sides.
    fn command_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Commands;

    /// Time derivatives of the states.
    fn derivatives(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]);

    /// Exact product of the Jacobian of [`derivatives`](Self::derivatives) with a direction.
    fn derivative_change(&mut self, inputs: &Inputs, regimes: &Regimes, along: Direction<'_>, out: &mut [f64]);

    /// Event indicators: positive until something happens. Those of [`Regimes`] tell by reaching zero that
    /// [`decide`](Self::decide) has to be called; the others change their sign at kinks of commands or derivatives.
    fn event_indicators(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]);

    /// Decides anew which limits hold, at the start and in events. A state that is beyond its limit is put back.
    fn decide(&mut self, inputs: &Inputs, regimes: &mut Regimes) -> Decision;
}

/// A state that was refused.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("state {index} is {value:e}, which is not a usable value")]
pub struct StateError {
    /// Its place among the states, from 0.
    pub index: usize,
    /// Its value.
    pub value: f64,
}
