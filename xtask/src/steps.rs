//! Steps with a heading, a result and a duration each; the first failure skips the rest.

use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

/// How a step ended.
#[derive(Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done, nothing to object to.
    Passed,
    /// Could not be done here, which is no failure; says why.
    Skipped(String),
    /// Failed; says why.
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
    fn missing_program_is_a_failure_not_a_panic() {
        assert!(matches!(run(Command::new("no-such-program-here")), Outcome::Failed(_)));
    }
}
