//! Sinks that pass on a part of a run: [some columns](Pick), [some rows](Every).

use std::io;

use super::{Column, Sink, Table};

/// Keeps only some columns.
#[derive(Debug)]
pub struct Pick {
    /// Their places among all columns.
    pub(super) indices: Vec<usize>,
    /// The picked columns.
    pub table: Table,
}

impl Pick {
    /// A table of those of `columns` that `wanted` accepts.
    pub fn new(columns: &[Column], wanted: impl Fn(&str) -> bool) -> Self {
        let indices: Vec<_> = (0..columns.len()).filter(|&index| wanted(&columns[index].name)).collect();
        let picked = indices.iter().map(|&index| columns[index].clone()).collect();
        Self { indices, table: Table::new(picked) }
    }
}

impl Sink for Pick {
    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.table.push(time, values, &self.indices);
        Ok(())
    }
}

/// Passes on only the rows at multiples of an interval, and the first and the last one.
#[derive(Debug)]
pub struct Every<S> {
    interval: f64,
    stop: f64,
    schedule: Option<Schedule>,
    /// Which time it was asked about last, and whether the row of this time is one of them.
    asked: Option<(f64, bool)>,
    passed: Option<f64>,
    /// Takes these rows.
    pub sink: S,
}

impl<S> Every<S> {
    /// Rows `interval` s apart, and the one at `stop`, for `sink`.
    pub fn new(interval: f64, stop: f64, sink: S) -> Self {
        Self { interval, stop, schedule: None, asked: None, passed: None, sink }
    }

    fn is_due(&mut self, time: f64) -> bool {
        let interval = self.interval;
        let schedule = self.schedule.get_or_insert_with(|| Schedule::new(time, interval));
        schedule.is_due(time) || time >= self.stop
    }
}

impl<S: Sink> Sink for Every<S> {
    fn wants(&mut self, time: f64) -> bool {
        let due = self.is_due(time);
        self.asked = Some((time, due));
        due && self.sink.wants(time)
    }

    fn idle(&mut self) -> f64 {
        let before_due = self.schedule.map_or(f64::NEG_INFINITY, |schedule| schedule.start + schedule.idle());
        before_due.min(self.stop).max(self.sink.idle())
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let asked = self.asked.filter(|(at, _)| *at == time);
        let due = asked.map_or_else(|| self.is_due(time), |(_, due)| due);
        if due {
            self.passed = Some(time);
            return self.sink.row(time, values);
        }
        Ok(())
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        // A run that ends before its time does so between two multiples of the interval.
        if self.passed != Some(time) {
            self.passed = Some(time);
            self.sink.row(time, values)?;
        }
        self.sink.end(time, values)
    }
}

/// Which communication points are recorded: the first one at or after each multiple of the interval.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    start: f64,
    interval: f64,
    next: f64,
}

impl Schedule {
    /// Points that miss their instant by this fraction of the interval are on time.
    const ROUNDING: f64 = 1e-6;

    /// Multiples of `interval` s, counted from `start`.
    #[must_use]
    pub fn new(start: f64, interval: f64) -> Self {
        Self { start, interval, next: 0.0 }
    }

    /// The time in s since the start until which surely none is.
    #[must_use]
    pub fn idle(&self) -> f64 {
        (self.next - 0.5) * self.interval
    }

    /// Whether the communication point at `time` s is one of them. Call it in the order of time.
    pub fn is_due(&mut self, time: f64) -> bool {
        if self.interval <= 0.0 {
            return true;
        }
        if time - self.start < self.idle() {
            return false;
        }
        let position = (time - self.start) / self.interval + Self::ROUNDING;
        let due = position >= self.next;
        if due {
            self.next = position.floor() + 1.0;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schedule_tolerates_rounding_but_skips_nothing() {
        let mut schedule = Schedule::new(0.0, 1e-3);
        let due = (0..=50_000_u32).filter(|&step| schedule.is_due(f64::from(step) * 1e-4)).count();
        assert_eq!(due, 5_001);
        let mut odd = Schedule::new(0.0, 0.25);
        let due: Vec<_> = (0..=10_u32).filter(|&step| odd.is_due(f64::from(step) * 0.1)).collect();
        assert_eq!(due, [0, 3, 5, 8, 10]);
    }
}
