//! What a slave logs: the callback that takes it, and its last words as the end of an error message.

use std::collections::VecDeque;
use std::ffi::{c_char, c_int, c_void};
use std::ptr;
use std::sync::{Mutex, PoisonError};

use crate::description::{BaseType, ModelDescription};
use crate::library::{CallbackFunctions, Status, ValueReference, text};

/// One message of a slave.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogMessage {
    /// How serious it is.
    pub status: Status,
    /// The slave's category.
    pub category: String,
    /// The text; value references in it are replaced by names.
    pub text: String,
}

/// Messages of a slave, the newest [`Log::CAPACITY`] of them.
#[derive(Default)]
pub(super) struct Log(Mutex<VecDeque<LogMessage>>);

impl Log {
    const CAPACITY: usize = 64;

    pub(super) fn messages(&self) -> std::sync::MutexGuard<'_, VecDeque<LogMessage>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What a slave gets to log here. The log must stay where it is for as long as the slave lives.
    pub(super) fn callbacks(&self) -> CallbackFunctions {
        CallbackFunctions {
            logger: fmi2_import_logger,
            allocate_memory: fmi2_import_allocate,
            free_memory: fmi2_import_free,
            step_finished: None,
            component_environment: ptr::from_ref(self).cast_mut().cast(),
        }
    }
}

unsafe extern "C" {
    fn fmi2_import_logger(
        environment: *mut c_void,
        instance: *const c_char,
        status: c_int,
        category: *const c_char,
        format: *const c_char,
        ...
    );
    fn fmi2_import_allocate(count: usize, size: usize) -> *mut c_void;
    fn fmi2_import_free(memory: *mut c_void);
}

/// Receives a formatted message from the C half of the logger.
#[unsafe(no_mangle)]
extern "C" fn fmi2_import_log(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the log of a living instance, which hands it to its slave and outlives it.
    let Some(log) = (unsafe { environment.cast::<Log>().as_ref() }) else { return };
    // SAFETY: the C half passes on C strings (or null).
    let (category, text) = unsafe { (text(category), text(message)) };
    let mut messages = log.messages();
    if messages.len() == Log::CAPACITY {
        messages.pop_front();
    }
    messages.push_back(LogMessage { status: Status::from_c(status), category, text });
}

/// The complaints of a slave since the log was last read, as the end of an error message.
pub(super) fn messages_of(log: &Log, description: &ModelDescription) -> String {
    const SHOWN: usize = 5;
    let messages: Vec<_> = log.messages().drain(..).collect();
    let complaints: Vec<_> = messages.iter().filter(|message| message.status > Status::Warning).collect();
    // Some slaves log the reason with status OK.
    let relevant = if complaints.is_empty() { messages.iter().collect() } else { complaints };
    let mut texts: Vec<String> = Vec::new();
    for message in relevant.iter().rev().take(SHOWN).rev() {
        let text = with_names(message.text.trim(), description);
        if !text.is_empty() && !texts.contains(&text) {
            texts.push(text);
        }
    }
    if texts.is_empty() { " (it gives no reason)".into() } else { format!(": {}", texts.join("; ")) }
}

/// Replaces `#r12#` by the name of the real with value reference 12, and `##` by `#` (section 2.1.5 of the standard).
pub(super) fn with_names(message: &str, description: &ModelDescription) -> String {
    let mut result = String::with_capacity(message.len());
    let mut rest = message;
    while let Some(at) = rest.find('#') {
        result.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix('#') {
            result.push('#');
            rest = after;
        } else if let Some((name, after)) = referenced(rest, description) {
            result.push_str(name);
            rest = after;
        } else {
            result.push('#');
        }
    }
    result.push_str(rest);
    result
}

fn referenced<'a, 'b>(text: &'a str, description: &'b ModelDescription) -> Option<(&'b str, &'a str)> {
    let (inside, after) = text.split_once('#')?;
    let base: &[BaseType] = match inside.chars().next()? {
        'r' => &[BaseType::Real],
        'i' => &[BaseType::Integer, BaseType::Enumeration],
        'b' => &[BaseType::Boolean],
        's' => &[BaseType::String],
        _ => return None,
    };
    let reference: ValueReference = inside[1..].parse().ok()?;
    let variable = description
        .variables
        .iter()
        .find(|variable| variable.value_reference == reference && base.contains(&variable.base_type()))?;
    Some((&variable.name, after))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_references_in_messages_become_names() {
        let description = ModelDescription::parse(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><ModelVariables>
            <ScalarVariable name="x" valueReference="3"><Integer/></ScalarVariable>
            <ScalarVariable name="EI1" valueReference="3"><Real/></ScalarVariable>
            </ModelVariables></fmiModelDescription>"#,
        )
        .unwrap();
        let named = with_names("#r3# must be > 0 (#i3#, ##1, #r9#, 100 #)", &description);
        assert_eq!(named, "EI1 must be > 0 (x, #1, #r9#, 100 #)");
    }
}
