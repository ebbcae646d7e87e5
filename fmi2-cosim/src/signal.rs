//! Values over time: steps and piecewise-linear tables, for inputs that no FMU drives.

use fmi2_import::{Mismatch, Value, Variable};

use crate::grid::TimeGrid;

/// How a signal continues from one point to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// It keeps the value of the last point and jumps at the next one.
    Steps,
    /// It follows a straight line to the next point. Two points at one time are a jump.
    Linear,
}

/// A value over time, given by points. Before the first point it has the first point's value, after the last point the
/// last one's.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    shape: Shape,
    points: Vec<(f64, f64)>,
    /// Points whose values are names, by their indices; the variable defines their values.
    names: Vec<(usize, String)>,
}

/// The value of a point.
#[derive(Debug, Clone, PartialEq)]
pub enum Level {
    /// A number, or a truth value as 1 or 0.
    Number(f64),
    /// The name of an enumeration's item.
    Name(String),
}

/// Why points do not define a signal.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SignalError {
    /// There is no point.
    #[error("a signal needs at least one point [time, value]")]
    Empty,
    /// A time or a value is infinite or not a number.
    #[error("the point [{time}, {value}] is not finite")]
    NotFinite {
        /// Time in s.
        time: f64,
        /// Value.
        value: f64,
    },
    /// Times go back, or a signal of steps has two values at one time.
    #[error("times must {}: {next} s follows {time} s", if *.equal_allowed { "not decrease" } else { "increase" })]
    Order {
        /// Time of a point in s.
        time: f64,
        /// Time of the point after it in s.
        next: f64,
        /// Whether two points may have the same time.
        equal_allowed: bool,
    },
}

impl Signal {
    /// A signal through these points, `(time in s, value)`.
    ///
    /// # Errors
    /// When there is no point, a number is not finite, or the times are out of order.
    pub fn new(shape: Shape, points: Vec<(f64, f64)>) -> Result<Self, SignalError> {
        if points.is_empty() {
            return Err(SignalError::Empty);
        }
        if let Some(&(time, value)) = points.iter().find(|(time, value)| !(time.is_finite() && value.is_finite())) {
            return Err(SignalError::NotFinite { time, value });
        }
        let equal_allowed = shape == Shape::Linear;
        let out_of_order = |pair: &&[(f64, f64)]| {
            let (time, next) = (pair[0].0, pair[1].0);
            next < time || (next == time && !equal_allowed)
        };
        if let Some(pair) = points.windows(2).find(out_of_order) {
            return Err(SignalError::Order { time: pair[0].0, next: pair[1].0, equal_allowed });
        }
        Ok(Self { shape, points, names: Vec::new() })
    }

    /// The same with names of an enumeration's items among the values. [`Signal::of`] replaces the names by values once the
    /// variable is known.
    ///
    /// # Errors
    /// As [`Signal::new`].
    pub fn with_names(shape: Shape, points: Vec<(f64, Level)>) -> Result<Self, SignalError> {
        let mut names = Vec::new();
        let number = |(index, (time, level))| match level {
            Level::Number(value) => (time, value),
            Level::Name(name) => {
                names.push((index, name));
                (time, 0.0)
            }
        };
        let points = points.into_iter().enumerate().map(number).collect();
        Ok(Self { names, ..Self::new(shape, points)? })
    }

    /// The signal as values of a variable, which defines the meaning of names.
    ///
    /// # Errors
    /// When the variable has no item with one of the names.
    pub fn of(&self, variable: &Variable) -> Result<Self, Mismatch> {
        let mut signal = Self { names: Vec::new(), ..self.clone() };
        for (index, name) in &self.names {
            signal.points[*index].1 = match variable.parse(name)? {
                Value::Real(number) => number,
                Value::Integer(number) => f64::from(number),
                Value::Boolean(truth) => f64::from(u8::from(truth)),
                // Texts cannot change over time, whatever they are.
                Value::Text(_) => 0.0,
            };
        }
        Ok(signal)
    }

