//! The log of a slave: the callback that receives messages, and the last messages for the end of an error message.
//!
//! A slave has to pass back the environment that it received, and some slaves pass back something else. So the pointer is
//! never dereferenced: it is looked up among the logs of the living instances.

use std::collections::{HashMap, VecDeque};
use std::ffi::{c_char, c_int, c_void};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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

/// Messages of a slave, the newest [`Messages::CAPACITY`] of them.
#[derive(Default)]
struct Messages(Mutex<VecDeque<LogMessage>>);

impl Messages {
    const CAPACITY: usize = 64;
    /// Bytes of one message that are kept.
    const LONGEST: usize = 1 << 20;

    fn lock(&self) -> MutexGuard<'_, VecDeque<LogMessage>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, mut message: LogMessage) {
        let text = &mut message.text;
        if text.len() > Self::LONGEST {
            let end = (0..=Self::LONGEST).rev().find(|end| text.is_char_boundary(*end));
            text.truncate(end.unwrap_or(0));
        }
        let mut messages = self.lock();
        if messages.len() == Self::CAPACITY {
            messages.pop_front();
        }
        messages.push_back(message);
    }
}

/// The logs of living instances with their names, the oldest first.
static LIVING: Mutex<Vec<(String, Arc<Messages>)>> = Mutex::new(Vec::new());

fn living() -> MutexGuard<'static, Vec<(String, Arc<Messages>)>> {
    LIVING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The log to which a message belongs. It is found by the environment; if the slave lost that, by the instance's name;
/// otherwise it is that of the newest instance, which may still be in `fmi2Instantiate`.
fn meant(environment: *mut c_void, instance: &str) -> Option<Arc<Messages>> {
    let living = living();
    let by_environment = living.iter().find(|(_, log)| Arc::as_ptr(log).cast() == environment.cast_const());
    let by_name = || living.iter().rev().find(|(name, _)| name == instance);
    by_environment.or_else(by_name).or_else(|| living.last()).map(|(_, log)| Arc::clone(log))
}

/// The log of an instance, as long as that lives.
pub(super) struct Log(Arc<Messages>);

impl Log {
    pub(super) fn new(instance: &str) -> Self {
        let messages = Arc::<Messages>::default();
        living().push((instance.to_owned(), Arc::clone(&messages)));
        Self(messages)
    }

    pub(super) fn messages(&self) -> MutexGuard<'_, VecDeque<LogMessage>> {
        self.0.lock()
    }

    /// The callbacks with which a slave logs here.
    pub(super) fn callbacks(&self) -> CallbackFunctions {
        CallbackFunctions {
            logger: fmi2_import_logger,
            allocate_memory: fmi2_import_allocate,
            free_memory: fmi2_import_free,
            step_finished: None,
            component_environment: Arc::as_ptr(&self.0).cast_mut().cast(),
        }
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        living().retain(|(_, log)| !Arc::ptr_eq(log, &self.0));
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
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the C half passes on C strings (or null).
    let (instance, category, text) = unsafe { (text(instance), text(category), text(message)) };
    if let Some(log) = meant(environment, &instance) {
        log.push(LogMessage { status: Status::from_c(status), category, text });
    }
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
    let mut names = None;
    let mut rest = message;
    while let Some(at) = rest.find('#') {
        result.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix('#') {
            result.push('#');
            rest = after;
        } else if let Some((name, after)) = referenced(rest, names.get_or_insert_with(|| names_of(description))) {
            result.push_str(name);
            rest = after;
        } else {
            result.push('#');
        }
    }
    result.push_str(rest);
    result
}

/// The first variable of each value reference, by the letter of its type.
type Names<'a> = HashMap<(char, ValueReference), &'a str>;

fn names_of(description: &ModelDescription) -> Names<'_> {
    let letter = |base_type| match base_type {
        BaseType::Real => 'r',
        BaseType::Integer | BaseType::Enumeration => 'i',
        BaseType::Boolean => 'b',
        BaseType::String => 's',
    };
    let variables = description.variables.iter().rev();
    variables
        .map(|variable| ((letter(variable.base_type()), variable.value_reference), variable.name.as_str()))
        .collect()
}

fn referenced<'a, 'b>(text: &'a str, names: &Names<'b>) -> Option<(&'b str, &'a str)> {
    let (inside, after) = text.split_once('#')?;
    let mut letters = inside.chars();
    let letter = letters.next()?;
    let reference = letters.as_str().parse().ok()?;
    Some((names.get(&(letter, reference))?, after))
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
