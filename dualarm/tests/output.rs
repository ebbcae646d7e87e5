//! What a command writes is whole or not there, and a place that takes nothing is named.

#[path = "support/program.rs"]
mod program;
#[path = "../../fmi2-import/tests/support/mod.rs"]
mod support;

use std::fs;
use std::process::{Command, Stdio};

use program::{assert_fails, dualarm, files, fixtures, simulate, text};

#[test]
fn failing_runs_leave_no_output() {
    let Some(folder) = fixtures() else { return };
    let before = files(folder.path());
    let run = |setting: &str| simulate(folder.path(), &["--set", setting, "--set", "trouble=error", "-o", "out.csv"]);
    assert_fails(&run("trouble_at=1"), 1, "at t = 1 s: Lag: fmi2DoStep returned fmi2Error: trouble at t = 1");
    assert_eq!(files(folder.path()), before);

    let warned = simulate(folder.path(), &["--set", "Lag.trouble_at=1.85", "--set", "trouble=warning"]);
    assert!(warned.status.success());
    assert!(text(&warned.stderr).contains("warning: Lag: trouble at t = 1.8"), "{}", text(&warned.stderr));
}

#[cfg(target_os = "linux")]
#[test]
fn results_that_standard_output_does_not_take_are_a_failure() {
    let Some(folder) = fixtures() else { return };
    let runs: [&[&str]; 6] = [
        &["info", "Lag.fmu"],
        &["simulate", "--list"],
        &["completions", "bash"],
        &["--help"],
        &["help", "compare"],
        &["--version"],
    ];
    for arguments in runs {
        let mut command = Command::new(env!("CARGO_BIN_EXE_dualarm"));
        command.args(arguments).current_dir(folder.path()).stdout(fs::File::create("/dev/full").unwrap());
        let output = command.output().unwrap();
        assert_fails(&output, 1, "cannot write to standard output: No space left on device");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn unwritable_places_are_named() {
    let Some(folder) = fixtures() else { return };
    fs::create_dir(folder.path().join("taken.csv")).unwrap();
    let before = files(folder.path());
    let run = |path: &str| simulate(folder.path(), &["-o", path]);
    assert_fails(&run("taken.csv"), 1, "cannot write taken.csv: it is a folder");
    assert_fails(&run("Lag.fmu/out.csv"), 1, "cannot write Lag.fmu/out.csv:");
    assert_fails(&run("/proc/out.csv"), 1, "cannot write /proc/out.csv:");
    assert_fails(&run("/dev/full"), 1, "cannot write /dev/full: No space left on device");
    assert_eq!(files(folder.path()), before);

    let compare = dualarm(folder.path(), &["compare", "--no-package", "--step", "0"]);
    assert_fails(&compare, 2, "step size must be a positive number");
    let compare = dualarm(folder.path(), &["compare", "--no-package", "--step", "10"]);
    assert_fails(&compare, 2, "a step of 10 s is longer than the run from 0 s to 8 s");
    let compare = dualarm(folder.path(), &["compare", "--no-package"]);
    assert_fails(&compare, 1, "cannot read dist/DualArmPlant.fmu:");
    assert_fails(&compare, 1, "`dualarm package` makes the FMUs, --fmus says where they are");
    assert_eq!(files(folder.path()), before);
}

/// The format follows the extension; that others can read it is for `tests/test_tool.py` to see.
#[test]
fn parquet_files_are_whole_or_not_there() {
    let Some(folder) = fixtures() else { return };
    let before = files(folder.path());
    let failed = simulate(folder.path(), &["-o", "out.parquet", "--set", "Lag.trouble_at=1"]);
    assert_fails(&failed, 1, "at t = 1 s");
    assert_eq!(files(folder.path()), before);
    assert!(simulate(folder.path(), &["-o", "new/out.PARQUET"]).status.success());
    let bytes = fs::read(folder.path().join("new/out.PARQUET")).unwrap();
    assert_eq!((&bytes[..4], &bytes[bytes.len() - 4..]), (&b"PAR1"[..], &b"PAR1"[..]));
    #[cfg(target_os = "linux")]
    assert_fails(&simulate(folder.path(), &["-o", "/proc/out.parquet"]), 1, "cannot write /proc/out.parquet:");
}

/// `dualarm … | head`: no panic, whichever stream the reader closes.
#[test]
fn readers_may_leave() {
    let Some(folder) = fixtures() else { return };
    let runs: [&[&str]; 4] =
        [&["completions", "bash"], &["simulate", "Lag.fmu", "Lag.fmu"], &["simulate", "--list"], &["simulate", "x"]];
    for arguments in runs {
        let mut child = Command::new(env!("CARGO_BIN_EXE_dualarm"))
            .current_dir(folder.path())
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop((child.stdout.take(), child.stderr.take()));
        let expected = if arguments == ["simulate", "x"] { 2 } else { 0 };
        assert_eq!(child.wait().unwrap().code(), Some(expected), "{arguments:?}");
    }
}
