//! `dualarm sweep`

mod arguments;
mod outcome;
mod worker;

use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub use arguments::Arguments;
use indicatif::ProgressStyle;

use super::progress::Progress;
use super::report::check as check_page;
use super::{Failure, print, print_error};
use crate::grasp::matrix as cells;
use crate::report::study as report;
use crate::sweep::bench::Bench;
use crate::sweep::journal::Journal;
use crate::sweep::plan::Plan;
use crate::sweep::pool;
use crate::sweep::process::{Program, Ready};
use crate::sweep::summary::Summary;
use crate::sweep::table::{Layout, Results};
use crate::sweep::{Row, Status, SweepError};
use fmi2_cosim::files;

/// Where runs are made: in threads or in worker processes.
enum Workshop {
    Threads(Box<Bench>),
    Processes(Program),
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    if arguments.worker {
        return worker::serve(arguments);
    }
    if let Some(run) = arguments.run {
        return again(arguments, run, quiet);
    }
    let begin = Instant::now();
    let limit = arguments.limit()?;
    let output = arguments.output.clone().unwrap_or_else(|| arguments.default_output(".parquet"));
    check_format(&output)?;
    let plan = arguments.plan()?;
    let (workshop, ready) = workshop(arguments, &plan, limit)?;
    check_overwriting(&output, arguments, &ready.files)?;
    if let Some(page) = &arguments.report {
        check_page(page, &ready.files)?;
        check_page(page, std::slice::from_ref(&arguments.study))?;
    }
    let chosen = chosen(arguments, &plan)?;
    let state = arguments.state.clone().unwrap_or_else(|| output.with_extension("jsonl"));
    let mut journal = Journal::open(&state, &ready.fingerprint, plan.runs().end)?;
    let done = simulate(arguments, &workshop, &chosen, &mut journal, quiet)?;
    drop(workshop);

    let layout = Layout::new(&plan, &ready.figures);
    let titles: Vec<&str> = plan.contenders.iter().map(|contender| contender.title.as_str()).collect();
    let mut summary = Summary::new(&titles, &ready.figures);
    let mut results = Results::new(&output, layout.columns())?;
    let mut page = report::Rows::new(chosen.end - chosen.start);
    for run in chosen.clone() {
        let row = journal.row(run)?;
        summary.add(plan.entrant(run), &row, &layout);
        let fields = layout.fields(&row);
        if arguments.report.is_some() {
            page.add(run - chosen.start, &fields);
        }
        results.add(fields)?;
    }
    results.finish()?;
    let groups = summary.finish();
    if let Some(file) = &arguments.report {
        let html = report::html(&report::Page {
            plan: &plan,
            layout: &layout,
            rows: &page,
            groups: &groups,
            command: &shell(&arguments.options()),
        });
        files::write(file, html)?;
    }
    let outcome = outcome::Outcome {
        plan: &plan,
        groups: &groups,
        output: &output,
        state: &state,
        report: arguments.report.as_deref(),
        done,
        seconds: begin.elapsed().as_secs_f64(),
    };
    if arguments.json {
        return outcome.print_json();
    }
    if !quiet {
        print(&outcome.text());
    }
    Ok(())
}

/// Opens the FMUs, here or in a first worker process.
fn workshop(arguments: &Arguments, plan: &Plan, limit: Option<Duration>) -> Result<(Workshop, Ready), Failure> {
    let Some(timeout) = limit else {
        let bench = Bench::open(plan.clone(), &arguments.folder.fmus)?;
        let ready = ready(&bench)?;
        return Ok((Workshop::Threads(Box::new(bench)), ready));
    };
    let mut words = arguments.options();
    words.push("--worker".into());
    if let Some(folder) = &arguments.trajectories {
        words.extend(["--trajectories".into(), folder.clone().into()]);
    }
    let file =
        std::env::current_exe().map_err(|error| Failure::failed(format!("cannot find the tool itself: {error}")))?;
    let program = Program { file, arguments: words, timeout };
    let ready = program.start()?.ready.clone();
    Ok((Workshop::Processes(program), ready))
}

/// The facts about a study that a worker reports first.
fn ready(bench: &Bench) -> Result<Ready, SweepError> {
    Ok(Ready {
        fingerprint: bench.fingerprint()?.to_string(),
        runs: bench.plan().runs().end,
        figures: bench.figures(),
        files: bench.files().to_vec(),
    })
}

