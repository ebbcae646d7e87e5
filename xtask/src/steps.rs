//! Steps with a heading, a result and a duration each; the first failure skips the rest.

use std::num::NonZero;
use std::process::{Command, ExitCode, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

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
    planned: usize,
    results: Vec<(&'static str, Outcome, Duration)>,
    not_reached: Vec<&'static str>,
}

impl Runner {
    /// A runner of `planned` steps (the number is only for the headings).
    pub fn new(planned: usize) -> Self {
        Self { planned, results: Vec::new(), not_reached: Vec::new() }
    }

    /// Runs one step, unless an earlier one has failed.
    pub fn step(&mut self, name: &'static str, action: impl FnOnce() -> Outcome) {
        if self.failed() {
            self.not_reached.push(name);
            return;
        }
        println!("\n=== {}/{} {name} ===", self.results.len() + 1, self.planned);
        let start = Instant::now();
        let outcome = action();
        match &outcome {
            Outcome::Passed => {}
            Outcome::Skipped(reason) => println!("not checked: {reason}"),
            Outcome::Failed(reason) => eprintln!("failed: {reason}"),
        }
        self.results.push((name, outcome, start.elapsed()));
    }

    /// Prints the summary and gives the process's exit code.
    pub fn finish(self) -> ExitCode {
        print!("{}", self.summary());
        ExitCode::from(u8::from(self.failed()))
    }

    fn failed(&self) -> bool {
        matches!(self.results.last(), Some((_, Outcome::Failed(_), _)))
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
        let _ = match self.results.last() {
            Some((name, Outcome::Failed(_), _)) => writeln!(text, "\nFAILED at: {name}"),
            _ => writeln!(text, "\nAll steps passed."),
        };
        text
    }
}

/// Runs a command with its output going through, after printing its command line.
pub fn run(mut command: Command) -> Outcome {
    println!("$ {}", line(&command));
    match command.status() {
        Ok(status) if status.success() => Outcome::Passed,
        Ok(status) => Outcome::Failed(format!("`{}` ended with {status}", line(&command))),
        Err(error) => Outcome::Failed(format!("`{}` did not start: {error}", line(&command))),
    }
}

/// Runs commands side by side, as many as there are processors, with the output of each printed when it ends. All of them
/// run; the first failure in their order is the outcome.
pub fn run_together(commands: impl IntoIterator<Item = Command>) -> Outcome {
    let waiting: Mutex<Vec<(usize, Command)>> = Mutex::new(commands.into_iter().enumerate().collect());
    let failures = Mutex::new(Vec::new());
    let next = || {
        let mut waiting = waiting.lock().unwrap_or_else(PoisonError::into_inner);
        (!waiting.is_empty()).then(|| waiting.remove(0))
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, NonZero::get) {
            scope.spawn(|| {
                while let Some((index, mut command)) = next() {
                    let output = command.stdin(Stdio::null()).output();
                    let mut failures = failures.lock().unwrap_or_else(PoisonError::into_inner);
                    println!("$ {}", line(&command));
                    match output {
                        Ok(output) => {
                            print!("{}", String::from_utf8_lossy(&output.stdout));
                            eprint!("{}", String::from_utf8_lossy(&output.stderr));
                            if !output.status.success() {
                                failures.push((index, format!("`{}` ended with {}", line(&command), output.status)));
                            }
                        }
                        Err(error) => failures.push((index, format!("`{}` did not start: {error}", line(&command)))),
                    }
                }
            });
        }
    });
    let failures = failures.into_inner().unwrap_or_else(PoisonError::into_inner);
    failures.into_iter().min().map_or(Outcome::Passed, |(_, reason)| Outcome::Failed(reason))
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
