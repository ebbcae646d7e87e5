//! The command line: arguments, exit codes, error messages.

mod certify;
mod compare;
mod completions;
mod fmus;
mod info;
mod instruments;
mod json;
mod later;
mod linearise;
mod matrix;
mod meant;
mod numbers;
mod package;
mod printable;
mod process;
mod progress;
mod report;
mod scenario;
mod simulate;
mod sweep;
mod tune;
mod tuned;
mod verify;

use std::fmt;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::OnceLock;

use later::Later;
use printable::printable;

use clap::{CommandFactory, Parser, Subcommand};

use crate::build::PackageError;
use crate::build::crosscheck::ReleaseError;
use crate::grasp::NoFunctions;
use crate::grasp::systems::ComposeError;
use crate::verify::VerifyError;
use fmi2_cosim::files::WriteError;
use fmi2_cosim::master::MasterError;
use fmi2_cosim::ssp::SspError;
use fmi2_import::{CallError, FmuError};

/// What a user reads below the help text.
const AFTER_HELP: &str = "\
Examples:
  dualarm                                       everything; results/report.html
  dualarm simulate --controller pds -o pds.csv  the paper's PDS case
  dualarm simulate friction --report page.html  a page with the arms in motion
  dualarm report mine.csv pds.parquet           the same of saved results
  dualarm simulate --list                       what else there is to run
  dualarm scenario friction > my-grasp.toml     a scenario to start from
  dualarm simulate my-grasp.toml --set M=0.4    a scenario of your own
  dualarm simulate plant.fmu my_controller.fmu  any FMUs, wired by equal names
  dualarm info plant.fmu                        what an FMU is
  dualarm compare --matrix                      every controller in every case
  dualarm tune --controller pd-tuned            gains from a search
  dualarm sweep study.toml                      many runs, over ranges
  dualarm verify                                against exact solutions

Exit codes: 0 success, 1 a simulation, a check or a file failed, 2 wrong usage
(options, --set values, scenario files). Results go to standard output, progress
and warnings to standard error.";

/// Packages the dual-arm grasp FMUs, co-simulates any FMI 2.0 FMUs, compares the paper's controllers.
#[derive(Debug, Parser)]
#[command(name = "dualarm", version, after_help = AFTER_HELP)]
struct Arguments {
    /// What to do; without it: compare
    #[command(subcommand)]
    command: Option<Command>,
    /// Only print errors
    #[arg(long, short, global = true, display_order = 900)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Build the FMUs and systems from this repository and write them to a folder
    Package(Later<package::Arguments>),
    /// Co-simulate FMUs, connected by equal names
    Simulate(Later<simulate::Arguments>),
    /// Print a built-in scenario, to start one of your own from, and say where its file is
    Scenario(Later<scenario::Arguments>),
    /// Package the FMUs, run every controller in every case and the paper's three scenarios, write tables, figures and a report
    Compare(Later<compare::Arguments>),
    /// Make a page of saved results: animation, linked curves, metrics
    Report(Later<report::Arguments>),
    /// Search for the best gains of a controller over a set of cases
    Tune(Later<tune::Arguments>),
    /// Run a system many times, with parameters on grids or drawn from ranges
    Sweep(Later<sweep::Arguments>),
    /// Check the FMUs against exact and independent solutions; fails if a bound is broken
    Verify(Later<verify::Arguments>),
    /// Show what an FMU is: capabilities, platforms, variables
    Info(Later<info::Arguments>),
    /// Say what is proved of a control law: decay rate, ultimate bounds, or why there is no proof
    Certify(Later<certify::Arguments>),
    /// Write the plant as a linear system (A, B, C, D) for MATLAB, Octave or Python
    Linearise(Later<linearise::Arguments>),
    /// Print a completion script for a shell
    Completions(Later<completions::Arguments>),
}

/// Why the program ends early: exit code and message.
#[derive(Debug)]
struct Failure {
    code: u8,
    message: String,
}

impl Failure {
    /// The user asked for something that cannot be.
    fn usage(message: impl fmt::Display) -> Self {
        Self { code: 2, message: message.to_string() }
    }

    /// A simulation, a build or a file failed.
    fn failed(message: impl fmt::Display) -> Self {
        Self { code: 1, message: message.to_string() }
    }
}

/// Converts errors that occur during the work to failures.
macro_rules! failures {
    ($($error:ty),* $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::failed(error)
            }
        })*
    };
}
failures![
    io::Error,
    CallError,
    ComposeError,
    FmuError,
    MasterError,
    NoFunctions,
    PackageError,
    ReleaseError,
    SspError,
    VerifyError,
    WriteError,
];

/// Why standard output did not take everything: the first reason.
static LOST: OnceLock<io::Error> = OnceLock::new();

/// Prints to standard output. If the reader has closed it (`| head`), this is no failure. Any other error (a full disk)
/// makes [`main`] fail at the end, when everything else is done.
fn print(text: &str) {
    match process::write_to_standard_output(printable(text).as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => drop(LOST.set(error)),
        _ => {}
    }
}

/// The width of tables: that of the terminal, but 80 columns if it is narrower or the output goes elsewhere.
fn width() -> usize {
    const USUAL: usize = 80;
    terminal_size::terminal_size_of(process::standard_output()).map_or(USUAL, |(width, _)| USUAL.max(width.0.into()))
}

