//! One run of a [`System`]: completes the options, runs it, calls an [`Observer`], and returns the results.

use std::io;
use std::time::{Duration, Instant};

use crate::grid::{GridError, TimeGrid};
use crate::master::{Coupling, Master, MasterError};
use crate::names::number;
use crate::record::{Column, Every, Last, Points, Sink};
use crate::system::{RunOptions, System};
use fmi2_import::CallError;

/// How to run a system, with nothing left open.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    /// The communication points.
    pub grid: TimeGrid,
    /// How signals are exchanged.
    pub coupling: Coupling,
    /// Time in s between two rows of the output; 0 for every step.
    pub interval: f64,
}

/// Why a system cannot be run as wanted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Start, stop and step make no grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The first step would lead beyond the stop time.
    #[error("a step of {} s is longer than the run from {} s to {} s", number(*step), number(*start), number(*stop))]
    LongStep {
        /// Start time in s.
        start: f64,
        /// Stop time in s.
        stop: f64,
        /// Step size in s.
        step: f64,
    },
    /// Rows cannot come at such an interval.
    #[error("the interval must be 0 or more seconds, not {}", number(*.0))]
    Interval(f64),
}

/// Follows a run from the start values to the last row, and may return remarks for the user.
pub trait Observer {
    /// Called when the components are initialised; rows with these columns follow. Returns remarks for the user.
    fn begin(&mut self, master: &mut Master, columns: &[Column]) -> Vec<String>;

    /// Whether it needs this column at every communication point, however few rows are read. Called after
    /// [`Observer::begin`].
    fn follows(&self, _column: &Column) -> bool {
        false
    }

    /// Takes the columns that it follows, and perhaps others, at the next communication points. None is left out.
    ///
    /// # Errors
    /// When they cannot be stored.
    fn points(&mut self, _points: &Points) -> io::Result<()> {
        Ok(())
    }

    /// Where it wants whole rows, and which of them; `None` if it never wants any. Called after [`Observer::begin`].
    fn rows(&mut self) -> Option<&mut dyn Sink> {
        None
    }

    /// Called after the last row. Returns remarks for the user.
    fn conclude(&mut self) -> Vec<String>;
}

/// Has no remarks.
impl Observer for () {
    fn begin(&mut self, _: &mut Master, _: &[Column]) -> Vec<String> {
        Vec::new()
    }

    fn conclude(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// Calls an observer when it has something to do.
struct Watched<'a> {
    observer: &'a mut dyn Observer,
    has_rows: bool,
}

impl<'a> Watched<'a> {
    /// An observer that has begun.
    fn new(observer: &'a mut dyn Observer) -> Self {
        let has_rows = observer.rows().is_some();
        Self { observer, has_rows }
    }

    /// Where it wants whole rows.
    fn rows(&mut self) -> Option<&mut dyn Sink> {
        if self.has_rows { self.observer.rows() } else { None }
    }
}

impl Sink for Watched<'_> {
    fn wants(&mut self, time: f64) -> bool {
        self.rows().is_some_and(|rows| rows.wants(time))
    }

    fn idle(&mut self) -> f64 {
        self.rows().map_or(f64::INFINITY, Sink::idle)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.rows().map_or(Ok(()), |rows| rows.row(time, values))
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        self.observer.points(points)
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.rows().map_or(Ok(()), |rows| rows.end(time, values))
    }
}

/// The results of a run.
#[derive(Debug)]
pub struct Results {
    /// Wall time of the steps and of what takes their rows, without opening and initialising the FMUs. What an FMU prepares for a
    /// step size belongs to its first step.
    pub wall_time: Duration,
    /// Steps that were done: fewer than planned if a component ended the simulation.
    pub steps: u64,
    /// The last row.
    pub last: Vec<f64>,
    /// The outputs that are texts, which rows do not have: names and last values.
    pub texts: Vec<(String, String)>,
    /// Remarks for the user, from the description's reader, the master and the observer.
    pub remarks: Vec<String>,
    /// Set if a component ended the simulation, which is not an error.
    pub ended: Option<Ended>,
}

/// The early end of a simulation by a component.
#[derive(Debug)]
pub struct Ended {
    /// How far it got, in s.
    pub time: f64,
    /// The component.
    pub component: String,
    /// The status of the FMU.
    pub source: CallError,
}

