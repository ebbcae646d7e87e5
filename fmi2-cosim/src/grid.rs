//! Communication points of a run with a fixed step.

use crate::names::number;

/// The communication points `start + i·step`, computed and never accumulated, and `stop` as the last one. When the
/// duration is not a multiple of the step, the last step is shorter.
///
/// If start and step are decimal fractions, so are all points: the point after three steps of 0.1 ms is the number
/// nearest to 0.0003, not `3.0 * 1e-4` (which is 0.00030000000000000003).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeGrid {
    start: f64,
    stop: f64,
    step: f64,
    steps: u64,
    decimal: Option<Decimal>,
}

/// Start and step as whole numbers of a decimal fraction of a second.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Decimal {
    start: f64,
    step: f64,
    /// A power of ten.
    per_second: f64,
}

impl Decimal {
    /// More digits than a double holds.
    const MAX_DIGITS: i32 = 15;
    /// Whole numbers up to here are exact, and so is the rounding of a quotient of two of them.
    const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

    fn of(start: f64, step: f64, steps: u64) -> Option<Self> {
        (0..=Self::MAX_DIGITS).find_map(|digits| {
            let per_second = 10_f64.powi(digits);
            let whole = |value: f64| Some((value * per_second).round()).filter(|whole| whole / per_second == value);
            let decimal = Self { start: whole(start)?, step: whole(step)?, per_second };
            let last = decimal.start.abs() + steps as f64 * decimal.step;
            (last <= Self::MAX_EXACT).then_some(decimal)
        })
    }

    fn time(&self, index: u64) -> f64 {
        (self.start + index as f64 * self.step) / self.per_second
    }
}

/// Why there is no such grid.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// The step is zero, negative or not a number.
    #[error("the step size must be a positive number of seconds, not {}", number(*.0))]
    Step(f64),
    /// The stop time is not later than the start time.
    #[error("the stop time ({} s) must be later than the start time ({} s)", number(*stop), number(*start))]
    Stop {
        /// Start time in s.
        start: f64,
        /// Stop time in s.
        stop: f64,
    },
    /// Time would not advance in floating point.
    #[error("a step of {} s is too small for times up to {} s: time would not advance", number(*step), number(*stop))]
    TooFine {
        /// Step size in s.
        step: f64,
        /// Stop time in s.
        stop: f64,
    },
}

impl TimeGrid {
    /// A duration counts as a multiple of the step if the deviation is at most this fraction of a step (per step): decimal
    /// fractions such as 1e-4 are not exact in binary.
    const ROUNDING: f64 = 1e-9;
    /// A time counts as a communication point if the deviation is at most this fraction of a step.
    const POINT_ROUNDING: f64 = 1e-6;