/// Makes the runs that the journal does not have; returns how many.
fn simulate(
    arguments: &Arguments,
    workshop: &Workshop,
    chosen: &Range<u64>,
    journal: &mut Journal,
    quiet: bool,
) -> Result<u64, Failure> {
    let folder = arguments.trajectories.as_deref();
    // A run that is done, but has no trajectory yet, is done again.
    let has_file = |run: u64| folder.is_none_or(|folder| pool::trajectory(folder, run).is_file());
    let todo: Vec<u64> = chosen.clone().filter(|run| !(journal.has(*run) && has_file(*run))).collect();
    let bar = Progress::new(quiet).bar("runs", todo.len() as u64);
    let style =
        ProgressStyle::with_template("{prefix} {bar:36.cyan/dim} {pos}/{len}  {per_sec}  ready in {eta}  {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("━━─"));
    let mut failed = 0_u64;
    let mut keep = |row: Row| {
        bar.inc(1);
        if !matches!(row.status, Status::Ok | Status::Ended) {
            failed += 1;
            bar.set_message(format!("{failed} failed"));
        }
        journal.add(&row)
    };
    let count = todo.len() as u64;
    let mut runs = todo.into_iter();
    let workers = arguments.workers.unwrap_or_else(cells::workers).max(1);
    match workshop {
        Workshop::Threads(bench) => {
            let only_once = bench.is_only_once();
            if only_once && workers > 1 {
                print_error(
                    "warning: an FMU allows one instance in a process: one run at a time (--isolated: several)\n",
                );
            }
            pool::in_threads(bench, if only_once { 1 } else { workers }, folder, &mut runs, &mut keep)?;
        }
        Workshop::Processes(program) => pool::in_processes(program, workers, &mut runs, &mut keep)?,
    }
    bar.finish_and_clear();
    Ok(count)
}

/// `--run`
fn again(arguments: &Arguments, run: u64, quiet: bool) -> Result<(), Failure> {
    let output = arguments.output.clone().unwrap_or_else(|| arguments.default_output(&format!("-run-{run}.parquet")));
    check_format(&output)?;
    let bench = Bench::open(arguments.plan()?, &arguments.folder.fmus)?;
    check_overwriting(&output, arguments, bench.files())?;
    let plan = bench.plan();
    if !plan.runs().contains(&run) {
        return Err(Failure::usage(format!("--run {run}: the study has the runs 0 to {}", plan.runs().end - 1)));
    }
    let row = bench.run(run, Some(&output));
    let layout = Layout::new(plan, &bench.figures());
    if arguments.json {
        return outcome::print_row_json(&layout, &row, &output);
    }
    if !quiet {
        print(&outcome::row_text(&layout, &row));
        if !matches!(row.status, Status::Failed) {
            print(&format!("{}\n", output.display()));
        }
    }
    match (row.status, row.error) {
        (Status::Failed, Some(error)) => Err(Failure::failed(error)),
        _ => Ok(()),
    }
}

/// The selected runs.
fn chosen(arguments: &Arguments, plan: &Plan) -> Result<Range<u64>, Failure> {
    let all = plan.runs();
    match &arguments.runs {
        Some(runs) if runs.end > all.end => {
            let message = format!("--runs {}..{}: the study has the runs 0..{}", runs.start, runs.end, all.end);
            Err(Failure::usage(message))
        }
        Some(runs) => Ok(runs.clone()),
        None => Ok(all),
    }
}

fn check_format(output: &Path) -> Result<(), Failure> {
    let extension = output.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("parquet" | "csv") => Ok(()),
        _ => Err(Failure::usage(format!(
            "-o {}: here -o takes a .parquet or .csv file, for the rows; a page that draws them: --report {}",
            output.display(),
            output.with_extension("html").display()
        ))),
    }
}

fn check_overwriting(output: &Path, arguments: &Arguments, inputs: &[PathBuf]) -> Result<(), Failure> {
    let mut inputs = inputs.iter().map(PathBuf::as_path).chain([arguments.study.as_path()]);
    match inputs.find(|input| files::are_same(input, output)) {
        Some(input) => Err(Failure::usage(format!(
            "-o {} would overwrite {}, which this study reads",
            output.display(),
            input.display()
        ))),
        None => Ok(()),
    }
}

/// Words as a shell takes them.
fn shell(words: &[OsString]) -> String {
    let is_plain = |text: &str| text.chars().all(|c| c.is_ascii_alphanumeric() || "-_./=+:,".contains(c));
    let quoted = |word: &OsString| {
        let text = word.to_string_lossy().into_owned();
        if is_plain(&text) && !text.is_empty() { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
    };
    std::iter::once("dualarm".to_owned()).chain(words.iter().map(quoted)).collect::<Vec<_>>().join(" ")
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        if error.is_usage() { Self::usage(error) } else { Self::failed(error) }
    }
}
