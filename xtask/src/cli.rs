//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// The text below the commands in `cargo xtask --help`.
const AFTER_HELP: &str = "\
Environment:
  PYTHON            the interpreter that makes the Python environment (default: python3); 3.9 or newer
  CARGO_TARGET_DIR  the build directory (default: target)
  CI                `true`: tests of pages install Chromium (apt-get) and fail where they would be skipped without it or npm

Examples:
  cargo xtask test                                  # everything, as continuous integration does
  cargo xtask test --all-platforms                  # and the FMUs on Windows, ARM and an old Linux, by emulation
  cargo xtask test --rust
  cargo xtask test --python -- -k closed_loop -x    # some Python tests, stop at the first failure
  cargo xtask check
  cargo xtask describe && git diff modelDescription
";

/// Developer commands of this workspace.
#[derive(Debug, Parser)]
#[command(name = "xtask", bin_name = "cargo xtask", after_help = AFTER_HELP, arg_required_else_help = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, PartialEq, Eq, Subcommand)]
pub enum Command {
    /// Run every test: Rust, the packaged FMUs, Python, long checks, instruction counts, code checks
    Test(Test),
    /// Run the code checks only: formatting, lints, documentation, workflow files
    ///
    /// Skips a check whose program is not installed, and says so.
    Check,
    /// Renew modelDescription/ after a change of an FMU's variables
    ///
    /// Look at the difference before you commit it: it is what users of the FMUs will see.
    Describe,
    /// Make a crate in the new folder PATH that exports a model as an FMU, ready to be changed
    ///
    /// The folder's name becomes the crate's: cargo xtask new-fmu ../dc-motor
    NewFmu {
        /// The new folder
        path: PathBuf,
    },
    /// Package the crates that are meant for crates.io, unpack them, and run their tests there
    Published,
    /// Build the FMUs for Windows, 64-bit ARM and an old Linux, and run them under wine, qemu and an old C library
    ///
    /// Skips a platform whose compiler or emulator is not installed, and says what is missing. On Debian: gcc-mingw-w64-x86-64
    /// wine64 rustc-web cargo-web rust-web-src qemu-user debootstrap; zig comes from `PyPI`.
    Platforms,
    /// Make a folder with what a release page offers: FMUs and systems of all platforms that can be built here, cross-check
    /// folders, the tool, the Python wheel, notes and checksums
    Release {
        /// The folder; what is in it is removed
        #[arg(long, short, default_value = "target/downloads", value_name = "FOLDER")]
        out: PathBuf,
        /// FMUs that were packaged on another machine, or a folder of them, whose libraries are added
        #[arg(long, value_name = "PATH")]
        merge: Vec<PathBuf>,
    },
    /// Count the instructions of a communication step, and fail if one costs over 5 % more than the last time
    ///
    /// Needs valgrind; without it the counts are skipped. The last time is the last entry of
    /// docs/performance/instructions.csv.
    Counts {
        /// Add an entry with this remark instead
        #[arg(long, value_name = "NOTE")]
        record: Option<String>,
    },
}

/// Arguments of `cargo xtask test`.
#[derive(Args, Clone, Debug, Default, PartialEq, Eq)]
pub struct Test {
    /// Only the Rust tests
    #[arg(long, conflicts_with_all = ["python", "pytest_args"])]
    pub rust: bool,
    /// Also what `cargo xtask platforms` does
    #[arg(long, conflicts_with_all = ["rust", "python", "pytest_args"])]
    pub all_platforms: bool,
    /// Only the FMUs and the Python tests
    #[arg(long)]
    pub python: bool,
    /// For pytest, after `--`: for example a file, or -k and a part of a test's name
    #[arg(last = true, value_name = "PYTEST ARGS")]
    pub pytest_args: Vec<String>,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    fn parsed(line: &str) -> Option<Command> {
        let words = std::iter::once("xtask").chain(line.split_whitespace());
        Arguments::try_parse_from(words).ok().map(|arguments| arguments.command)
    }

    #[test]
    fn the_definition_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn commands() {
        assert_eq!(parsed("check"), Some(Command::Check));
        assert_eq!(parsed("counts"), Some(Command::Counts { record: None }));
        assert_eq!(parsed("counts --record why"), Some(Command::Counts { record: Some("why".into()) }));
        assert_eq!(parsed("describe"), Some(Command::Describe));
        assert_eq!(parsed("published"), Some(Command::Published));
        assert_eq!(parsed("platforms"), Some(Command::Platforms));
        let downloads = |merge| Some(Command::Release { out: "target/downloads".into(), merge });
        assert_eq!(parsed("release"), downloads(Vec::new()));
        assert_eq!(parsed("release --merge a --merge b"), downloads(vec!["a".into(), "b".into()]));
        let everything = Test { all_platforms: true, ..Test::default() };
        assert_eq!(parsed("test --all-platforms"), Some(Command::Test(everything)));
        assert_eq!(parsed("new-fmu ../dc-motor"), Some(Command::NewFmu { path: "../dc-motor".into() }));
        assert_eq!(parsed("test"), Some(Command::Test(Test::default())));
        assert_eq!(parsed("test --rust"), Some(Command::Test(Test { rust: true, ..Test::default() })));
    }

    #[test]
    fn arguments_after_two_dashes_go_to_pytest() {
        let pytest_args = vec!["-k".into(), "alone".into(), "--python".into()];
        let expected = Test { python: true, pytest_args, ..Test::default() };
        assert_eq!(parsed("test --python -- -k alone --python"), Some(Command::Test(expected)));
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        for line in [
            "",
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
            assert_eq!(parsed(line), None, "{line}");
        }
    }

    #[test]
    fn help_names_every_variable_of_the_environment() {
        let help = Arguments::command().render_long_help().to_string();
        for name in [
            "PYTHON",
            "CARGO_TARGET_DIR",
            "CI",
            "test",
            "check",
            "describe",
            "new-fmu",
            "published",
            "platforms",
            "release",
            "counts",
        ] {
            assert!(help.contains(name), "{name} is missing in\n{help}");
        }
    }
}
