//! The calling sequence: which function is allowed when (FMI 2.0.4, sections 3.2.3 and 4.2.4).
//!
//! The standard has two tables, one for each interface. What both have, and what only co-simulation has, is here; what only
//! model exchange has is in `exchange_phase`.

use serde::{Deserialize, Serialize};

use crate::layout::settable;

/// What an instance was made for: `fmi2Type`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Kind {
    /// The host integrates.
    ModelExchange,
    /// The model makes steps.
    CoSimulation,
}

impl Kind {
    /// What it is called in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::ModelExchange => "model exchange (fmi2ModelExchange)",
            Self::CoSimulation => "co-simulation (fmi2CoSimulation)",
        }
    }

    /// The phase after initialization.
    pub fn initialized(self) -> Phase {
        match self {
            Self::ModelExchange => Phase::EventMode,
            Self::CoSimulation => Phase::StepComplete,
        }
    }
}

/// State of an instance in the standard's state machines. `stepInProgress` and `stepCanceled` do not occur, because
/// `fmi2DoStep` always finishes before it returns; `fatal` is no state of an instance but of the library: see `served`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Phase {
    Instantiated,
    Initialization,
    /// Of co-simulation.
    StepComplete,
    /// Of co-simulation.
    StepFailed,
    Terminated,
    Error,
    /// Of model exchange.
    EventMode,
    /// Of model exchange.
    ContinuousTimeMode,
}

/// A group of C functions with the same row in the standard's tables. Those not here are allowed in every phase
/// (`fmi2Reset`, `fmi2FreeInstance`, `fmi2SetDebugLogging`, saved states) or in none (`fmi2CancelStep`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    /// `fmi2GetReal` and its kin, `fmi2GetDirectionalDerivative`.
    Get,
    /// `fmi2SetReal`; of co-simulation `fmi2SetRealInputDerivatives`.
    Set,
    /// `fmi2SetInteger` and its kin, which jump.
    SetDiscrete,
    /// Of co-simulation.
    GetOutputDerivatives,
    /// Of co-simulation.
    DoStep,
    /// `fmi2GetStatus` and its kin, of co-simulation.
    GetStatus,
}

impl Phase {
    /// The standard's tables; whether a call is of the instance's interface at all is another question.
    pub fn allows(self, call: Call) -> bool {
        use Phase::{
            ContinuousTimeMode, Error, EventMode, Initialization, Instantiated, StepComplete, StepFailed, Terminated,
        };
        match call {
            Call::SetupExperiment | Call::EnterInitializationMode => self == Instantiated,
            Call::ExitInitializationMode => self == Initialization,
            Call::Terminate => matches!(self, StepComplete | StepFailed | EventMode | ContinuousTimeMode),
            Call::Get => self != Instantiated,
            Call::Set => {
                matches!(self, Instantiated | Initialization | StepComplete | EventMode | ContinuousTimeMode)
            }
            Call::SetDiscrete => matches!(self, Instantiated | Initialization | StepComplete | EventMode),
            Call::GetOutputDerivatives => matches!(self, StepComplete | StepFailed | Terminated | Error),
            Call::DoStep => self == StepComplete,
            Call::GetStatus => matches!(self, StepComplete | StepFailed | Terminated),
        }
    }

    /// Whether the instance is past initialization and works: what is set then changes a state that is there.
    pub fn is_running(self) -> bool {
        matches!(self, Self::StepComplete | Self::EventMode | Self::ContinuousTimeMode)
    }

    /// Whether an instance of this kind can be in this phase.
    pub fn is_of(self, kind: Kind) -> bool {
        match self {
            Self::Instantiated | Self::Initialization | Self::Terminated | Self::Error => true,
            Self::StepComplete | Self::StepFailed => kind == Kind::CoSimulation,
            Self::EventMode | Self::ContinuousTimeMode => kind == Kind::ModelExchange,
        }
    }

    /// The bit of [`settable`] that a variable needs to be set in this phase.
    pub fn settable_bit(self) -> u8 {
        match self {
            Self::Instantiated => settable::INSTANTIATED,
            Self::Initialization => settable::INITIALIZATION,
            Self::StepComplete => settable::STEPPING,
            Self::EventMode => settable::EVENT,
            Self::ContinuousTimeMode => settable::CONTINUOUS,
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
            Self::EventMode => "in event mode",
            Self::ContinuousTimeMode => "in continuous-time mode",
        }
    }
}
