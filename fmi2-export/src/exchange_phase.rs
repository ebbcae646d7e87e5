//! The calling sequence of model exchange: which of its own functions is allowed when (FMI 2.0.4, section 3.2.3).

use crate::phase::Phase;

/// A C function that only model exchange has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExchangeCall {
    EnterEventMode,
    NewDiscreteStates,
    EnterContinuousTimeMode,
    CompletedIntegratorStep,
    SetTime,
    SetContinuousStates,
    GetDerivatives,
    GetEventIndicators,
    GetContinuousStates,
    GetNominals,
}

impl ExchangeCall {
    /// The function's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::EnterEventMode => "fmi2EnterEventMode",
            Self::NewDiscreteStates => "fmi2NewDiscreteStates",
            Self::EnterContinuousTimeMode => "fmi2EnterContinuousTimeMode",
            Self::CompletedIntegratorStep => "fmi2CompletedIntegratorStep",
            Self::SetTime => "fmi2SetTime",
            Self::SetContinuousStates => "fmi2SetContinuousStates",
            Self::GetDerivatives => "fmi2GetDerivatives",
            Self::GetEventIndicators => "fmi2GetEventIndicators",
            Self::GetContinuousStates => "fmi2GetContinuousStates",
            Self::GetNominals => "fmi2GetNominalsOfContinuousStates",
        }
    }

    /// The standard's table. More generous than it: the nominal values never change, so they are told in initialization
    /// mode, too.
    pub fn allowed_in(self, phase: Phase) -> bool {
        use Phase::{ContinuousTimeMode, Error, EventMode, Initialization, Instantiated, Terminated};
        let is_running = matches!(phase, EventMode | ContinuousTimeMode);
        // "Retrieved values are usable for debugging only."
        let for_debugging = matches!(phase, Terminated | Error);
        match self {
            Self::EnterEventMode | Self::SetTime => is_running,
            Self::NewDiscreteStates | Self::EnterContinuousTimeMode => phase == EventMode,
            Self::CompletedIntegratorStep | Self::SetContinuousStates => phase == ContinuousTimeMode,
            Self::GetDerivatives => is_running || for_debugging,
            Self::GetEventIndicators | Self::GetContinuousStates => {
                is_running || for_debugging || phase == Initialization
            }
            Self::GetNominals => is_running || for_debugging || matches!(phase, Instantiated | Initialization),
        }
    }
}
