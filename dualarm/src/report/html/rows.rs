//! Which rows of a run the page gets: every step of the first transients, then one per interval.

use std::io;

use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::record::{Pick, Schedule, Sink, Table};

/// For this long after the start every step is kept, in s: the fastest bending mode that is visible (90 Hz) swings four
/// times, and the kick that PD and PDS begin with is over.
pub const EVERY_STEP_UNTIL: f64 = 0.05;
/// The shortest interval between two later rows, in s: eleven per swing of that mode.
const SHORTEST: f64 = 1e-3;
/// At most about this many later rows: a long run must not make a page that no browser opens.
const MOST: f64 = 8000.0;

/// Interval in s between two rows after [`EVERY_STEP_UNTIL`] in a run of `duration` s.
#[must_use]
pub fn interval(duration: f64) -> f64 {
    (duration / MOST).max(SHORTEST)
}

/// Keeps these rows of the picked columns, and the last one.
pub struct Rows {
    start: f64,
    stop: f64,
    schedule: Schedule,
    picked: Pick<Table>,
}

impl Rows {
    /// Rows of a run with these communication points.
    #[must_use]
    pub fn new(grid: &TimeGrid, picked: Pick<Table>) -> Self {
        let (start, stop) = (grid.start(), grid.stop());
        Self { start, stop, schedule: Schedule::new(start, interval(stop - start)), picked }
    }

    /// What was kept.
    #[must_use]
    pub fn into_table(self) -> Table {
        self.picked.sink
    }
}

impl Sink for Rows {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let is_due = self.schedule.is_due(time) || time >= self.stop;
        if is_due || time - self.start <= EVERY_STEP_UNTIL { self.picked.row(time, values) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi2_cosim::record::Column;

    #[test]
    fn every_step_at_first_and_then_one_per_interval() {
        let columns = [Column { name: "a".into(), ..Column::default() }];
        let grid = TimeGrid::new(0.0, 8.0, 1e-4).unwrap();
        let mut rows = Rows::new(&grid, Pick::new(&columns, |_| true));
        for step in 0..=grid.steps() {
            rows.row(grid.time(step), &[grid.time(step)]).unwrap();
        }
        let table = rows.into_table();
        let times = table.times();
        let early = times.iter().filter(|time| **time <= EVERY_STEP_UNTIL).count();
        assert_eq!((early, times.len() - early), (501, 7950));
        assert!((times[501] - 0.051).abs() < 1e-12 && (times[times.len() - 1] - 8.0).abs() < 1e-12);
        assert!((interval(80.0) - 0.01).abs() < 1e-15);
    }
}
