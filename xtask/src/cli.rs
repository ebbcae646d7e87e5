//! The command line.

use std::path::PathBuf;

/// What `cargo xtask --help` prints.
pub const HELP: &str = "\
Developer commands of this workspace.

Usage: cargo xtask <COMMAND>

Commands:
  test [--rust | --python] [-- <PYTEST ARGS>...]
         Run every test. Steps: FMUs built and packaged into dist/, Rust tests, Python environment (in the build
         directory, kept between runs), helper programs for the Python tests, Python tests, long checks (valgrind,
         load cycles), instruction counts, code checks.
         --rust    only the Rust tests
         --python  only the FMUs and the Python tests
  check  Run the code checks only: cargo fmt --check, cargo clippy, cargo doc, warnings denied.
         What needs a toolchain component that is not installed is skipped, and said so.
  describe
         Renew modelDescription/ after a change of an FMU's variables. Look at the difference before
         you commit it: it is what users of the FMUs will see.
  new-fmu PATH
         Make a crate in the new folder PATH that exports a model as an FMU, ready to be changed. The folder's
         name becomes the crate's: cargo xtask new-fmu ../dc-motor
  counts [--record NOTE]
         Count the instructions of a communication step (with valgrind, if it is installed) and fail if one
         costs over 5 % more than the last entry of docs/performance/instructions.csv.
         --record NOTE  add an entry instead
  help   Print this text (also -h, --help).

Environment:
  PYTHON            the interpreter that makes the Python environment (default: python3); 3.9 or newer
  CARGO_TARGET_DIR  the build directory (default: target)
  CI                `true`: tests of pages install Chromium (apt-get) and fail where they would be skipped without it or npm

Examples:
  cargo xtask test                                  # everything, as continuous integration does
  cargo xtask test --rust
  cargo xtask test --python -- -k closed_loop -x    # some Python tests, stop at the first failure
  cargo xtask check
  cargo xtask describe && git diff modelDescription
";

/// A parsed command line.
#[derive(Debug, PartialEq, Eq)]
pub enum Request {
    /// Print [`HELP`].
    Help,
    /// Run tests.
    Test {
        /// Which of them.
        selection: Selection,
        /// Handed to pytest as they are.
        pytest_args: Vec<String>,
    },
    /// Run the code checks.
    Check,
    /// Renew the checked-in descriptions.
    Describe,
    /// Make a new model crate.
    NewFmu {
        /// Its folder.
        path: PathBuf,
    },
    /// Compare instruction counts with their history.
    Counts {
        /// Add them to the history with this remark instead.
        record: Option<String>,
    },
}

/// Which half of the tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// Rust, Python and the code checks.
    All,
    /// Only `cargo test`.
    Rust,
    /// Only the FMUs and pytest.
    Python,
}

/// Reads the arguments after the program's name; the error is one sentence for the user.
pub fn parse(args: impl IntoIterator<Item = String>) -> Result<Request, String> {
    let mut args = args.into_iter();
    let Some(command) = args.next() else {
        return Ok(Request::Help);
    };
    match command.as_str() {
        "help" | "-h" | "--help" => Ok(Request::Help),
        "test" => parse_test(args),
        "check" => alone(Request::Check, "check", args),
        "describe" => alone(Request::Describe, "describe", args),
        "new-fmu" => parse_new_fmu(args),
        "counts" => parse_counts(args),
        other => Err(format!("unknown command `{other}`")),
    }
}

/// A command that takes no arguments.
fn alone(request: Request, name: &str, mut args: impl Iterator<Item = String>) -> Result<Request, String> {
    match args.next().as_deref() {
        None => Ok(request),
        Some("-h" | "--help") => Ok(Request::Help),
        Some(other) => Err(format!("`{name}` takes no argument, got `{other}`")),
    }
}

fn parse_new_fmu(mut args: impl Iterator<Item = String>) -> Result<Request, String> {
    match (args.next().as_deref(), args.next()) {
        (Some("-h" | "--help"), _) => Ok(Request::Help),
        (Some(path), None) if !path.starts_with('-') => Ok(Request::NewFmu { path: path.into() }),
        _ => Err("`new-fmu` takes one argument, the new folder".into()),
    }
}

fn parse_counts(mut args: impl Iterator<Item = String>) -> Result<Request, String> {
    match (args.next().as_deref(), args.next(), args.next()) {
        (None, ..) => Ok(Request::Counts { record: None }),
        (Some("-h" | "--help"), ..) => Ok(Request::Help),
        (Some("--record"), Some(note), None) => Ok(Request::Counts { record: Some(note) }),
        (Some("--record"), ..) => Err("--record takes one remark, in quotes".into()),
        (Some(other), ..) => Err(format!("`counts` does not know `{other}`")),
    }
}

fn parse_test(mut args: impl Iterator<Item = String>) -> Result<Request, String> {
    let mut selection = Selection::All;
    let mut pytest_args = Vec::new();
    while let Some(arg) = args.next() {
        let wanted = match arg.as_str() {
            "--rust" => Selection::Rust,
            "--python" => Selection::Python,
            "-h" | "--help" => return Ok(Request::Help),
            "--" => {
                pytest_args.extend(args.by_ref());
                break;
            }
            other => {
                return Err(format!("`test` does not know `{other}` (arguments for pytest go after `--`)"));
            }
        };
        if selection != Selection::All && selection != wanted {
            return Err("--rust and --python exclude each other; leave both out to run everything".into());
        }
        selection = wanted;
    }
    if selection == Selection::Rust && !pytest_args.is_empty() {
        return Err("--rust does not run pytest, so it takes no arguments for it".into());
    }
    Ok(Request::Test { selection, pytest_args })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Request, String> {
        parse(line.split_whitespace().map(String::from))
    }

    #[test]
    fn commands() {
        assert_eq!(parsed(""), Ok(Request::Help));
        assert_eq!(parsed("--help"), Ok(Request::Help));
        assert_eq!(parsed("check"), Ok(Request::Check));
        assert_eq!(parsed("counts"), Ok(Request::Counts { record: None }));
        assert_eq!(parsed("counts --record why"), Ok(Request::Counts { record: Some("why".into()) }));
        assert_eq!(parsed("describe"), Ok(Request::Describe));
        assert_eq!(parsed("new-fmu ../dc-motor"), Ok(Request::NewFmu { path: "../dc-motor".into() }));
        assert_eq!(parsed("test"), Ok(Request::Test { selection: Selection::All, pytest_args: vec![] }));
        assert_eq!(parsed("test --rust"), Ok(Request::Test { selection: Selection::Rust, pytest_args: vec![] }));
    }

    #[test]
    fn arguments_after_two_dashes_go_to_pytest() {
        let pytest_args = vec!["-k".into(), "alone".into(), "--python".into()];
        assert_eq!(
            parsed("test --python -- -k alone --python"),
            Ok(Request::Test { selection: Selection::Python, pytest_args })
        );
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        for line in [
            "tset",
            "test --fast",
            "test --rust --python",
            "test --rust -- -x",
            "check now",
            "describe all",
            "counts x",
            "new-fmu",
            "new-fmu a b",
            "new-fmu --fast",
            "counts --record",
        ] {
            assert!(parsed(line).is_err(), "{line}");
        }
    }

    #[test]
    fn help_names_every_command_and_option() {
        for word in [
            "test",
            "check",
            "describe",
            "new-fmu",
            "counts",
            "--record",
            "help",
            "--rust",
            "--python",
            "PYTHON",
            "CARGO_TARGET_DIR",
        ] {
            assert!(HELP.contains(word), "{word}");
        }
    }
}
