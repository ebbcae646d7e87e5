//! The rows and signals of a run that the page contains: every step of the first transients, then one row per interval; if
//! there are very many signals, only the first ones, because a browser could not open a page with all of them.

use std::fmt::Write;
use std::io;

use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::record::{Column, Pick, Schedule, Sink, Table};

/// The time in s after the start during which every step is kept. In this time the fastest visible bending mode (90 Hz) has
/// four periods, and the initial peak of PD and PDS is over.
pub const EVERY_STEP_UNTIL: f64 = 0.05;
/// The shortest interval between two later rows, in s: eleven per swing of that mode.
const SHORTEST: f64 = 1e-3;
/// At most about this many later rows.
const MOST: f64 = 8000.0;
/// At most this many of the early ones: a step may be very short.
const MOST_EARLY: usize = 4000;
/// At most this many rows of a file of results.
const MOST_SAVED: usize = 20_000;
/// At most this many signals.
pub const MOST_SIGNALS: usize = 250;

/// Interval in s between two rows after [`EVERY_STEP_UNTIL`] in a run of `duration` s.
#[must_use]
pub fn interval(duration: f64) -> f64 {
    (duration / MOST).max(SHORTEST.min(duration / 1000.0))
}

/// How many rows to expect.
fn expected(grid: &TimeGrid) -> usize {
    let duration = grid.stop() - grid.start();
    let early = (EVERY_STEP_UNTIL / grid.step()).min(MOST_EARLY as f64);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some thousands
    let rows = (duration / interval(duration).max(grid.step()) + early) as usize;
    rows + 2
}

/// The sentence on the page about the rows of a simulation.
#[must_use]
pub fn sentence(grid: &TimeGrid) -> String {
    let interval = interval(grid.stop() - grid.start()).max(grid.step());
    let [step, early, interval] = [grid.step(), EVERY_STEP_UNTIL, interval].map(milliseconds);
    format!(
        "Curves and animation hold every communication step ({step} ms) of the first {early} ms and one row per \
         {interval} ms after it, with values to a millionth of each signal\u{2019}s range; metrics are of every step."
    )
}

/// A time in s as ms, without the digits that only rounding puts there.
fn milliseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e3
}

/// The columns in the page: those that it knows how to show, then others, up to [`MOST_SIGNALS`].
fn wanted(columns: &[Column]) -> Vec<usize> {
    let (known, others): (Vec<usize>, Vec<usize>) =
        (0..columns.len()).partition(|&index| super::signals::is_known(&columns[index].name));
    let mut wanted: Vec<usize> = known.into_iter().chain(others).take(MOST_SIGNALS).collect();
    wanted.sort_unstable();
    wanted
}

/// Keeps the rows and signals of a simulation for the page.
pub struct Rows {
    start: f64,
    stop: f64,
    early: usize,
    schedule: Schedule,
    /// Which time it was asked about last, and whether the row of this time is one of them.
    asked: Option<(f64, bool)>,
    /// No row is wanted before this time since the start.
    idle: f64,
    picked: Pick,
}

impl Rows {
    /// Rows of a run with these communication points and columns.
    #[must_use]
    pub fn new(grid: &TimeGrid, columns: &[Column]) -> Self {
        let (start, stop) = (grid.start(), grid.stop());
        let wanted = wanted(columns);
        let names: Vec<&str> = wanted.iter().map(|&index| columns[index].name.as_str()).collect();
        let mut picked = Pick::new(columns, |name| names.contains(&name));
        picked.table = picked.table.with_room(expected(grid));
        let schedule = Schedule::new(start, interval(stop - start));
        Self { start, stop, early: 0, schedule, asked: None, idle: 0.0, picked }
    }

    fn is_wanted(&mut self, time: f64) -> bool {
        let is_due = self.schedule.is_due(time) || time >= self.stop;
        let is_early = time - self.start <= EVERY_STEP_UNTIL && self.early < MOST_EARLY;
        self.early += usize::from(is_early);
        if !is_early {
            self.idle = self.schedule.idle().min(self.stop - self.start);
        }
        is_due || is_early
    }

    /// The kept rows.
    #[must_use]
    pub fn into_table(self) -> Table {
        self.picked.table
    }
}

impl Sink for Rows {
    fn wants(&mut self, time: f64) -> bool {
        let is_wanted = time - self.start >= self.idle && self.is_wanted(time);
        self.asked = Some((time, is_wanted));
        is_wanted
    }

    fn idle(&mut self) -> f64 {
        (self.start + self.idle).min(self.stop)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let asked = self.asked.filter(|(at, _)| *at == time);
        let is_wanted = asked.map_or_else(|| self.is_wanted(time), |(_, is_wanted)| is_wanted);
        if is_wanted { self.picked.row(time, values) } else { Ok(()) }
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        // A run that ends before its time.
        if self.picked.table.times().last() == Some(&time) { Ok(()) } else { self.picked.row(time, values) }
    }
}

/// The part of a result file that the page contains, and a sentence on the omitted part.
#[must_use]
pub fn of_saved(table: &Table) -> (Table, String) {
    let columns = wanted(table.columns());
    let every = table.times().len().div_ceil(MOST_SAVED).max(1);
    let last = table.times().len().saturating_sub(1);
    let rows = (0..=last).filter(|row| row % every == 0 || *row == last);
    let part = super::signals::with_decades(table.part(&columns, rows));
    let mut said = format!("{} rows", table.times().len());
    if every > 1 {
        let _ = write!(said, ", of which curves show one in {every}; faster swings are not drawn as they are");
    }
    if columns.len() < table.columns().len() {
        let _ = write!(said, "; {} of {} signals", columns.len(), table.columns().len());
    }
    (part, said + ".")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_at_first_and_then_one_per_interval() {
        let columns = [Column { name: "a".into(), ..Column::default() }];
        let grid = TimeGrid::new(0.0, 8.0, 1e-4).unwrap();
        let mut rows = Rows::new(&grid, &columns);
        for step in 0..=grid.steps() {
            rows.row(grid.time(step), &[grid.time(step)]).unwrap();
        }
        let table = rows.into_table();
        let times = table.times();
        let early = times.iter().filter(|time| **time <= EVERY_STEP_UNTIL).count();
        assert_eq!((early, times.len() - early), (501, 7950));
        assert!((times[501] - 0.051).abs() < 1e-12 && (times[times.len() - 1] - 8.0).abs() < 1e-12);
        assert!((interval(80.0) - 0.01).abs() < 1e-15);
        assert!((interval(1e-3) - 1e-6).abs() < 1e-18, "a short run keeps its rows");
    }

    #[test]
    fn of_too_much_the_page_gets_a_part_that_says_so() {
        let column = |name: String| Column { name, ..Column::default() };
        let mut names: Vec<_> = (0..300).map(|index| column(format!("x{index}"))).collect();
        names.push(column("theta1".into()));
        let mut table = Table::new(names);
        for row in 0..50_000_u32 {
            table.row(f64::from(row), &[0.0; 301]).unwrap();
        }
        let (part, said) = of_saved(&table);
        assert_eq!(part.columns().len(), MOST_SIGNALS);
        assert!(part.column("theta1").is_some() && part.times().len() <= MOST_SAVED);
        assert_eq!(part.times().last(), Some(&49_999.0));
        assert!(said.starts_with("50000 rows, of which curves show one in 3") && said.contains("250 of 301"), "{said}");
    }
}
