//! What the three controllers have in common.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use crate::signals::{Commands, Errors, INPUTS, Inputs, References};
use crate::target::{Arms, Targets};
use thiserror::Error;

/// A sampled-data control law with direct feedthrough from its inputs to its commands.
///
/// The methods that only read take `&mut self` all the same: a law may keep the expensive part of an evaluation for the
/// next call with the same inputs. None but [`initialize`](Self::initialize) and [`step`](Self::step) changes the state.
pub trait Law {
    /// What the law knows about the arms.
    fn arms(&self) -> &Arms;

    /// Puts the law into its initial state, with its filters in equilibrium with `inputs`.
    fn initialize(&mut self, inputs: &Inputs);

    /// The commands for these inputs in the present state.
    fn commands(&mut self, inputs: &Inputs) -> Commands;

    /// Advances the state by `h` \[s\] with inputs that start at `inputs` and change at the constant `rates`
    /// ([`Inputs::HELD`]: zero-order hold).
    ///
    /// # Errors
    /// A step size that is not positive and finite, or inputs that are not finite or beyond [`Inputs::LARGEST`]; the
    /// state is then unchanged.
    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError>;

    /// Partial derivatives of the commands with respect to the inputs, rows `tau1_cmd`, `tau2_cmd`, `u_cmd`, columns
    /// as in [`INPUT_NAMES`](crate::signals::INPUT_NAMES).
    ///
    /// At the kinks of `sat` it is the derivative of the inner branch.
    fn jacobian(&mut self, inputs: &Inputs) -> CommandJacobian;

    /// Time derivative of the commands, for inputs that change at `rates`: chain rule through the inputs plus the
    /// motion of the law's own state.
    fn command_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Commands;

    /// The static target (16) of these references.
    fn targets(&self, reference: &References) -> Targets {
        self.arms().targets(reference)
    }

    /// Distances from the static target.
    fn errors(&self, inputs: &Inputs) -> Errors {
        self.arms().errors(inputs)
    }
}

/// Partial derivatives of the commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandJacobian {
    /// ∂τ̄ᵢ.
    pub tau: [[f64; INPUTS]; 2],
    /// ∂v.
    pub u: [f64; INPUTS],
}

impl CommandJacobian {
    /// The commands' change for a change of the inputs.
    #[must_use]
    pub fn apply(&self, change: &Inputs) -> Commands {
        let change = change.to_array();
        Commands { tau: [inner(&self.tau[0], &change), inner(&self.tau[1], &change)], u: inner(&self.u, &change) }
    }
}

/// A Jacobian row times a change of the inputs.
#[must_use]
pub fn inner(row: &[f64; INPUTS], change: &[f64; INPUTS]) -> f64 {
    row.iter().zip(change).map(|(a, b)| a * b).sum()
}

/// Why a step was refused.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StepError {
    /// The step size is not positive and finite.
    #[error("step size {0} s is not positive and finite")]
    StepSize(f64),
    /// An input, or its change over the step, is not finite or larger than [`Inputs::LARGEST`].
    #[error("input {name} reaches {value:e} in this step, which is not a usable value")]
    Input {
        /// Name of the input.
        name: &'static str,
        /// Its value at the start or at the end of the step.
        value: f64,
    },
}

impl StepError {
    /// Checks what a step was asked to do.
    pub(crate) fn check(h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), Self> {
        Self::check_size(h)?;
        let (values, changes) = (inputs.to_array(), rates.to_array());
        let mut all_usable = true;
        // Without a branch per input, so that several are compared at once.
        for (value, rate) in values.iter().zip(changes) {
            all_usable &= value.abs() <= Inputs::LARGEST;
            all_usable &= (value + rate * h).abs() <= Inputs::LARGEST;
        }
        if all_usable { Ok(()) } else { Err(Self::unusable(inputs, rates, h)) }
    }

    /// [`check`](Self::check) of inputs that are held.
    #[inline(always)]
    pub(crate) fn check_held(h: f64, inputs: &Inputs) -> Result<(), Self> {
        Self::check_size(h)?;
        let mut all_usable = true;
        for value in inputs.to_array() {
            all_usable &= value.abs() <= Inputs::LARGEST;
        }
        if all_usable { Ok(()) } else { Err(Self::unusable(inputs, &Inputs::HELD, h)) }
    }

    #[inline(always)]
    pub(crate) fn check_size(h: f64) -> Result<(), Self> {
        if h > 0.0 && h <= f64::MAX { Ok(()) } else { Err(Self::StepSize(h)) }
    }

    /// The first input that [`check`](Self::check) does not like.
    #[cold]
    fn unusable(inputs: &Inputs, rates: &Inputs, h: f64) -> Self {
        let (values, ends) = (inputs.to_array(), inputs.after(h, rates).to_array());
        let named =
            [&values, &ends].into_iter().flat_map(|values| crate::signals::INPUT_NAMES.into_iter().zip(*values));
        let (name, value) = named
            .into_iter()
            .find(|(_, value)| value.is_nan() || value.abs() > Inputs::LARGEST)
            .unwrap_or(("", f64::NAN));
        Self::Input { name, value }
    }
}
