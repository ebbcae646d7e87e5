//! Worker processes: `dualarm sweep STUDY --worker`, with a protocol of JSON lines.
//!
//! A worker first writes `{"ready": …}`, or `{"failure": …}`. Then it answers each line with a run's number by a line with
//! the [`Row`] of the run. It ends when its standard input ends, during a run, too. Dask's workers
//! (`examples/sweep_dask.py`) use the same protocol.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{Row, Status, SweepError};

/// The first message of a worker.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Greeting {
    /// It can be given runs.
    Ready(Ready),
    /// It cannot run this study.
    Failure {
        /// Why.
        message: String,
        /// Whether the request was wrong.
        usage: bool,
    },
}

/// Facts about the study that a worker sends first.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Ready {
    /// The fingerprint of the study: the first line of its journal, word for word.
    pub fingerprint: String,
    /// How many runs it has.
    pub runs: u64,
    /// Names of the figures.
    pub figures: Vec<String>,
    /// The files that are read.
    pub files: Vec<PathBuf>,
}

/// How workers are started.
#[derive(Debug, Clone)]
pub struct Program {
    /// The tool.
    pub file: PathBuf,
    /// Its arguments.
    pub arguments: Vec<std::ffi::OsString>,
    /// How long a run may take.
    pub timeout: Duration,
}

/// A process that makes runs.
pub struct Worker {
    child: Child,
    /// Closed when it shall end.
    input: Option<ChildStdin>,
    lines: Receiver<String>,
    /// The end of its output to standard error.
    said: Arc<Mutex<String>>,
    /// Tells when that is all.
    silent: Receiver<()>,
    /// Its first message.
    pub ready: Ready,
}

/// Why a worker does not answer.
enum Silence {
    Ended(String),
    TooLong,
}

impl Program {
    /// How often a process is started for one run before that is given up.
    const STARTS: usize = 3;
    /// Time to load FMUs, which is no run's.
    const TIME_TO_START: Duration = Duration::from_secs(120);

    /// Starts a worker.
    ///
    /// # Errors
    /// When it does not start, or cannot run the study.
    pub fn start(&self) -> Result<Worker, SweepError> {
        let failure = |reason: String| SweepError::Worker(reason);
        let mut command = Command::new(&self.file);
        command.args(&self.arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Unpacked files of a process that crashes are removed with the folder of this process.
        command.env(if cfg!(windows) { "TMP" } else { "TMPDIR" }, tempfile::env::temp_dir());
        let mut child = command.spawn().map_err(|error| failure(format!("cannot be started: {error}")))?;
        let (Some(input), Some(output), Some(errors)) = (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            return Err(failure("has no pipes".into()));
        };
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || {
            for line in BufReader::new(output).lines() {
                let Ok(line) = line else { return };
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        let said = Arc::new(Mutex::new(String::new()));
        let kept = Arc::clone(&said);
        let (fell_silent, silent) = mpsc::channel();
        thread::spawn(move || {
            keep_end(errors, &kept);
            let _ = fell_silent.send(());
        });
        let nothing = Ready { fingerprint: String::new(), runs: 0, figures: Vec::new(), files: Vec::new() };
        let mut worker = Worker { child, input: Some(input), lines, said, silent, ready: nothing };
        let line = match worker.line(Self::TIME_TO_START) {
            Ok(line) => line,
            Err(Silence::Ended(how)) => return Err(failure(format!("{how} before its first run"))),
            Err(Silence::TooLong) => return Err(failure("did not get ready".into())),
        };
        match serde_json::from_str(&line) {
            Ok(Greeting::Ready(ready)) => worker.ready = ready,
            Ok(Greeting::Failure { message, usage: true }) => return Err(SweepError::Usage(message)),
            Ok(Greeting::Failure { message, .. }) => return Err(failure(format!("says: {message}"))),
            Err(error) => return Err(failure(format!("says {line:?}: {error}"))),
        }
        Ok(worker)
    }

    /// Makes a run in a worker, which is started first if there is none. A worker that dies during the run is removed.
    ///
    /// # Errors
    /// When no worker can be started.
    pub fn run(&self, place: &mut Option<Worker>, run: u64) -> Result<Row, SweepError> {
        let mut worker = match place.take() {
            Some(worker) => worker,
            None => self.start_again()?,
        };
        let silence = match worker.ask(run, self.timeout) {
            Ok(row) => {
                *place = Some(worker);
                return Ok(row);
            }
            Err(silence) => silence,
        };
        Ok(match silence {
            Silence::Ended(how) => Row::without_figures(run, Status::Crashed, format!("its process {how}")),
            Silence::TooLong => {
                Row::without_figures(run, Status::Timeout, format!("not done after {} s", self.timeout.as_secs_f64()))
            }
        })
    }

    fn start_again(&self) -> Result<Worker, SweepError> {
        let mut result = self.start();
        for _ in 1..Self::STARTS {
            if result.is_ok() {
                break;
            }
            result = self.start();
        }
        result
    }
}

impl Worker {
    fn ask(&mut self, run: u64, timeout: Duration) -> Result<Row, Silence> {
        let Some(input) = &mut self.input else { return Err(self.end()) };
        if writeln!(input, "{run}").and_then(|()| input.flush()).is_err() {
            return Err(self.end());
        }
        let line = self.line(timeout)?;
        let row: Option<Row> = serde_json::from_str(&line).ok();
        row.filter(|row| row.run == run).ok_or_else(|| Silence::Ended(format!("answered {line:?}")))
    }

    fn line(&mut self, timeout: Duration) -> Result<String, Silence> {
        match self.lines.recv_timeout(timeout) {
            Ok(line) => Ok(line),
            Err(RecvTimeoutError::Timeout) => Err(Silence::TooLong),
            Err(RecvTimeoutError::Disconnected) => Err(self.end()),
        }
    }

    /// The reason why the output of a process has ended.
    fn end(&mut self) -> Silence {
        let how = match self.child.wait() {
            Ok(status) => ended(status),
            Err(error) => format!("is lost: {error}"),
        };
        // Somebody whom it started may hold its standard error open for longer.
        let _ = self.silent.recv_timeout(Duration::from_secs(5));
        let said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        let last = said.lines().rev().find(|line| !line.trim().is_empty()).map(str::trim);
        let last = last.map(|line| line.strip_prefix("error: ").unwrap_or(line));
        Silence::Ended(last.map_or(how.clone(), |line| format!("{how}: {line}")))
    }
}

impl Drop for Worker {
    /// Requests its end, which it obeys also during a run, and kills it otherwise.
    fn drop(&mut self) {
        const PATIENCE: u32 = 200;
        drop(self.input.take());
        for _ in 0..PATIENCE {
            if matches!(self.child.try_wait(), Ok(Some(_)) | Err(_)) {
                return;
            }
            thread::sleep(Duration::from_millis(10));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn ended(status: ExitStatus) -> String {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        if let Some(signal) = status.signal() {
            return format!("was ended by signal {signal}");
        }
    }
    status.code().map_or("ended".into(), |code| format!("ended with exit code {code}"))
}

/// Reads to the end and keeps the last part.
fn keep_end(mut from: impl Read, kept: &Mutex<String>) {
    const LONGEST: usize = 2000;
    let mut buffer = [0; 4096];
    while let Ok(length @ 1..) = from.read(&mut buffer) {
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push_str(&String::from_utf8_lossy(&buffer[..length]));
        if kept.len() > LONGEST {
            let cut = (kept.len() - LONGEST..=kept.len()).find(|at| kept.is_char_boundary(*at)).unwrap_or_default();
            kept.drain(..cut);
        }
    }
}
