//! Makes runs in threads of this process, or in worker processes that may crash and hang.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, SyncSender};
use std::sync::{Mutex, PoisonError};
use std::thread;

use super::bench::Bench;
use super::process::Program;
use super::{Row, SweepError};

/// Rows that may wait to be kept: workers do not stop for it, and memory stays flat.
const WAITING: usize = 64;

/// The path of the file with the trajectory of a run.
#[must_use]
pub fn trajectory(folder: &Path, run: u64) -> PathBuf {
    folder.join(format!("run-{run:07}.parquet"))
}

/// Runs to be made, for several takers.
struct Todo<'a>(Mutex<&'a mut (dyn Iterator<Item = u64> + Send)>);

impl Todo<'_> {
    fn next(&self) -> Option<u64> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).next()
    }
}

/// Makes runs in threads of this process; `keep` receives the rows in the order in which they are finished.
///
/// # Errors
/// The error of `keep`.
pub fn in_threads(
    bench: &Bench,
    workers: usize,
    trajectories: Option<&Path>,
    runs: &mut (dyn Iterator<Item = u64> + Send),
    keep: &mut dyn FnMut(Row) -> Result<(), SweepError>,
) -> Result<(), SweepError> {
    many(workers, runs, keep, &|todo, rows| {
        while let Some(run) = todo.next() {
            let file = trajectories.map(|folder| trajectory(folder, run));
            if rows.send(Ok(bench.run(run, file.as_deref()))).is_err() {
                return;
            }
        }
    })
}

/// Makes runs in worker processes.
///
/// # Errors
/// The error of `keep`, or when processes do not start.
pub fn in_processes(
    program: &Program,
    workers: usize,
    runs: &mut (dyn Iterator<Item = u64> + Send),
    keep: &mut dyn FnMut(Row) -> Result<(), SweepError>,
) -> Result<(), SweepError> {
    many(workers, runs, keep, &|todo, rows| {
        let mut worker = None;
        while let Some(run) = todo.next() {
            let row = program.run(&mut worker, run);
            let failed = row.is_err();
            if rows.send(row).is_err() || failed {
                return;
            }
        }
    })
}

type Rows = SyncSender<Result<Row, SweepError>>;

fn many(
    workers: usize,
    runs: &mut (dyn Iterator<Item = u64> + Send),
    keep: &mut dyn FnMut(Row) -> Result<(), SweepError>,
    work: &(dyn Fn(&Todo, &Rows) + Sync),
) -> Result<(), SweepError> {
    let todo = Todo(Mutex::new(runs));
    thread::scope(|scope| {
        let (sender, receiver) = mpsc::sync_channel(WAITING);
        for _ in 0..workers.max(1) {
            let (sender, todo) = (sender.clone(), &todo);
            scope.spawn(move || work(todo, &sender));
        }
        drop(sender);
        // An error drops the receiver, at which workers stop.
        receiver.into_iter().try_for_each(|row| keep(row?))
    })
}
