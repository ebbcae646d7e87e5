//! What steps print: at once, or held back until the steps before them have printed theirs.

use std::cell::RefCell;
use std::io::{self, Read as _, Seek as _, Write as _};
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

/// Runs a command without input; returns what it printed to both streams, in its order, until it ended: processes that it leaves
/// behind are not waited for.
pub fn collected(mut command: Command) -> io::Result<(Vec<u8>, ExitStatus)> {
    let mut file = tempfile::tempfile()?;
    let status = command.stdin(Stdio::null()).stdout(file.try_clone()?).stderr(file.try_clone()?).status()?;
    file.rewind()?;
    let mut output = Vec::new();
    file.read_to_end(&mut output)?;
    Ok((output, status))
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

    /// A process that is left behind holds both streams open for ten minutes.
    #[cfg(unix)]
    #[test]
    fn what_a_command_leaves_behind_is_not_waited_for() {
        let mut command = Command::new("sh");
        command.args(["-c", "sleep 600 & echo $!; echo done"]);
        let (output, status) = collected(command).unwrap();
        let text = String::from_utf8(output).unwrap();
        let (left, rest) = text.split_once('\n').unwrap();
        // A process that has ended cannot be ended.
        assert!(Command::new("kill").arg(left).status().unwrap().success(), "{text}");
        assert!(status.success() && rest == "done\n", "{text}");
    }
}