    /// The value at a time in s; at a jump, the value after it.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        self.between(self.points.partition_point(|point| point.0 <= time), time)
    }

    /// The value just before a time in s: differs from [`Signal::at`] at jumps only.
    #[must_use]
    pub fn before(&self, time: f64) -> f64 {
        self.between(self.points.partition_point(|point| point.0 < time), time)
    }

    /// The value at `time` between the points `next − 1` and `next`.
    fn between(&self, next: usize, time: f64) -> f64 {
        let Some(&(begin, first)) = next.checked_sub(1).and_then(|last| self.points.get(last)) else {
            return self.points[0].1;
        };
        match self.points.get(next) {
            Some(&(end, second)) if self.shape == Shape::Linear => {
                first + (second - first) * ((time - begin) / (end - begin))
            }
            _ => first,
        }
    }

    /// The values of all points.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|point| point.1)
    }

    /// Whether it can have a slope.
    #[must_use]
    pub fn is_ramped(&self) -> bool {
        self.shape == Shape::Linear
            && self.points.windows(2).any(|pair| pair[0].1 != pair[1].1 && pair[0].0 < pair[1].0)
    }

    /// Moves points that miss a communication point only by rounding onto it. Returns the times of the jumps that are
    /// between communication points; a master applies them at the next one.
    pub fn snap(&mut self, grid: &TimeGrid) -> Vec<f64> {
        for (time, _) in &mut self.points {
            if let Some(point) = grid.point_at(*time) {
                *time = point;
            }
        }
        let is_jump =
            |pair: &&[(f64, f64)]| pair[0].1 != pair[1].1 && (self.shape == Shape::Steps || pair[0].0 == pair[1].0);
        let inside = |time: &f64| grid.start() < *time && *time < grid.stop();
        let jumps = self.points.windows(2).filter(is_jump).map(|pair| pair[1].0);
        jumps.filter(inside).filter(|time| grid.point_at(*time).is_none()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_hold_and_jump() {
        let signal = Signal::new(Shape::Steps, vec![(0.5, 1.0), (1.0, -2.0)]).unwrap();
        let values = [0.0, 0.5, 0.999, 1.0, 9.0].map(|time| signal.at(time));
        assert_eq!(values, [1.0, 1.0, 1.0, -2.0, -2.0]);
        assert_eq!((signal.before(1.0), signal.before(1.1)), (1.0, -2.0));
        assert!(!signal.is_ramped());
    }

    #[test]
    fn linear_signals_follow_lines_and_can_jump() {
        let signal = Signal::new(Shape::Linear, vec![(0.0, 0.0), (1.0, 4.0), (1.0, 1.0), (2.0, 1.0)]).unwrap();
        let values = [-1.0, 0.25, 1.0, 1.5, 7.0].map(|time| signal.at(time));
        assert_eq!(values, [0.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(signal.before(1.0), 4.0);
        assert!(signal.is_ramped());
    }

    #[test]
    fn jumps_between_communication_points_are_found_and_rounding_is_not_one() {
        let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
        let mut signal =
            Signal::new(Shape::Steps, vec![(0.0, 0.0), (0.1 + 0.2, 1.0), (0.55, 2.0), (3.05, 0.0)]).unwrap();
        assert_eq!(signal.snap(&grid), [0.55]);
        assert_eq!((signal.at(grid.time(3)), signal.at(grid.time(5)), signal.at(grid.time(6))), (1.0, 1.0, 2.0));
        // A kink of a linear signal is no jump.
        let mut ramp = Signal::new(Shape::Linear, vec![(0.0, 0.0), (0.55, 1.0), (1.0, 0.0)]).unwrap();
        assert!(ramp.snap(&grid).is_empty());
    }

    #[test]
    fn what_is_no_signal_is_refused() {
        use SignalError::{Empty, NotFinite, Order};
        assert_eq!(Signal::new(Shape::Steps, vec![]), Err(Empty));
        assert!(matches!(Signal::new(Shape::Linear, vec![(0.0, f64::NAN)]), Err(NotFinite { .. })));
        assert!(matches!(Signal::new(Shape::Steps, vec![(1.0, 0.0), (1.0, 1.0)]), Err(Order { .. })));
        let error = Signal::new(Shape::Linear, vec![(1.0, 0.0), (0.5, 1.0)]).unwrap_err();
        assert_eq!(error.to_string(), "times must not decrease: 0.5 s follows 1 s");
    }
}