impl Run {
    /// Completes these options with the default experiment of the system's first FMU, and that with 0 s to 5 s in
    /// steps of 0.1 ms and rows 1 ms apart.
    ///
    /// # Errors
    /// When they cannot be run.
    pub fn of(wanted: &RunOptions, system: &System) -> Result<Self, RunError> {
        let suggested =
            system.components.first().map(|(_, fmu)| fmu.description().default_experiment).unwrap_or_default();
        let start = wanted.start.or(suggested.start_time).unwrap_or(0.0);
        let stop = wanted.stop.or(suggested.stop_time).unwrap_or(start + 5.0);
        let step = wanted.step.or(suggested.step_size).unwrap_or(1e-4);
        let grid = grid(start, stop, step)?;
        let interval = wanted.interval.unwrap_or(1e-3);
        if !(interval >= 0.0 && interval.is_finite()) {
            return Err(RunError::Interval(interval));
        }
        Ok(Self { grid, coupling: wanted.coupling.unwrap_or_default(), interval })
    }

    /// Initialises the master, which comes from the system and records `columns`, and steps it over the grid. Rows go to
    /// `rows` every [`interval`](Run::interval) s, and to `observer` if it wants them. It gets the columns that it follows at
    /// every communication point. `progress` is called with the number of completed steps.
    ///
    /// # Errors
    /// When an FMU refuses, or a row cannot be stored.
    pub fn execute(
        &self,
        system: &System,
        master: &mut Master,
        columns: &[Column],
        rows: &mut dyn Sink,
        observer: &mut dyn Observer,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Results, MasterError> {
        master.initialize(&self.grid)?;
        let mut remarks = system.remarks.clone();
        remarks.extend_from_slice(master.warnings());
        let known = master.warnings().len();
        remarks.extend(self.uneven_rows());
        remarks.extend(unconnected(master));
        remarks.extend(observer.begin(master, columns));
        master.follow(&columns.iter().map(|column| observer.follows(column)).collect::<Vec<_>>());
        let mut watched = Watched::new(&mut *observer);
        let mut last = Last::default();
        let rows = Every::new(self.interval, self.grid.stop(), rows);
        let begin = Instant::now();
        let result = master.run(&self.grid, 0.0, &mut (rows, (&mut watched, &mut last)), progress);
        let wall_time = begin.elapsed();
        let ended = match result {
            Ok(()) => None,
            Err(MasterError::Ended { time, component, source }) => Some(Ended { time, component, source }),
            Err(error) => return Err(error),
        };
        remarks.extend_from_slice(&master.warnings()[known..]);
        let texts = master.texts().unwrap_or_default();
        remarks.extend(observer.conclude());
        Ok(Results { wall_time, steps: master.steps(), last: last.values, texts, remarks, ended })
    }

    /// A remark on rows that are not equally spaced: they are taken at communication points only.
    fn uneven_rows(&self) -> Option<String> {
        let steps = self.interval / self.grid.step();
        let is_multiple = (steps - steps.round()).abs() <= 1e-6 * steps.max(1.0);
        // An interval shorter than the step means every step: no row is missing.
        (steps > 1.0 && !is_multiple).then(|| {
            let (interval, step) = (number(self.interval), number(self.grid.step()));
            format!(
                "the interval of {interval} s is no multiple of the step of {step} s: rows come at the first communication \
                 point after each multiple, not equally spaced"
            )
        })
    }
}

/// The communication points from `start` s to `stop` s, `step` s apart.
///
/// # Errors
/// When there are none between these times.
pub fn grid(start: f64, stop: f64, step: f64) -> Result<TimeGrid, RunError> {
    let grid = TimeGrid::new(start, stop, step)?;
    if step > (stop - start) * (1.0 + 1e-9) {
        return Err(RunError::LongStep { start, stop, step });
    }
    Ok(grid)
}

/// Remarks on FMUs that run together but share no signal.
fn unconnected(master: &Master) -> Vec<String> {
    let names: Vec<_> = master.names().collect();
    if names.len() < 2 {
        return Vec::new();
    }
    let is_alone =
        |index: usize| !master.wires().iter().any(|wire| wire.from.component == index || wire.to.component == index);
    let alone = names.iter().enumerate().filter(|(index, _)| is_alone(*index));
    alone
        .map(|(_, name)| format!("{name} shares no signal with the other FMUs: no output has an input's name"))
        .collect()
}
