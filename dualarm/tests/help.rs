//! What the tool says of itself: help, examples, completions, scenarios.

#[path = "support/program.rs"]
mod program;
#[path = "../../fmi2-import/tests/support/mod.rs"]
mod support;

use std::process::Command;

use program::{assert_fails, dualarm, text};

#[test]
fn built_in_scenarios_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let list = dualarm(folder.path(), &["simulate", "--list"]);
    assert!(list.status.success());
    for expected in ["nabfc ", "pds ", "pd ", "preload "] {
        assert!(text(&list.stdout).lines().any(|line| line.starts_with(expected)), "{expected}");
    }
}

#[test]
fn completions_know_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = dualarm(folder.path(), &["completions", shell]);
        assert!(script.status.success());
        for word in ["simulate", "info", "controller"] {
            assert!(text(&script.stdout).contains(word), "{word} in {shell}");
        }
        assert!(text(&script.stdout).contains("nabfc-fast"), "scenarios in {shell}");
    }
    assert_fails(&dualarm(folder.path(), &["completions", "basic"]), 2, "possible values: bash");
}

/// Explanations of the examples stand in a column of their own.
#[test]
fn examples_are_aligned() {
    let folder = tempfile::tempdir().unwrap();
    let help = text(&dualarm(folder.path(), &["--help"]).stdout);
    let examples = help.lines().skip_while(|line| *line != "Examples:").skip(1).take_while(|line| !line.is_empty());
    let columns: Vec<_> = examples.map(|line| line.rfind("  ").map(|blanks| blanks + 2)).collect();
    assert!(
        columns.len() > 3 && columns.iter().all(|column| *column == columns[0] && *column > Some(2)),
        "{columns:?}"
    );
    let options = text(&dualarm(folder.path(), &["simulate", "--help"]).stdout);
    assert!(options.find("--quiet") > options.find("--json"), "what every command has comes last");
}

/// Everything fits into a terminal of the usual width.
#[test]
fn help_fits_into_80_columns() {
    let folder = tempfile::tempdir().unwrap();
    for command in [
        "",
        "package",
        "simulate",
        "scenario",
        "compare",
        "report",
        "tune",
        "sweep",
        "verify",
        "info",
        "certify",
        "linearise",
        "completions",
    ] {
        let words: Vec<_> = [command, "--help"].into_iter().filter(|word| !word.is_empty()).collect();
        let help = Command::new(env!("CARGO_BIN_EXE_dualarm"))
            .current_dir(folder.path())
            .env("COLUMNS", "80")
            .args(&words)
            .output()
            .unwrap();
        assert!(help.status.success());
        let said = text(&help.stdout);
        let longest = said.lines().max_by_key(|line| line.chars().count()).unwrap();
        assert!(longest.chars().count() <= 80, "{command}: {longest:?}");
    }
}

#[test]
fn help_shows_examples_and_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let help = dualarm(folder.path(), &["--help"]);
    assert!(help.status.success());
    for expected in ["Examples:", "Exit codes: 0 success, 1", "package", "simulate", "compare"] {
        assert!(text(&help.stdout).contains(expected), "{expected}");
    }
    assert!(text(&dualarm(folder.path(), &["simulate", "--help"]).stdout).contains("--controller <NAME>"));
}