    /// The grid from `start` to `stop` with steps of `step` (all in s).
    ///
    /// # Errors
    /// When the step is not positive, the stop time is not after the start time, or time would not advance.
    pub fn new(start: f64, stop: f64, step: f64) -> Result<Self, GridError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(GridError::Step(step));
        }
        if !(start.is_finite() && stop.is_finite() && stop > start) {
            return Err(GridError::Stop { start, stop });
        }
        let count = (stop - start) / step;
        // Neighbouring points must differ by clearly more than their rounding.
        if count > 1e15 || start.abs().max(stop.abs()) * f64::EPSILON * 1e3 > step {
            return Err(GridError::TooFine { step, stop });
        }
        let whole = count.round();
        let is_multiple = whole >= 1.0 && (count - whole).abs() <= Self::ROUNDING * whole.max(1.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 1 ≤ count ≤ 1e15
        let steps = if is_multiple { whole } else { count.ceil() } as u64;
        Ok(Self { start, stop, step, steps, decimal: Decimal::of(start, step, steps) })
    }

    /// Number of steps.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Start time in s.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Stop time in s.
    #[must_use]
    pub fn stop(&self) -> f64 {
        self.stop
    }

    /// Size in s of every step, except perhaps the last.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The communication point before step `index` (and, for `index` = number of steps, the stop time).
    #[inline]
    #[must_use]
    pub fn time(&self, index: u64) -> f64 {
        if index >= self.steps {
            return self.stop;
        }
        match &self.decimal {
            Some(decimal) => decimal.time(index),
            None => self.start + index as f64 * self.step,
        }
    }

    /// All communication points.
    #[must_use]
    pub fn times(&self) -> Vec<f64> {
        (0..=self.steps).map(|index| self.time(index)).collect()
    }

    /// The communication point at this time, if there is one up to rounding.
    #[must_use]
    pub fn point_at(&self, time: f64) -> Option<f64> {
        let position = ((time - self.start) / self.step).round().clamp(0.0, self.steps as f64);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and the number of steps
        let index = position as u64;
        let near = |point: f64| (time - point).abs() <= Self::POINT_ROUNDING * self.step;
        [self.time(index), self.stop].into_iter().find(|&point| near(point))
    }

    /// Size of step `index`. Apart from a shorter last step it always has the same bits, so that slaves can reuse what they
    /// computed for it.
    #[inline]
    #[must_use]
    pub fn size(&self, index: u64) -> f64 {
        if index + 1 == self.steps && self.has_shorter_last_step() { self.stop - self.time(index) } else { self.step }
    }

    /// Whether the last step is shorter than the others.
    #[must_use]
    pub fn has_shorter_last_step(&self) -> bool {
        let last = self.stop - self.time(self.steps - 1);
        (self.step - last) > Self::ROUNDING * self.steps as f64 * self.step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_do_not_accumulate_and_end_at_the_stop_time() {
        let grid = TimeGrid::new(0.0, 5.0, 1e-4).unwrap();
        assert_eq!(grid.steps(), 50_000);
        assert!(!grid.has_shorter_last_step());
        assert_eq!(grid.time(30_000).to_bits(), (30_000.0 * 1e-4_f64).to_bits());
        assert_eq!(grid.time(50_000).to_bits(), 5.0_f64.to_bits());
        assert!((0..50_000).all(|index| grid.size(index).to_bits() == 1e-4_f64.to_bits()));
    }

    #[test]
    fn the_last_step_is_shorter_when_it_must_be() {
        let grid = TimeGrid::new(1.0, 2.05, 0.1).unwrap();
        assert_eq!(grid.steps(), 11);
        assert!(grid.has_shorter_last_step());
        assert!((grid.size(10) - 0.05).abs() < 1e-15);
        assert_eq!(grid.size(9).to_bits(), 0.1_f64.to_bits());
        assert!((grid.time(10) + grid.size(10) - 2.05).abs() < 1e-15);

        let one = TimeGrid::new(0.0, 0.3, 1.0).unwrap();
        assert_eq!((one.steps(), one.size(0).to_bits()), (1, 0.3_f64.to_bits()));
    }

    #[test]
    fn decimal_steps_give_decimal_times() {
        for (start, step, digits) in [(0.0, 1e-4, 4), (0.5, 2.5e-4, 5), (-1.0, 0.1, 1), (100.0, 3e-6, 6)] {
            let grid = TimeGrid::new(start, start + 7000.0 * step, step).unwrap();
            for index in 0..grid.steps() {
                let exact = format!("{:.digits$}", start + index as f64 * step);
                let nearest: f64 = exact.parse().unwrap();
                assert_eq!(grid.time(index), nearest, "{step}·{index}");
            }
        }
        let thirds = TimeGrid::new(0.0, 1.0, 1.0 / 3.0).unwrap();
        assert_eq!(thirds.time(2), 2.0 / 3.0);
    }

    #[test]
    fn communication_points_are_found_up_to_rounding() {
        let grid = TimeGrid::new(0.0, 1.05, 0.1).unwrap();
        assert_eq!(grid.point_at(0.1 + 0.2), Some(0.3));
        assert_eq!(grid.point_at(1.05), Some(1.05));
        assert_eq!([0.25, 1.0001, 1.1, -0.1].map(|time| grid.point_at(time)), [None; 4]);
    }

    #[test]
    fn impossible_grids_are_refused() {
        for step in [0.0, -1e-4, f64::NAN, f64::INFINITY] {
            assert!(matches!(TimeGrid::new(0.0, 1.0, step), Err(GridError::Step(_))), "{step}");
        }
        for stop in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(TimeGrid::new(0.0, stop, 0.1), Err(GridError::Stop { .. })), "{stop}");
        }
        assert!(matches!(TimeGrid::new(1e6, 1e6 + 1.0, 1e-9), Err(GridError::TooFine { .. })));
        assert!(matches!(TimeGrid::new(0.0, 1.0, 1e-300), Err(GridError::TooFine { .. })));
    }
}
