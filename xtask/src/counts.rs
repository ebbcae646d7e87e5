//! Instruction counts of a communication step: a measure of its cost that is the same in every run. They are compared with
//! a history.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use chrono::{DateTime, Utc};

use crate::output;
use crate::steps::Outcome;
use crate::tree::Tree;

/// The cases of `step_cost`, [`SIMULATE`] and [`INTEGRATOR`]: the columns of the history.
const CASES: [&str; 11] =
    ["plant", "nabfc", "pds", "pd", "coupled", "master", SIMULATE, "get_first", "nabfc-r", INTEGRATOR, "coupled-r"];

/// A model that computes next to nothing, by `call_cost` of fmi2-export: what the C interface costs.
const INTEGRATOR: &str = "integrator";

/// `dualarm simulate` of the paper's case without an output file.
const SIMULATE: &str = "simulate";

/// Two lengths of that run, in steps of 0.1 ms. Their difference leaves out what the program does before and after the steps.
const LENGTHS: [u64; 2] = [1000, 3000];

/// How much more a step may cost than the last time it was recorded.
const ALLOWED: f64 = 1.05;

const HISTORY: &str = "docs/performance/instructions.csv";

/// One line of the history.
struct Entry {
    date: String,
    /// A note for readers: the reason of the change.
    note: String,
    counts: [u64; CASES.len()],
}

/// Counts, and compares with the last entry of the history.
pub fn check(tree: &Tree) -> Outcome {
    let counts = match counts(tree) {
        Ok(counts) => counts,
        Err(outcome) => return outcome,
    };
    let history = fs::read_to_string(tree.root.join(HISTORY)).map_err(|error| error.to_string());
    match history.and_then(|text| last(&text)) {
        Ok(last) => compare(&last, &counts),
        Err(reason) => Outcome::Failed(format!("{HISTORY}: {reason}")),
    }
}

/// Counts, and adds an entry to the history.
pub fn record(tree: &Tree, note: &str) -> Outcome {
    let counts = match counts(tree) {
        Ok(counts) => counts,
        Err(Outcome::Skipped(reason)) => return Outcome::Failed(reason),
        Err(outcome) => return outcome,
    };
    let path = tree.root.join(HISTORY);
    let appended = fs::read_to_string(&path).map_err(|error| error.to_string()).and_then(|mut text| {
        let numbers = counts.map(|count| count.to_string()).join(",");
        writeln!(text, "{},{},{numbers}", today(), note.replace(['\n', ','], " "))
            .map_err(|error| error.to_string())?;
        fs::write(&path, text).map_err(|error| error.to_string())
    });
    match appended {
        Ok(()) => Outcome::Passed,
        Err(reason) => Outcome::Failed(format!("{HISTORY}: {reason}")),
    }
}

/// Instructions per step of each case, or the outcome of the check if they cannot be counted.
fn counts(tree: &Tree) -> Result<[u64; CASES.len()], Outcome> {
    if !(cfg!(target_os = "linux") && cfg!(target_arch = "x86_64")) {
        return Err(Outcome::Skipped("the history is of Linux on x86-64".into()));
    }
    if !Command::new("valgrind").arg("--version").output().is_ok_and(|output| output.status.success()) {
        return Err(Outcome::Skipped("valgrind is not installed".into()));
    }
    let programs = ["--example", "step_cost", "--example", "call_cost", "--bin", "dualarm"];
    let library = ["build", "--quiet", "--package", "counted-models", "--profile", "fmu"];
    for build in [tree.cargo_all("build", &programs), tree.cargo(&library)] {
        let build = crate::steps::run(build);
        if build != Outcome::Passed {
            return Err(build);
        }
    }
    // What the times are compared with must still be the same algorithm.
    let mut same = Command::new(tree.target.join("release").join("examples").join("step_cost"));
    same.arg("same").arg(tree.root.join("dist"));
    let same = crate::steps::run(same);
    if same != Outcome::Passed {
        return Err(same);
    }
    let mut all = [0; CASES.len()];
    for (count, case) in all.iter_mut().zip(CASES) {
        let counted = if case == SIMULATE { simulated(tree) } else { counted(tree, case) };
        *count = counted.map_err(|reason| Outcome::Failed(format!("{case}: {reason}")))?;
        output::line(&format!("{case:<10} {count:>8} instructions per step"));
    }
    Ok(all)
}

fn counted(tree: &Tree, case: &str) -> Result<u64, String> {
    let program = if case == INTEGRATOR { "call_cost" } else { "step_cost" };
    let program = tree.target.join("release").join("examples").join(program);
    let file: PathBuf = tree.target.join(format!("callgrind-{case}.out"));
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--toggle-collect=step_cost_counted*"])
        .arg(format!("--callgrind-out-file={}", file.display()))
        .arg(&program)
        .args(["count", case])
        .arg(tree.root.join("dist"))
        .output()
        .map_err(|error| format!("valgrind did not start: {error}"))?;
    let said = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).trim().to_owned());
    }
    let steps: u64 =
        said.trim().parse().map_err(|_| format!("it printed `{}` for the number of steps", said.trim()))?;
    let total = total(&file)?;
    Ok((total + steps / 2) / steps)
}

