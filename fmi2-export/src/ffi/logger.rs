//! The host's logger callback (FMI 2.0.4, section 2.1.5).

use std::ffi::{CStr, CString, c_char, c_void};
use std::fmt::{self, Write as _};

use super::types::{CallbackFunctions, LoggerCallback};
use crate::categories::Category;
use crate::status::Status;

const C_NAMES: [&CStr; 4] = [c"logStatusWarning", c"logStatusDiscard", c"logStatusError", c"logEvents"];
const ALL: u8 = 0b1111;

/// Passes messages on to the host, if it wants them.
pub struct Logger {
    callback: Option<LoggerCallback>,
    environment: *mut c_void,
    instance_name: CString,
    /// Enabled categories, a bit each.
    enabled: u8,
}

// SAFETY: the pointer is the host's and only ever handed back to it; the standard allows an instance to move between threads.
unsafe impl Send for Logger {}

impl Logger {
    pub fn new(callbacks: &CallbackFunctions, instance_name: CString, logging_on: bool) -> Self {
        Self {
            callback: callbacks.logger,
            environment: callbacks.component_environment,
            instance_name,
            enabled: if logging_on { ALL } else { 0 },
        }
    }

    /// A logger for what happens before there is an instance: everything is told.
    pub fn enable_all(&mut self) {
        self.enabled = ALL;
    }

    /// Switches categories on or off; `logAll` and an empty list mean all of them.
    ///
    /// # Errors
    /// The first name that is not a category. Nothing is switched then.
    pub fn set<'n>(&mut self, on: bool, categories: &[&'n CStr]) -> Result<(), &'n CStr> {
        let mut mask = if categories.is_empty() { ALL } else { 0 };
        for name in categories {
            mask |= match C_NAMES.iter().position(|known| known == name) {
                Some(i) => 1 << i,
                None if *name == c"logAll" => ALL,
                None => return Err(name),
            };
        }
        // "If loggingOn == fmi2True, debug logging is enabled for the log categories specified, otherwise it is disabled."
        self.enabled = if on { self.enabled | mask } else { self.enabled & !mask };
        Ok(())
    }

    pub fn wants(&self, category: Category) -> bool {
        self.callback.is_some() && self.enabled & (1 << category as u8) != 0
    }

    /// Logs a message, if its category is enabled; it is formatted only then. Why a call failed is always told (section
    /// 2.1.3 has the logger called for it, whatever is enabled): hosts that log nothing would know a number only.
    pub fn log(&self, status: Status, category: Category, message: fmt::Arguments<'_>) {
        let Some(callback) = self.callback else { return };
        if !(self.wants(category) || matches!(status, Status::Discard | Status::Error | Status::Fatal)) {
            return;
        }
        let text = escape(message);
        // SAFETY: the host gave the callback for this purpose; all strings outlive the call; the text has no conversion
        // specification left that would ask for a further argument.
        unsafe {
            callback(
                self.environment,
                self.instance_name.as_ptr(),
                status,
                C_NAMES[category as usize].as_ptr(),
                text.as_ptr().cast::<c_char>(),
            );
        }
    }
}

/// The message as a format string for `printf` that prints it: `%` doubled; and `#`, which introduces references to
/// variables, doubled as well.
fn escape(message: fmt::Arguments<'_>) -> CString {
    struct Escaper(Vec<u8>);
    impl fmt::Write for Escaper {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            for byte in text.bytes().filter(|byte| *byte != 0) {
                if matches!(byte, b'%' | b'#') {
                    self.0.push(byte);
                }
                self.0.push(byte);
            }
            Ok(())
        }
    }
    let mut escaper = Escaper(Vec::new());
    let _ = escaper.write_fmt(message);
    CString::new(escaper.0).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::categories::CATEGORIES;

    #[test]
    fn escapes_what_printf_and_variable_references_would_interpret() {
        assert_eq!(escape(format_args!("100 %s of #r1#\0")).as_bytes(), b"100 %%s of ##r1##");
    }

    #[test]
    fn categories_have_the_names_the_description_lists() {
        for ((name, _), c_name) in CATEGORIES.iter().zip(C_NAMES) {
            assert_eq!(name.as_bytes(), c_name.to_bytes());
        }
    }
}
