//! How a call went (FMI 2.0.4, section 2.1.3).

/// `fmi2Status`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All well.
    Ok = 0,
    /// Things are not quite right, but the computation can continue. The status of messages, never of calls.
    Warning = 1,
    /// Not done; may be retried differently.
    Discard = 2,
    /// Refused or failed.
    Error = 3,
    /// All instances are corrupted. Never returned here.
    Fatal = 4,
    /// Runs in the background. Never returned here.
    Pending = 5,
}

/// Why a call was not carried out. Unless it says otherwise, the instance is as it was before the call.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub status: Status,
    pub message: String,
}

impl Refusal {
    pub fn error(message: impl Into<String>) -> Self {
        Self { status: Status::Error, message: message.into() }
    }

    pub fn discard(message: impl Into<String>) -> Self {
        Self { status: Status::Discard, message: message.into() }
    }
}

pub(crate) type Outcome = Result<(), Refusal>;
