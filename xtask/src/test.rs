//! `cargo xtask test`: all tests, or only the Rust or the Python ones.
//!
//! What needs no result of a step runs beside it: neither the compiler nor the tests keep all processors busy. Results are reported
//! in the order of the headings.

use std::process::ExitCode;
use std::sync::mpsc::channel;

use crate::beside::{Action, Beside};
use crate::cli::Test;
use crate::steps::{Outcome, Runner, run};
use crate::tree::Tree;
use crate::{checks, counts, fuzz, helpers, long, packaging, platforms, publish, python};

const PACKAGING: &str = "Build and package the FMUs";
const ENVIRONMENT: &str = "Python environment";
const JUDGE: &str = "Judge in Rust";
const HELPERS: &str = "Helper programs";

type Check = fn(&Tree) -> Outcome;

/// What runs beside the Rust and the Python tests, in this order. The helpers, which the Python tests wait for, come first. The
/// published crates follow: they replace examples that the long checks, the counts and the Rust tests load, and wait for all of these.
const BESIDE: [(&str, Check); 6] = [
    (HELPERS, helpers::build),
    ("Long checks", long::checks),
    ("Instruction counts", counts::check),
    (checks::FORMATTING, checks::formatting),
    (checks::LINTS, checks::lints),
    (checks::DOCUMENTATION, checks::documentation),
];

/// Runs the steps.
pub fn all(tree: &Tree, what: &Test) -> ExitCode {
    match (what.rust, what.python) {
        (true, _) => rust(tree),
        (_, true) => python(tree, what),
        _ => everything(tree, what),
    }
}

/// `cargo xtask test --rust`.
fn rust(tree: &Tree) -> ExitCode {
    let mut steps = Runner::new(2);
    // Packaging comes first, because the Rust tests attack the FMUs' libraries too; old libraries would be attacked for
    // faults that are fixed.
    steps.step(PACKAGING, || packaging::package(tree, true));
    steps.step("Rust tests", || rust_tests(tree));
    steps.finish()
}

/// `cargo xtask test --python`.
fn python(tree: &Tree, what: &Test) -> ExitCode {
    let mut steps = Runner::new(5);
    let environment = environment(tree);
    steps.step(PACKAGING, || packaging::package(tree, false));
    steps.step(HELPERS, || helpers::build(tree));
    steps.end(&environment, ENVIRONMENT);
    steps.end(&environment, JUDGE);
    steps.step("Python tests", || run(python::pytest(tree, &what.pytest_args)));
    steps.finish()
}

/// `cargo xtask test`.
fn everything(tree: &Tree, what: &Test) -> ExitCode {
    let platforms = if what.all_platforms { platforms::COUNT } else { 1 };
    let mut steps = Runner::new(6 + BESIDE.len() + 1 + platforms + 1);
    let environment = environment(tree);
    steps.step(PACKAGING, || packaging::package(tree, true));
    let (rust_tests_run, rust_tests_ended) = channel::<()>();
    let mut actions: Vec<Action> = BESIDE.map(|(_, run)| action(tree, run)).into();
    let published = action(tree, publish::check);
    actions.push(Box::new(move || {
        // An error says that nobody will tell any more: they have ended, or do not begin.
        let _ = rust_tests_ended.recv();
        published()
    }));
    let beside = Beside::begin(if steps.failed() { Vec::new() } else { actions });
    steps.step("Rust tests", || rust_tests(tree));
    drop(rust_tests_run);
    steps.end(&environment, ENVIRONMENT);
    steps.end(&environment, JUDGE);
    let actionlint = checks::Fetched::start(tree);
    let [(helpers, _), others @ ..] = BESIDE;
    steps.end(&beside, helpers);
    steps.step("Python tests", || run(python::pytest(tree, &what.pytest_args)));
    steps.step("Fuzz targets", || fuzz::run_targets(tree));
    if what.all_platforms {
        platforms::add(&mut steps, tree);
    } else {
        steps.step("Other platforms", || Outcome::Skipped(platforms::NOT_CHECKED.into()));
    }
    // The code checks come last: a lint of a newer clippy must not hide the results of the tests.
    for (name, _) in others {
        steps.end(&beside, name);
    }
    steps.end(&beside, publish::STEP);
    checks::workflows(&mut steps, actionlint);
    steps.finish()
}

fn rust_tests(tree: &Tree) -> Outcome {
    let mut command = tree.cargo_all("test", &[]);
    packaging::attack_libraries(tree, &mut command);
    run(command)
}

/// The Python environment and the judge, which the FMUs don't matter to.
fn environment(tree: &Tree) -> Beside {
    Beside::begin(vec![action(tree, python::prepare), action(tree, helpers::judge)])
}

fn action(tree: &Tree, run: Check) -> Action {
    let tree = tree.clone();
    Box::new(move || run(&tree))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    fn sources(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
        entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
    }

    /// Where the files of `tests/` are one program, cargo would not say that it leaves one of them out.
    #[test]
    fn no_test_file_is_left_out() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let mut looked_at = 0;
        for folder in fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()) {
            let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
            if !manifest.lines().any(|line| line == "autotests = false") {
                continue;
            }
            let tests = folder.join("tests");
            let modules = fs::read_to_string(tests.join("main.rs")).unwrap();
            for entry in fs::read_dir(&tests).unwrap().map(|entry| entry.unwrap().path()) {
                let name = entry.file_stem().unwrap().to_str().unwrap();
                let has_tests = |file: &PathBuf| fs::read_to_string(file).is_ok_and(|text| text.contains("#[test]"));
                if name != "main" && (entry.is_file() || sources(&entry).iter().any(has_tests)) {
                    let is_there = modules.lines().any(|line| line == format!("mod {name};"))
                        || manifest.contains(&format!("path = \"tests/{name}"));
                    assert!(is_there, "{} is no part of a program", entry.display());
                    looked_at += 1;
                }
            }
        }
        assert!(looked_at > 10, "{looked_at}");
    }

    /// What is not compiled for tests has none: with `test = false`, cargo would not say that it leaves them out.
    #[test]
    fn no_test_is_left_out() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let mut without = Vec::new();
        for folder in fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()) {
            let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
            let section = |head: &str| manifest.split(head).nth(1).and_then(|text| text.split("\n[").next());
            let silent = |head: &str| section(head).is_some_and(|text| text.lines().any(|line| line == "test = false"));
            let (library, program) = (silent("\n[lib]\n"), silent("\n[[bin]]\n"));
            for file in sources(&folder.join("src")) {
                let is_program = file == folder.join("src").join("main.rs");
                if if is_program { program } else { library } {
                    let text = fs::read_to_string(&file).unwrap();
                    assert!(!text.contains("#[test]") && !text.contains("cfg(test)"), "{} has tests", file.display());
                    without.push(file);
                }
            }
        }
        assert!(without.iter().any(|file| file.ends_with("plant-fmu/src/lib.rs")), "{without:?}");
        assert!(without.iter().any(|file| file.ends_with("dualarm/src/main.rs")), "{without:?}");
    }
}
