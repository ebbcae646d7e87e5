//! The first step of the tests: packages the FMUs. The links of their libraries use one processor for most of a minute; meanwhile
//! the other processors compile the Rust tests.

use std::fs::{File, TryLockError};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::output;
use crate::steps::{Outcome, run};
use crate::tree::Tree;

/// How often is looked whether cargo has begun with the libraries.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// Packages the FMUs with their cross-check folders, and compiles the `rust` tests if they are wanted: those that do not
/// compile fail again in their own step.
pub fn package(tree: &Tree, rust: bool) -> Outcome {
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        if rust {
            scope.spawn(|| compile_tests(tree, &done));
        }
        let packaged = run(tree.cargo(&["run", "--release", "--", "package", "--cross-check"]));
        done.store(true, Ordering::Relaxed);
        packaged
    })
}

/// The libraries of the packaged FMUs, as examples of the crate `fmu-libraries`.
const LIBRARIES: [&str; 3] = ["plant_fmu", "controller_fmu", "instruments_fmu"];

/// Tells tests of the C interface to attack the FMUs' libraries too. They lie elsewhere if zig has linked them; then a line says
/// that they are not attacked.
pub fn attack_libraries(tree: &Tree, tests: &mut Command) {
    let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let folder = tree.target.join("fmu").join("examples");
    let files = LIBRARIES.map(|name| folder.join(format!("{prefix}{name}{suffix}")));
    match std::env::join_paths(&files) {
        Ok(list) if files.iter().all(|file| file.is_file()) => {
            tests.env("FMU_LIBRARIES", list);
        }
        _ => output::line(&format!("not checked: the FMUs' libraries, which are not in {}", folder.display())),
    }
}

/// Compiles the tests as soon as cargo builds the libraries, which have a separate build folder. Before that, cargo needs
/// the folder of the tests itself.
fn compile_tests(tree: &Tree, done: &AtomicBool) {
    let lock = tree.target.join("fmu").join(".cargo-lock");
    let is_building = || {
        let file = File::open(&lock);
        file.is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
    };
    while !done.load(Ordering::Relaxed) {
        if is_building() {
            let mut command = tree.cargo_all("test", &["--no-run", "--quiet"]);
            command.stdout(Stdio::null()).stderr(Stdio::null());
            // Errors are reported when the tests are run.
            let _ = command.status();
            return;
        }
        thread::sleep(LOOK_EVERY);
    }
}
