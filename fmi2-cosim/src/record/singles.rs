//! [Columns at every step, in single precision](Singles).

use super::{Column, Points};

/// Some columns at every communication point of a run. They are kept in single precision, which is half the memory and enough for
/// pictures.
#[derive(Debug, Default)]
pub struct Singles {
    signals: Vec<Single>,
}

/// One of the columns.
#[derive(Debug)]
pub struct Single {
    /// Which one.
    pub column: Column,
    /// Its values.
    pub values: Vec<f32>,
    /// The last one, with all its digits.
    pub last: Option<f64>,
    /// Its place in a row.
    place: usize,
    /// Whether only the last value is kept.
    is_last_only: bool,
}

impl Singles {
    /// Those of `columns` that `wanted` accepts, with room for so many communication points: what grows little by little takes up to
    /// three times the memory for a while.
    pub fn new(columns: &[Column], wanted: impl Fn(&str) -> bool, points: usize) -> Self {
        let single = |(place, column): (usize, &Column)| {
            wanted(&column.name).then(|| Single {
                column: column.clone(),
                values: Vec::with_capacity(points),
                last: None,
                place,
                is_last_only: false,
            })
        };
        Self { signals: columns.iter().enumerate().filter_map(single).collect() }
    }

    /// The same, but of those that `wanted` accepts only the last value is kept.
    #[must_use]
    pub fn with_last_only(mut self, wanted: impl Fn(&str) -> bool) -> Self {
        for signal in self.signals.iter_mut().filter(|signal| wanted(&signal.column.name)) {
            signal.is_last_only = true;
            signal.values = Vec::new();
        }
        self
    }

    /// Adds the values at the next communication points, as far as these have the columns.
    #[allow(clippy::cast_possible_truncation)] // that is what they are kept for
    pub fn extend(&mut self, points: &Points) {
        for signal in &mut self.signals {
            let Some(values) = points.column(signal.place) else { continue };
            if !signal.is_last_only {
                signal.values.extend(values.iter().map(|value| *value as f32));
            }
            signal.last = values.last().copied().or(signal.last);
        }
    }

    /// What was kept.
    #[must_use]
    pub fn into_signals(self) -> Vec<Single> {
        self.signals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_in_every_column() {
        let columns = ["a", "b", "c"].map(|name| Column { name: name.into(), ..Column::default() });
        for count in [0_u32, 1, 127, 128, 129, 1000] {
            let mut singles = Singles::new(&columns, |_| true, usize::try_from(count).unwrap());
            singles = singles.with_last_only(|name| name == "b");
            let mut points = Points::new(vec![0, 1, 2]);
            for point in 0..count {
                let value = f64::from(point);
                if points.push(value, &[value + 0.1, 7.0, -value]) {
                    singles.extend(&points);
                    points.clear();
                }
            }
            singles.extend(&points);
            let signals = singles.into_signals();
            let [a, b, c] = &signals[..] else { panic!("{} columns", signals.len()) };
            assert_eq!([a, b, c].map(|signal| signal.column.name.as_str()), ["a", "b", "c"]);
            assert_eq!((b.values.len(), b.last), (0, (count > 0).then_some(7.0)));
            #[allow(clippy::cast_possible_truncation)]
            let are = |single: &Single, value: fn(f64) -> f64| {
                let wanted = (0..count).map(|point| value(f64::from(point)));
                single.last == wanted.clone().next_back()
                    && single.values.iter().copied().eq(wanted.map(|value| value as f32))
            };
            assert!(are(a, |time| time + 0.1) && are(c, |time| -time));
        }
    }
}
