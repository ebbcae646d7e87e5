//! The same calls, and other tests, under tools that watch the memory.

use std::collections::VecDeque;
use std::process::Command;
use std::sync::Mutex;

use crate::common::real::{EXAMPLES, libraries};
use crate::{CALLS, SEED, variable};

/// Cargo, for test programs of this crate with other tools.
fn cargo(arguments: &[&str], variables: &[(&str, &str)]) -> Command {
    let mut command = Command::new("cargo");
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).envs(variables.iter().copied());
    // Without what the toolchain that runs this test says to its children.
    let own = ["RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN", "CARGO"];
    for name in own {
        command.env_remove(name);
    }
    command
}

/// Runs commands as many at a time as there are processors, the first ones first; what each says is printed when it ends.
fn run(commands: Vec<Command>) {
    let waiting = Mutex::new(VecDeque::from(commands));
    let next = || waiting.lock().unwrap().pop_front();
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(mut command) = next() {
                    let output = command.output().unwrap();
                    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
                    println!("{command:?}\n{}{}", text(&output.stdout), text(&output.stderr));
                    assert!(output.status.success(), "{command:?}");
                }
            });
        }
    });
}

fn works(program: &str, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
}

#[test]
#[ignore = "needs valgrind and some minutes: see the top of main.rs"]
fn all_calls_under_valgrind() {
    if !works("valgrind", &["--version"]) {
        println!("NOT CHECKED: uses of freed, foreign or uninitialised memory, and leaks; valgrind is not installed");
        return;
    }
    let runner = "target.'cfg(all())'.runner = ['valgrind', '--quiet', '--error-exitcode=9', '--leak-check=full', \
                  '--show-leak-kinds=definite', '--errors-for-leak-kinds=definite']";
    // Of the whole workspace, where this crate is part of one: then nothing is compiled anew.
    let all = ["--release", "--workspace", "--all-features"];
    let examples = EXAMPLES.iter().flat_map(|name| ["--example", name]);
    run(vec![cargo(&["build"].into_iter().chain(all).chain(examples).collect::<Vec<_>>(), &[])]);
    let test = |name: &str, variables: &[(&str, &str)]| {
        cargo(&[&["test"], &all[..], &["--config", runner, "--test", name]].concat(), variables)
    };
    // The random calls take longest: in two parts, which begin at different places.
    let calls = (variable("FMI2_CALLS", CALLS) / 2).to_string();
    let seed = variable("FMI2_SEED", SEED);
    let parts = [seed, seed + 1000].map(|seed| seed.to_string());
    let random = parts.iter().map(|seed| test("random_calls", &[("FMI2_CALLS", &calls), ("FMI2_SEED", seed)]));
    let others = TESTS.iter().filter(|name| **name != "random_calls").map(|name| test(name, &[("FMI2_BLOBS", "300")]));
    run(random.chain(others).collect());
}

#[test]
#[ignore = "needs a nightly toolchain, and compiles everything: see the top of main.rs"]
fn all_calls_under_address_sanitizer() {
    if !works("cargo", &["+nightly", "--version"]) {
        println!("NOT CHECKED: memory errors on the stack; there is no nightly toolchain");
        return;
    }
    let host = Command::new("rustc").args(["+nightly", "--print", "host-tuple"]).output().unwrap();
    let host = String::from_utf8(host.stdout).unwrap();
    let target = ["--target", host.trim(), "--target-dir", concat!(env!("CARGO_TARGET_TMPDIR"), "/sanitizer")];
    let tests = TESTS.iter().flat_map(|test| ["--test", test]);
    // The real FMUs are not compiled with it: of what they do, it sees the heap.
    let real = std::env::join_paths(libraries()).unwrap().into_string().unwrap();
    let variables =
        [("RUSTFLAGS", "-Zsanitizer=address -Clink-arg=-Wl,--export-dynamic"), ("FMU_LIBRARIES", real.as_str())];
    for command in [
        vec!["+nightly", "build", "--release", "--examples"],
        ["+nightly", "test", "--release"].into_iter().chain(tests).collect(),
    ] {
        let arguments: Vec<&str> = command.into_iter().chain(target).collect();
        run(vec![cargo(&arguments, &variables)]);
    }
}

/// What is run under these tools.
const TESTS: [&str; 5] = ["state_table", "misuse", "failures", "blobs", "random_calls"];