/// Instructions per step of `dualarm simulate`.
fn simulated(tree: &Tree) -> Result<u64, String> {
    let [short, long] = LENGTHS.map(|steps| run(tree, steps));
    let steps = LENGTHS[1] - LENGTHS[0];
    Ok((long?.saturating_sub(short?) + steps / 2) / steps)
}

/// Instructions of a run of so many steps, those of the process that watches included.
fn run(tree: &Tree, steps: u64) -> Result<u64, String> {
    // A file for each process.
    let folder = tree.target.join("callgrind-simulate");
    let _ = fs::remove_dir_all(&folder);
    let no_folder = |error| format!("{}: {error}", folder.display());
    fs::create_dir_all(&folder).map_err(no_folder)?;
    let output = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg(format!("--callgrind-out-file={}", folder.join("%p").display()))
        .arg(tree.program("dualarm"))
        .args(["simulate", "nabfc", "--quiet", "--step", "1e-4", "--stop", &format!("{}", steps as f64 * 1e-4)])
        .arg("--fmus")
        .arg(tree.root.join("dist"))
        .output()
        .map_err(|error| format!("valgrind did not start: {error}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).trim().to_owned());
    }
    let files = fs::read_dir(&folder).map_err(no_folder)?;
    let files: Vec<PathBuf> = files.filter_map(|file| Some(file.ok()?.path())).collect();
    files.iter().map(|file| total(file)).sum()
}

/// The total of a callgrind file.
fn total(file: &Path) -> Result<u64, String> {
    let text = fs::read_to_string(file).map_err(|error| format!("callgrind's file: {error}"))?;
    let total =
        text.lines().filter_map(|line| line.strip_prefix("totals:").or(line.strip_prefix("summary:"))).next_back();
    let total = total.and_then(|number| number.trim().parse().ok()).filter(|total| *total > 0);
    total.ok_or_else(|| "callgrind counted nothing".into())
}

/// The last entry of the history.
fn last(history: &str) -> Result<Entry, String> {
    let line = history.lines().skip(1).filter(|line| !line.trim().is_empty()).last().ok_or("it has no entry")?;
    let fields: Vec<&str> = line.split(',').collect();
    let [date, note, numbers @ ..] = fields.as_slice() else { return Err(format!("`{line}` is no entry")) };
    let numbers: Vec<u64> = numbers.iter().filter_map(|field| field.trim().parse().ok()).collect();
    let counts = numbers.try_into().map_err(|_| format!("`{line}` does not have {} counts", CASES.len()))?;
    Ok(Entry { date: (*date).into(), note: (*note).into(), counts })
}

fn compare(last: &Entry, counts: &[u64; CASES.len()]) -> Outcome {
    let mut risen = Vec::new();
    for ((case, old), new) in CASES.iter().zip(last.counts).zip(*counts) {
        let ratio = new as f64 / old as f64;
        if ratio > ALLOWED {
            risen.push(format!("{case} from {old} to {new} ({:+.1} %)", (ratio - 1.0) * 100.0));
        }
    }
    if risen.is_empty() {
        output::line(&format!("none is more than 5 % above the entry of {} ({})", last.date, last.note));
        return Outcome::Passed;
    }
    Outcome::Failed(format!(
        "a step costs more instructions than on {}: {}. If that is meant: `cargo xtask counts --record \"why\"`",
        last.date,
        risen.join(", ")
    ))
}

/// Today's date (UTC) as year-month-day.
fn today() -> String {
    DateTime::<Utc>::from(SystemTime::now()).format("%F").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HISTORY: &str = "date,note,plant\n2026-01-01,first,1,2,3,4,5,6,,,,\n2026-01-02,second,100,200,300,400,500,600,700,800,900,1000,1100\n";

    #[test]
    fn the_last_entry_is_the_standard() {
        let last = last(HISTORY).unwrap();
        assert_eq!((last.date.as_str(), last.note.as_str()), ("2026-01-02", "second"));
        assert_eq!(compare(&last, &[105, 210, 315, 420, 525, 630, 735, 840, 945, 1050, 1155]), Outcome::Passed);
        let Outcome::Failed(reason) = compare(&last, &[100, 211, 0, 0, 0, 0, 0, 0, 0, 0, 0]) else {
            panic!("211 is too many")
        };
        assert!(reason.contains("nabfc from 200 to 211 (+5.5 %)"), "{reason}");
    }

    #[test]
    fn a_damaged_history_is_refused() {
        for text in ["", "date\n", "date\n2026-01-01,note,1,2\n", "date\n2026-01-01,note,1,2,3,4,5,6,7,8,9,10,x\n"] {
            assert!(super::last(text).is_err(), "{text:?}");
        }
    }
}
