//! `dualarm verify` without FMUs: one clear message, exit code 1, nothing written. With them: `tests/test_verify.py`.

use std::process::Command;

#[test]
fn missing_fmus_are_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_dualarm"))
        .current_dir(folder.path())
        .args(["verify", "--no-package", "--fmus", "nowhere"])
        .output()
        .unwrap();
    let message = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1), "{message}");
    assert!(message.contains("DualArmPlant.fmu"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
