//! Signals over common times, as long as they wait to be drawn.

use std::sync::Arc;

use super::Points;
use super::heights::Heights;

/// Signals over common times. Values are kept in single precision: half the memory, and 2⁻²⁴ of a value is a hundredth of the
/// unit in which charts are drawn.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    times: Arc<Vec<f64>>,
    columns: Vec<Signal>,
}

#[derive(Debug, Clone)]
struct Signal {
    name: String,
    heights: Arc<Heights>,
    last: Option<f64>,
}

impl Signals {
    /// Signals over times: their names, values, and the last value with all its digits.
    #[must_use]
    pub fn new(times: Arc<Vec<f64>>, signals: impl IntoIterator<Item = (String, Vec<f32>, Option<f64>)>) -> Self {
        let signal = |(name, values, last)| Signal { name, heights: Arc::new(Heights::new(values)), last };
        Self { times, columns: signals.into_iter().map(signal).collect() }
    }

    /// The times.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The last value of a signal, as it was given.
    #[must_use]
    pub fn last(&self, name: &str) -> Option<f64> {
        self.find(name)?.last
    }

    /// A signal as the points of a curve that is shown from one time to another: `scale` times its values; without a signal of this name
    /// there are none.
    #[must_use]
    pub fn curve(&self, name: &str, scale: f64, (from, to): (f64, f64)) -> Points {
        let times = &self.times;
        let Some(signal) = self.find(name) else { return Points::from_iter([]) };
        let end = |place: usize| place.min(signal.heights.values.len());
        let (first, after) = (times.partition_point(|time| *time < from), times.partition_point(|time| *time <= to));
        Points {
            times: Arc::clone(times),
            heights: Arc::clone(&signal.heights),
            scale,
            part: end(first)..end(after.max(first)),
        }
    }

    fn find(&self, name: &str) -> Option<&Signal> {
        self.columns.iter().find(|signal| signal.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_a_part_of_its_signal() {
        let values = vec![0.1, -0.2, 0.3, 0.4];
        let signals = Signals::new(Arc::new(vec![0.0, 0.1, 0.2, 0.3]), [("a".to_owned(), values, Some(0.4))]);
        let curve = signals.curve("a", 10.0, (0.1, 0.25));
        let points: Vec<_> = (0..curve.all().len()).filter_map(|index| curve.all().get(index)).collect();
        let near =
            |(point, wanted): (&(f64, f64), (f64, f64))| point.0 == wanted.0 && (point.1 - wanted.1).abs() < 1e-6;
        assert!(points.len() == 2 && points.iter().zip([(0.1, -2.0), (0.2, 3.0)]).all(near), "{points:?}");
        assert_eq!((signals.last("a"), signals.last("b")), (Some(0.4), None));
        assert!(signals.curve("b", 1.0, (0.0, 1.0)).first().is_none());
    }
}
