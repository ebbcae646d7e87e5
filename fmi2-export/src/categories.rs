//! What messages to the host are about.

use crate::status::Status;

/// Log categories, as `<LogCategories>` lists them; the names are those the standard proposes.
pub(crate) const CATEGORIES: [(&str, &str); 4] = [
    ("logStatusWarning", "Something is not quite right, but the computation continues"),
    ("logStatusDiscard", "A step was not done; it can be retried with another size"),
    ("logStatusError", "A call was refused, or the model has failed"),
    ("logEvents", "Instantiation, initialization, reset and termination"),
];

/// A log category, by its place in [`CATEGORIES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Category {
    Warning = 0,
    Discard = 1,
    Error = 2,
    Events = 3,
}

impl Category {
    /// That of a message about a call with this status.
    pub fn of(status: Status) -> Self {
        match status {
            Status::Ok | Status::Pending => Self::Events,
            Status::Warning => Self::Warning,
            Status::Discard => Self::Discard,
            Status::Error | Status::Fatal => Self::Error,
        }
    }
}
