//! Signals over common times, as long as they wait to be drawn.

use std::sync::Arc;

/// Signals over common times. Values are kept in single precision: half the memory, and 2⁻²⁴ of a value is a hundredth of the
/// unit in which charts are drawn.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    times: Vec<f64>,
    columns: Vec<Signal>,
}

#[derive(Debug, Clone)]
struct Signal {
    name: String,
    values: Vec<f32>,
    last: Option<f64>,
}

impl Signals {
    /// Signals with their names, as long as the times.
    #[must_use]
    pub fn new(times: Vec<f64>, columns: impl IntoIterator<Item = (String, Vec<f64>)>) -> Self {
        let mut signals = Self { times, columns: Vec::new() };
        for (name, values) in columns {
            signals.add(name, &values);
        }
        signals
    }

    /// And further ones, which already are in single precision.
    #[must_use]
    pub fn and(mut self, columns: impl IntoIterator<Item = (String, Vec<f32>)>) -> Self {
        for (name, values) in columns {
            let last = values.last().copied().map(f64::from);
            self.columns.push(Signal { name, values, last });
        }
        self
    }

    /// A function of its own, which is compiled here and not by the caller.
    #[allow(clippy::cast_possible_truncation)] // as the type says
    fn add(&mut self, name: String, values: &[f64]) {
        let (last, values) = (values.last().copied(), values.iter().map(|value| *value as f32).collect());
        self.columns.push(Signal { name, values, last });
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
    pub fn curve(&self, name: &str, scale: f64, (from, to): (f64, f64)) -> Arc<[(f64, f64)]> {
        let times = &self.times;
        let shown = times.partition_point(|time| *time < from)..times.partition_point(|time| *time <= to);
        let values = self.find(name).and_then(|signal| signal.values.get(shown.clone())).unwrap_or_default();
        times[shown].iter().copied().zip(values.iter().map(|value| f64::from(*value) * scale)).collect()
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
        let signals = Signals::new(vec![0.0, 0.1, 0.2, 0.3], [("a".to_owned(), vec![0.1, -0.2, 0.3, 0.4])]);
        let curve = signals.curve("a", 10.0, (0.1, 0.25));
        let near =
            |(point, wanted): (&(f64, f64), (f64, f64))| point.0 == wanted.0 && (point.1 - wanted.1).abs() < 1e-6;
        assert!(curve.len() == 2 && curve.iter().zip([(0.1, -2.0), (0.2, 3.0)]).all(near), "{curve:?}");
        assert_eq!(
            (signals.last("a"), signals.last("b"), signals.curve("b", 1.0, (0.0, 1.0)).len()),
            (Some(0.4), None, 0)
        );
    }
}
