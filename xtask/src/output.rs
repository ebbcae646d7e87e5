//! What steps print: at once, or held back until the steps before them have printed theirs.

use std::cell::RefCell;
use std::io::{self, Read as _, Write as _};
use std::process::{Command, ExitStatus, Stdio};

thread_local! {
    /// What this thread has printed so far, if it is held back.
    static HELD: RefCell<Option<Vec<u8>>> = const { RefCell::new(None) };
}

/// Calls `action` and returns what it printed in this thread.
pub fn held<T>(action: impl FnOnce() -> T) -> (T, Vec<u8>) {
    HELD.set(Some(Vec::new()));
    let result = action();
    (result, HELD.take().unwrap_or_default())
}

/// Prints bytes.
pub fn say(bytes: &[u8]) {
    let held = HELD.with_borrow_mut(|held| held.as_mut().map(|held| held.extend_from_slice(bytes)).is_some());
    if !held {
        // Who closes our output does not want it.
        let _ = io::stdout().write_all(bytes).and_then(|()| io::stdout().flush());
    }
}

/// Prints a line.
pub fn line(text: &str) {
    say(format!("{text}\n").as_bytes());
}

/// Runs a command; what it prints to either stream goes where ours goes.
pub fn status(mut command: Command) -> io::Result<ExitStatus> {
    if HELD.with_borrow(Option::is_none) {
        return command.status();
    }
    let (output, status) = collected(command)?;
    say(&output);
    Ok(status)
}

/// Runs a command without input; returns what it printed to both streams, in its order.
pub fn collected(mut command: Command) -> io::Result<(Vec<u8>, ExitStatus)> {
    let (mut reader, writer) = io::pipe()?;
    command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
    let mut child = command.spawn()?;
    // It has the ends to write to; while they are open, the reader waits for more.
    drop(command);
    let mut output = Vec::new();
    reader.read_to_end(&mut output)?;
    Ok((output, child.wait()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_comes_in_its_order_with_both_streams_of_programs() {
        let cargo = |argument: &str| {
            let mut command = Command::new(crate::tree::cargo());
            command.arg(argument);
            command
        };
        let (succeeded, text) = held(|| {
            line("before");
            let statuses = [status(cargo("--version")).unwrap(), status(cargo("no-such-command")).unwrap()];
            line("after");
            statuses.map(|status| status.success())
        });
        let text = String::from_utf8(text).unwrap();
        assert_eq!(succeeded, [true, false]);
        assert!(text.starts_with("before\ncargo 1.") && text.ends_with("after\n"), "{text}");
        assert!(text.contains("error: no such command"), "{text}");
    }
}
