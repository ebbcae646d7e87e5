//! Why a co-simulation stopped.

use std::io;

use crate::names::number;
use crate::wiring::WiringError;
use fmi2_import::CallError;

/// Why a co-simulation stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MasterError {
    /// Equal names do not determine the connections.
    #[error(transparent)]
    Wiring(#[from] WiringError),
    /// A call before the first step failed.
    #[error("{0}")]
    Setup(#[from] CallError),
    /// A call at a communication point failed.
    #[error("at t = {} s: {source}", seconds(*.time))]
    Step {
        /// The communication point in s.
        time: f64,
        /// The error of the FMU.
        source: CallError,
    },
    /// A component requests the end of the simulation.
    #[error("at t = {} s: {component} asks to end the simulation: {source}", seconds(*.time))]
    Ended {
        /// How far it got, in s.
        time: f64,
        /// The component.
        component: String,
        /// The status of the FMU.
        source: CallError,
    },
    /// An FMU that one process can have only one instance of is there more than once.
    #[error(
        "{first} and {second} are the same FMU, which says that one process can have only one instance of it \
         (canBeInstantiatedOnlyOncePerProcess); run them in processes of their own"
    )]
    OnlyOnce {
        /// One component.
        first: String,
        /// Another one.
        second: String,
    },
    /// The signals at the start do not settle.
    #[error(
        "the initial values do not settle after {sweeps} exchanges: the components form an algebraic loop that plain \
         iteration does not solve"
    )]
    AlgebraicLoop {
        /// How many exchanges were tried.
        sweeps: usize,
    },
    /// A component cannot do a last step of another size.
    #[error(
        "{component} can only do steps of equal size, but {} s is no multiple of the step size {} s; \
         choose a stop time that is", number(*duration), number(*step)
    )]
    UnequalSteps {
        /// The component.
        component: String,
        /// Duration of the run in s.
        duration: f64,
        /// Step size in s.
        step: f64,
    },
    /// A recorded value cannot be kept.
    #[error(transparent)]
    Record(io::Error),
}

/// A time without the digits that only rounding puts there.
fn seconds(time: f64) -> String {
    if time != 0.0 && !(1e-6..1e15).contains(&time.abs()) {
        return number(time);
    }
    let digits = format!("{time:.9}");
    digits.trim_end_matches('0').trim_end_matches('.').to_owned()
}
