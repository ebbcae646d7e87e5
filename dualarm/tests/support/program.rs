//! The program as tests run it, in a folder with two small FMUs.
#![allow(dead_code)] // every test file uses a part

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

use crate::support::package;

/// A folder with `Lag.fmu` and `Gain.fmu`.
pub fn fixtures() -> Option<TempDir> {
    let folder = tempfile::tempdir().unwrap();
    package(folder.path(), "Lag")?;
    package(folder.path(), "Gain")?;
    Some(folder)
}

pub fn dualarm(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dualarm")).current_dir(folder).args(arguments).output().unwrap()
}

/// Runs the loop of `Lag` and `Gain` with more arguments.
pub fn simulate(folder: &Path, arguments: &[&str]) -> Output {
    dualarm(folder, &[&["simulate", "Lag.fmu", "Gain.fmu"], arguments].concat())
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

pub fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[track_caller]
pub fn assert_fails(output: &Output, code: i32, expected: &str) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(message.contains(expected), "{message:?} should contain {expected:?}");
    assert_eq!(message.matches("error:").count(), 1, "one message: {message:?}");
    assert!(output.stdout.is_empty(), "nothing on standard output");
}
