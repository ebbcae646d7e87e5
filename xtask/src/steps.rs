//! Steps with a heading, a result and a duration each; the first failure skips the rest.

use std::num::NonZero;
use std::process::{Command, ExitCode};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::beside::Beside;
use crate::output;

/// How a step ended.
#[derive(Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done, nothing to object to.
    Passed,
    /// Not possible here, which is no failure; contains the reason.
    Skipped(String),
    /// Failed; contains the reason.
    Failed(String),
}

/// Runs steps in order and keeps their results.
pub struct Runner {
    begin: Instant,
    planned: usize,
    results: Vec<(&'static str, Outcome, Duration)>,
    not_reached: Vec<&'static str>,
}

impl Runner {
    /// A runner of `planned` steps (the number is only for the headings).
    pub fn new(planned: usize) -> Self {
        Self { begin: Instant::now(), planned, results: Vec::new(), not_reached: Vec::new() }
    }

    /// Runs one step, unless an earlier one has failed.
    pub fn step(&mut self, name: &'static str, action: impl FnOnce() -> Outcome) {
        if self.failed() {
            self.not_reached.push(name);
            return;
        }
        self.heading(name);
        let start = Instant::now();
        let outcome = action();
        self.add(name, outcome, start.elapsed());
    }

    /// Waits for the next step that runs beside ours, and prints what it has printed. After a failure, one that has begun is still
    /// waited for, and the others do not begin.
    pub fn end(&mut self, beside: &Beside, name: &'static str) {
        if self.failed() {
            beside.stop();
        } else {
            self.heading(name);
        }
        match beside.next() {
            Some(ended) => {
                if self.failed() {
                    self.heading(name);
                }
                output::say(&ended.output);
                self.add(name, ended.outcome, ended.duration);
            }
            None if self.failed() => self.not_reached.push(name),
            None => self.add(name, Outcome::Failed("it panicked".into()), Duration::ZERO),
        }
    }

    fn heading(&self, name: &str) {
        output::line(&format!("\n=== {}/{} {name} ===", self.results.len() + 1, self.planned));
    }

    fn add(&mut self, name: &'static str, outcome: Outcome, duration: Duration) {
        match &outcome {
            Outcome::Passed => {}
            Outcome::Skipped(reason) => output::line(&format!("not checked: {reason}")),
            Outcome::Failed(reason) => eprintln!("failed: {reason}"),
        }
        self.results.push((name, outcome, duration));
    }

    /// Prints the summary and gives the process's exit code.
    pub fn finish(self) -> ExitCode {
        output::say(self.summary().as_bytes());
        ExitCode::from(u8::from(self.failed()))
    }

    /// Whether a step has failed.
    pub fn failed(&self) -> bool {
        self.failure().is_some()
    }

    fn failure(&self) -> Option<&'static str> {
        self.results.iter().find_map(|(name, outcome, _)| matches!(outcome, Outcome::Failed(_)).then_some(*name))
    }

    fn summary(&self) -> String {
        use std::fmt::Write as _;
        let mut text = String::from("\n=== Summary ===\n");
        for (name, outcome, duration) in &self.results {
            let (word, remark) = match outcome {
                Outcome::Passed => ("passed", ""),
                Outcome::Skipped(reason) => ("not checked", reason.as_str()),
                Outcome::Failed(reason) => ("FAILED", reason.as_str()),
            };
            let line = format!("{name:<28} {word:<12} {:>7.1} s  {remark}", duration.as_secs_f64());
            let _ = writeln!(text, "{}", line.trim_end());
        }
        for name in &self.not_reached {
            let _ = writeln!(text, "{name:<28} not run");
        }
        // Steps that run beside each other take less time than their sum.
        let took = self.begin.elapsed().as_secs_f64();
        let _ = match self.failure() {
            Some(name) => writeln!(text, "\nFAILED at: {name}"),
            None => writeln!(text, "\nAll steps passed, in {took:.0} s."),
        };
        text
    }
}

/// Runs a command with its output going through, after printing its command line.
pub fn run(command: Command) -> Outcome {
    let line = line(&command);
    output::line(&format!("$ {line}"));
    match output::status(command) {
        Ok(status) if status.success() => Outcome::Passed,
        Ok(status) => Outcome::Failed(format!("`{line}` ended with {status}")),
        Err(error) => Outcome::Failed(format!("`{line}` did not start: {error}")),
    }
}

/// Runs commands side by side, as many as there are processors, and prints the output of each when all have ended. All of them
/// run; the first failure in their order is the outcome.
pub fn run_together(commands: impl IntoIterator<Item = Command>) -> Outcome {
    let waiting: Mutex<Vec<Command>> = Mutex::new(commands.into_iter().collect());
    waiting.lock().unwrap_or_else(PoisonError::into_inner).reverse();
    let ended = Mutex::new(Vec::new());
    let next = || {
        let mut waiting = waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.pop().map(|command| (waiting.len(), command))
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, NonZero::get) {
            scope.spawn(|| {
                while let Some((left, command)) = next() {
                    let (outcome, text) = output::held(|| run(command));
                    ended.lock().unwrap_or_else(PoisonError::into_inner).push((left, outcome, text));
                }
            });
        }
    });
    let mut ended = ended.into_inner().unwrap_or_else(PoisonError::into_inner);
    ended.sort_by_key(|(left, ..)| std::cmp::Reverse(*left));
    for (_, _, text) in &ended {
        output::say(text);
    }
    let failure = ended.into_iter().map(|(_, outcome, _)| outcome).find(|outcome| *outcome != Outcome::Passed);
    failure.unwrap_or(Outcome::Passed)
}

/// The command as one would type it: the program by its bare name.
fn line(command: &Command) -> String {
    let program = std::path::Path::new(command.get_program());
    let name = program.file_name().unwrap_or(program.as_os_str()).to_string_lossy();
    std::iter::once(name).chain(command.get_args().map(|arg| arg.to_string_lossy())).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_failure_skips_the_rest_and_is_named() {
        let mut steps = Runner::new(3);
        steps.step("one", || Outcome::Passed);
        steps.step("two", || Outcome::Failed("broken".into()));
        steps.step("three", || unreachable!("must not run after a failure"));
        let summary = steps.summary();
        assert!(summary.contains("FAILED at: two") && summary.contains("broken"), "{summary}");
        assert!(summary.contains("three                        not run"), "{summary}");
    }

    #[test]
    fn skipped_step_is_reported_and_no_failure() {
        let mut steps = Runner::new(1);
        steps.step("one", || Outcome::Skipped("no rustfmt".into()));
        let summary = steps.summary();
        assert!(summary.contains("not checked") && summary.contains("no rustfmt"), "{summary}");
        assert!(!summary.contains("FAILED"), "{summary}");
    }

    #[test]
    fn of_commands_side_by_side_all_run_and_the_first_failure_counts() {
        let cargo = |argument: &str| {
            let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
            command.arg(argument);
            command
        };
        assert_eq!(run_together([cargo("--version"), cargo("--version"), cargo("--help")]), Outcome::Passed);
        let outcome =
            run_together([cargo("--version"), cargo("no-such-command"), Command::new("no-such-program-here")]);
        assert!(matches!(&outcome, Outcome::Failed(reason) if reason.contains("no-such-command")), "{outcome:?}");
    }

    #[test]
    fn missing_program_is_a_failure_not_a_panic() {
        assert!(matches!(run(Command::new("no-such-program-here")), Outcome::Failed(_)));
    }
}
