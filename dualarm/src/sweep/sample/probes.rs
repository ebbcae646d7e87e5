//! Values that stand for all draws of a parameter, so that a range which an FMU does not allow is found before the first run.

use fmi2_import::Value;

use super::{Sampler, at, on_grid};
use crate::sweep::study::{Coordinates, Method, Range};

/// Coordinates between which nine tenths of the draws are.
const MIDDLE: [f64; 2] = [0.05, 0.95];
/// A coordinate at which a range between whole numbers hardly has one.
const BETWEEN: f64 = 0.37;

impl Sampler {
    /// Whether the values of a parameter are those of a table.
    #[must_use]
    pub fn is_from_table(&self, parameter: usize) -> bool {
        self.method == Method::Table
            && self.coordinates == Coordinates::Values
            && self.vary[parameter].range != Range::Seed
    }

    /// Values of a parameter that an FMU has to allow: all that a table, a list or a grid has, otherwise both ends of a range and one
    /// between. Of a normal distribution and of seeds it is the middle nine tenths: few draws are beyond, and these are a matter of
    /// their runs.
    #[must_use]
    pub fn probes(&self, parameter: usize) -> Box<dyn Iterator<Item = Value> + '_> {
        let varied = &self.vary[parameter];
        if self.is_from_table(parameter) {
            return Box::new(self.columns[parameter].iter().cloned());
        }
        match &varied.range {
            Range::Values(values) => Box::new(values.iter().cloned()),
            #[allow(clippy::cast_possible_truncation)] // parts of it
            Range::Seed => Box::new(MIDDLE.into_iter().map(|part| Value::Integer((part * f64::from(i32::MAX)) as i32))),
            range @ Range::Normal { .. } => Box::new(MIDDLE.into_iter().map(|coordinate| at(range, coordinate))),
            range if self.method == Method::Grid => {
                Box::new((0..varied.count).map(|digit| at(range, on_grid(range, digit, varied.count))))
            }
            range => Box::new([0.0, 1.0, BETWEEN].into_iter().map(|coordinate| at(range, coordinate))),
        }
    }

    /// The smallest and the largest number that a parameter gets in any draw, if its range has two ends that draws need not reach.
    #[must_use]
    pub fn drawn_ends(&self, parameter: usize) -> Option<[Value; 2]> {
        let has_ends = matches!(self.vary[parameter].range, Range::Linear { .. } | Range::Logarithmic { .. });
        if !has_ends || self.method == Method::Grid || self.is_from_table(parameter) {
            return None;
        }
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for draw in 0..self.draws {
            if let Value::Real(number) = self.values(draw)[parameter] {
                ends = [ends[0].min(number), ends[1].max(number)];
            }
        }
        Some(ends.map(Value::Real))
    }
}