/// Prints a result, which must arrive: a reader that has gone makes [`main`] fail too.
fn print_result(text: &str) {
    if let Err(error) = process::write_to_standard_output(text.as_bytes()) {
        drop(LOST.set(error));
    }
}

/// Prints to standard error, whether or not anyone still listens: `eprint!` would panic.
fn print_error(text: &str) {
    let _ = io::stderr().write_all(printable(text).as_bytes());
}

/// A message as one paragraph: no line of it can be mistaken for another message, and none is longer than a screen.
fn paragraph(message: &str) -> String {
    const LONGEST: usize = 8000;
    let mut text: String = message.chars().take(LONGEST).collect();
    if text.len() < message.len() {
        text += " …";
    }
    text.trim_end().replace('\t', " ").replace('\n', "\n       ")
}

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(answer) => return ExitCode::from(answer_without_work(&answer)),
    };
    ExitCode::from(process::run(|| work(arguments)))
}

/// Prints help, the version, or a fault of the arguments.
fn answer_without_work(answer: &clap::Error) -> u8 {
    let code = u8::try_from(answer.exit_code()).unwrap_or(2);
    if answer.use_stderr() {
        let _ = answer.print();
        return code;
    }
    let arrived = process::check_standard_output().and_then(|()| answer.print()).and_then(|()| io::stdout().flush());
    match arrived {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            print_error(&format!("error: {}\n", no_standard_output(&error)));
            1
        }
        _ => code,
    }
}

fn no_standard_output(error: &io::Error) -> String {
    format!("cannot write to standard output: {error}")
}

/// Executes the command; returns the exit code.
fn work(arguments: Arguments) -> u8 {
    let result = run(arguments);
    let result = result.and_then(|()| match LOST.get() {
        Some(error) if error.kind() == io::ErrorKind::BrokenPipe => {
            Err(Failure::failed("the reader of standard output has gone before it had everything"))
        }
        Some(error) => Err(Failure::failed(no_standard_output(error))),
        None => Ok(()),
    });
    match result {
        Ok(()) => 0,
        Err(failure) => {
            print_error(&format!("error: {}\n", paragraph(&failure.message)));
            failure.code
        }
    }
}

fn run(arguments: Arguments) -> Result<(), Failure> {
    let quiet = arguments.quiet;
    match arguments.command.unwrap_or(Command::Compare(Later(compare::Arguments::default()))) {
        Command::Package(Later(arguments)) => package::run(&arguments, quiet),
        Command::Simulate(Later(arguments)) => simulate::run(&arguments, quiet),
        Command::Compare(Later(arguments)) => compare::run(&arguments, quiet),
        Command::Scenario(Later(arguments)) => scenario::run(&arguments, quiet),
        Command::Report(Later(arguments)) => report::run(&arguments, quiet),
        Command::Tune(Later(arguments)) => tune::run(&arguments, quiet),
        Command::Sweep(Later(arguments)) => sweep::run(&arguments, quiet),
        Command::Verify(Later(arguments)) => verify::run(&arguments, quiet),
        Command::Info(Later(arguments)) => info::run(&arguments),
        Command::Certify(Later(arguments)) => certify::run(&arguments),
        Command::Linearise(Later(arguments)) => linearise::run(&arguments, quiet),
        Command::Completions(Later(arguments)) => {
            completions::run(&arguments, &mut Arguments::command());
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All commands with all their arguments.
    fn whole() -> clap::Command {
        let mut command = Arguments::command();
        command.build();
        command
    }

    /// clap breaks every line that is longer than the terminal is wide. This suits a paragraph that is one line here, but
    /// not a paragraph that is already broken into lines, and not columns.
    #[test]
    fn what_stands_below_help_is_broken_once() {
        for command in whole().get_subcommands() {
            let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let lines: Vec<_> = text.lines().collect();
            for (index, line) in lines.iter().enumerate().filter(|(_, line)| line.chars().count() > 80) {
                let before = index.checked_sub(1).map_or("", |before| lines[before]);
                let after = lines.get(index + 1).map_or("", |after| after);
                let is_paragraph = before.is_empty() && (after.is_empty() || after.starts_with("  "));
                assert!(is_paragraph && !line.starts_with(' '), "{}: {line}", command.get_name());
            }
        }
    }

    /// Every numeric option names the allowed values in its error message instead of a parser's complaint.
    #[test]
    fn what_is_no_number_is_answered_with_what_is_wanted() {
        let mut tried = 0;
        for command in whole().get_subcommands() {
            let name = command.get_name();
            let needed: &[&str] = match name {
                "sweep" => &["study.toml"],
                "tune" => &["--controller", "pd"],
                _ => &[],
            };
            for option in command.get_arguments().filter_map(clap::Arg::get_long) {
                let value = format!("--{option}=1x");
                let words = ["dualarm", name].into_iter().chain(needed.iter().copied()).chain([value.as_str()]);
                let Err(error) = Arguments::try_parse_from(words) else { continue };
                let message = error.to_string();
                assert!(!message.contains("invalid float") && !message.contains("invalid digit"), "{message}");
                tried += usize::from(message.contains("number"));
            }
        }
        assert!(tried > 15, "{tried} options take numbers");
    }
}
