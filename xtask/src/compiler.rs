//! Programs of tests that do not compute for long are compiled without optimisation.
//!
//! For `cargo test`, a library is compiled twice: as what others use, which has to be fast, and once more with its unit tests. Without
//! optimisation the second takes a third of the time, and so do most programs of `tests/`, but a profile of cargo has one level for
//! all of a package. So cargo calls us as a wrapper of the compiler, and we call the compiler, with another level where a program of
//! tests is compiled. Cargo sees no difference, so all else is shared with every other build. Without us (`cargo test --release`) such a
//! program is optimised, unless it has been compiled already. Its results are the same bits.

use std::env;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::{Command, ExitCode};

/// Crates whose tests compute or call for seconds, some under valgrind.
const OPTIMISED: [&str; 9] =
    ["blobs", "grasp_certify", "grasp_plant", "laws", "life", "loading", "plant", "random_calls", "requirements"];

/// Lets cargo call us in place of the compiler, unless the user has named a wrapper or a compiler.
pub fn wrap(cargo: &mut Command) {
    let is_named = ["RUSTC", "RUSTC_WRAPPER"].iter().any(|name| env::var_os(name).is_some());
    if let Ok(program) = env::current_exe()
        && !is_named
    {
        cargo.arg("--config").arg(format!("build.rustc-wrapper={:?}", program.display().to_string()));
    }
}

/// Does what cargo wants of the compiler, if that is why we were started.
pub fn called() -> Option<ExitCode> {
    let mut arguments = env::args_os().skip(1);
    let compiler = arguments.next().filter(|program| is_compiler(program))?;
    let mut arguments: Vec<OsString> = arguments.collect();
    if is_quick_test(&arguments) {
        without_optimisation(&mut arguments);
    }
    Some(match Command::new(&compiler).args(arguments).status() {
        Ok(status) => status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from),
        Err(error) => {
            eprintln!("cannot start {}: {error}", compiler.display());
            ExitCode::FAILURE
        }
    })
}

/// A wrapper's first argument is the compiler; ours would be the name of a command.
fn is_compiler(program: &OsStr) -> bool {
    Path::new(program).file_stem().is_some_and(|name| name == "rustc")
}

fn is_quick_test(arguments: &[OsString]) -> bool {
    let name = arguments.iter().skip_while(|argument| *argument != "--crate-name").nth(1);
    arguments.iter().any(|argument| argument == "--test")
        && !OPTIMISED.iter().any(|long| name.is_some_and(|name| name == long))
}

fn without_optimisation(arguments: &mut [OsString]) {
    for argument in arguments {
        if argument.to_str().is_some_and(|argument| argument.starts_with("opt-level=")) {
            *argument = "opt-level=0".into();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn arguments(text: &str) -> Vec<OsString> {
        text.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn only_programs_of_tests_are_not_optimised_and_none_that_computes_for_long() {
        assert!(is_quick_test(&arguments("--crate-name charts src/lib.rs --test -C opt-level=3")));
        assert!(!is_quick_test(&arguments("--crate-name charts src/lib.rs --crate-type lib -C opt-level=3")));
        assert!(!is_quick_test(&arguments("--crate-name plant tests/main.rs --test -C opt-level=3")));
        assert!(!is_quick_test(&arguments("-vV")));
    }

    #[test]
    fn only_the_level_changes() {
        let mut changed = arguments("--test -C opt-level=3 -C overflow-checks=on");
        without_optimisation(&mut changed);
        assert_eq!(changed, arguments("--test -C opt-level=0 -C overflow-checks=on"));
    }

    #[test]
    fn a_command_of_ours_is_no_compiler() {
        assert!(is_compiler("/a/b/rustc".as_ref()) && is_compiler("rustc.exe".as_ref()));
        assert!(!["test", "check", "--help"].iter().any(|command| is_compiler(command.as_ref())));
    }

    /// A name that no crate has would mean that what had it is not optimised any more.
    #[test]
    fn what_is_named_is_there() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let packages: Vec<_> = fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()).collect();
        for name in OPTIMISED {
            let is_there = packages.iter().any(|package| {
                let tests = package.join("tests");
                let manifest = fs::read_to_string(package.join("Cargo.toml")).unwrap_or_default();
                manifest.contains(&format!("name = \"{name}\""))
                    || package.ends_with(name.replace('_', "-"))
                    || tests.join(name).join("main.rs").is_file()
                    || tests.join(name).with_extension("rs").is_file()
            });
            assert!(is_there, "{name}");
        }
    }
}
