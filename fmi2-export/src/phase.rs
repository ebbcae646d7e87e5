//! The calling sequence: which function is allowed when (FMI 2.0.4, section 4.2.4).

use serde::{Deserialize, Serialize};

use crate::layout::settable;

/// State of an instance in the standard's state machine. `stepInProgress` and `stepCanceled` do not occur, because
/// `fmi2DoStep` always finishes before it returns; `fatal` does not, because a failed instance never harms another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Phase {
    Instantiated,
    Initialization,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
}

/// A group of C functions with the same row in the standard's table. Those not here are allowed in every phase
/// (`fmi2Reset`, `fmi2FreeInstance`, `fmi2SetDebugLogging`, saved states) or in none (`fmi2CancelStep`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    /// `fmi2GetReal` and its kin, `fmi2GetDirectionalDerivative`.
    Get,
    /// `fmi2SetReal` and its kin, `fmi2SetRealInputDerivatives`.
    Set,
    GetOutputDerivatives,
    DoStep,
    /// `fmi2GetStatus` and its kin.
    GetStatus,
}

impl Phase {
    /// The standard's table.
    pub fn allows(self, call: Call) -> bool {
        use Phase::{Error, Initialization, Instantiated, StepComplete, StepFailed, Terminated};
        match call {
            Call::SetupExperiment | Call::EnterInitializationMode => self == Instantiated,
            Call::ExitInitializationMode => self == Initialization,
            Call::Terminate => matches!(self, StepComplete | StepFailed),
            Call::Get => matches!(self, Initialization | StepComplete | StepFailed | Terminated | Error),
            Call::Set => matches!(self, Instantiated | Initialization | StepComplete),
            Call::GetOutputDerivatives => matches!(self, StepComplete | StepFailed | Terminated | Error),
            Call::DoStep => self == StepComplete,
            Call::GetStatus => matches!(self, StepComplete | StepFailed | Terminated),
        }
    }

    /// The bit of [`settable`] that a variable needs to be set in this phase.
    pub fn settable_bit(self) -> u8 {
        match self {
            Self::Instantiated => settable::INSTANTIATED,
            Self::Initialization => settable::INITIALIZATION,
            Self::StepComplete => settable::STEPPING,
            Self::StepFailed | Self::Terminated | Self::Error => 0,
        }
    }

    /// What the phase is called in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "in initialization mode",
            Self::StepComplete => "while stepping",
            Self::StepFailed => "after a discarded step",
            Self::Terminated => "after termination",
            Self::Error => "after an error",
        }
    }
}
