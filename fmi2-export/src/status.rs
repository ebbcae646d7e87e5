//! How a call went (FMI 2.0.4, section 2.1.3).

use crate::model::Failure;

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
    /// What all instances share is beyond repair: only where a model says so ([`Failure::Fatal`]).
    Fatal = 4,
    /// Runs in the background. Never returned here.
    Pending = 5,
}

/// Why a call was not carried out. Unless it says otherwise, the instance is as it was before the call.
///
/// In a box, so that what every call returns is one pointer, which is null if all is well.
#[derive(Debug)]
pub(crate) struct Refusal(Box<(Status, String)>);

impl Refusal {
    #[cold]
    #[inline(never)]
    fn new(status: Status, message: String) -> Self {
        Self(Box::new((status, message)))
    }

    pub fn error(message: impl Into<String>) -> Self {
        Self::new(Status::Error, message.into())
    }

    pub fn fatal(message: impl Into<String>) -> Self {
        Self::new(Status::Fatal, message.into())
    }

    /// Of a model that could not do something that a host cannot retry in another way: only steps and states are discarded.
    pub fn of(failure: &Failure) -> Self {
        let status = if matches!(failure, Failure::Fatal(_)) { Status::Fatal } else { Status::Error };
        Self::new(status, failure.to_string())
    }

    pub fn discard(message: impl Into<String>) -> Self {
        Self::new(Status::Discard, message.into())
    }

    pub fn status(&self) -> Status {
        self.0.0
    }

    pub fn message(&self) -> &str {
        &self.0.1
    }

    pub fn into_message(self) -> String {
        self.0.1
    }
}

pub(crate) type Outcome = Result<(), Refusal>;
