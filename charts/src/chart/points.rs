//! The points of a curve: those that are shown, and how far they go up and down.

use std::ops::Range;
use std::sync::Arc;

use super::heights::Heights;

/// Points from left to right. They are a part of a signal, which they share with it: curves of one signal in several panels and figures
/// take no memory of their own. Heights are kept in single precision and multiplied by a scale: 2⁻²⁴ of a value is a hundredth of the
/// unit in which charts are drawn.
#[derive(Debug, Clone)]
pub struct Points {
    pub(super) times: Arc<Vec<f64>>,
    pub(super) heights: Arc<Heights>,
    pub(super) scale: f64,
    /// Which of the values.
    pub(super) part: Range<usize>,
}

impl Points {
    /// The first one.
    #[must_use]
    pub fn first(&self) -> Option<(f64, f64)> {
        self.all().get(0)
    }

    /// The same with heights above zero.
    #[must_use]
    pub fn magnitudes(&self) -> Self {
        let all = self.all();
        let values = all.values().iter().map(|value| value.abs()).collect();
        Self {
            times: Arc::new(all.times().to_vec()),
            heights: Arc::new(Heights::new(values)),
            scale: self.scale.abs(),
            part: 0..all.len(),
        }
    }

    pub(super) fn all(&self) -> Part<'_> {
        let Self { times, heights, scale, part } = self;
        Part { times, heights, scale: *scale, from: part.start, to: part.end }
    }
}

impl FromIterator<(f64, f64)> for Points {
    #[allow(clippy::cast_possible_truncation)] // as the type says
    fn from_iter<I: IntoIterator<Item = (f64, f64)>>(points: I) -> Self {
        let (times, values): (Vec<f64>, Vec<f32>) = points.into_iter().map(|(x, y)| (x, y as f32)).unzip();
        Self { part: 0..times.len(), times: Arc::new(times), heights: Arc::new(Heights::new(values)), scale: 1.0 }
    }
}

/// Neighbouring points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part<'a> {
    /// Of all points.
    times: &'a [f64],
    heights: &'a Heights,
    scale: f64,
    /// Which points, up to the last but this.
    from: usize,
    to: usize,
}

impl<'a> Part<'a> {
    pub(super) fn len(self) -> usize {
        self.to - self.from
    }

    fn times(self) -> &'a [f64] {
        &self.times[self.from..self.to]
    }

    fn values(self) -> &'a [f32] {
        &self.heights.values[self.from..self.to]
    }

    pub(super) fn get(self, index: usize) -> Option<(f64, f64)> {
        Some((*self.times().get(index)?, self.height(*self.values().get(index)?)))
    }

    pub(super) fn last(self) -> Option<(f64, f64)> {
        self.get(self.len().checked_sub(1)?)
    }

    pub(super) fn slice(self, part: Range<usize>) -> Self {
        Self { from: self.from + part.start, to: (self.from + part.end).min(self.to), ..self }
    }

    /// The heights one after the other.
    pub(super) fn heights(self) -> impl Iterator<Item = f64> + use<'a> {
        self.values().iter().map(move |value| self.height(*value))
    }

    fn height(self, value: f32) -> f64 {
        f64::from(value) * self.scale
    }

    /// Those within a range.
    pub(super) fn within(self, range: (f64, f64)) -> Self {
        let from = self.times().partition_point(|x| *x < range.0);
        self.slice(from..self.times().partition_point(|x| *x <= range.1).max(from))
    }

    /// The finite ones, if not all are.
    pub(super) fn finite(self) -> Option<Points> {
        if self.extremes().is_none_or(|(low, high)| (high - low).is_finite()) {
            return None;
        }
        let finite = |values: (&f64, &f32)| values.1.is_finite().then_some((*values.0, *values.1));
        let (times, values): (Vec<f64>, Vec<f32>) = self.times().iter().zip(self.values()).filter_map(finite).unzip();
        Some(Points {
            part: 0..times.len(),
            times: Arc::new(times),
            heights: Arc::new(Heights::new(values)),
            scale: self.scale,
        })
    }

    /// The smallest and the largest height; they are no numbers if some height is none, and nothing without points.
    pub(super) fn extremes(self) -> Option<(f64, f64)> {
        let (low, high) = self.heights.extremes(self.from..self.to)?;
        Some((self.height(low), self.height(high)))
    }

    /// The smallest and the largest of the finite heights within a range.
    pub(super) fn shown(self, range: (f64, f64)) -> Option<(f64, f64)> {
        let within = self.within(range);
        let (low, high) = within.extremes()?;
        if (high - low).is_finite() { Some((low, high)) } else { within.finite()?.all().extremes() }
    }

    /// The first one of the lowest points and the last one of the highest. All heights are finite.
    pub(super) fn ends(self) -> Option<[(f64, f64); 2]> {
        let (low, high) = self.heights.extremes(self.from..self.to)?;
        let low = self.values().iter().position(|value| *value == low)?;
        let high = self.values().iter().rposition(|value| *value == high)?;
        Some([self.get(low)?, self.get(high)?])
    }

    /// Groups of one column each; `column` rises with the time.
    pub(super) fn columns(self, column: impl Fn(f64) -> i64) -> impl Iterator<Item = Self> {
        let mut rest = self;
        // Most groups are as long as the one before, or one longer or shorter.
        let mut likely = 0_usize;
        std::iter::from_fn(move || {
            let times = rest.times();
            let here = column(*times.first()?);
            let is_here = |x: &f64| column(*x) == here;
            let near = likely.saturating_sub(1).max(1)..(likely + 2).min(rest.len());
            let is_near = near.start < near.end && is_here(&times[near.start - 1]) && !is_here(&times[near.end - 1]);
            let within = if is_near { near } else { 0..rest.len() };
            likely = within.start + times[within].partition_point(is_here);
            let group = rest.slice(0..likely);
            rest = rest.slice(likely..rest.len());
            Some(group)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_are_of_all_points_and_tell_what_is_no_number() {
        let points: Vec<_> = (0..21).map(|index| (f64::from(index), f64::from(index * 13 % 21))).collect();
        let of = |points: &[(f64, f64)]| points.iter().copied().collect::<Points>();
        assert_eq!((of(&points).all().extremes(), of(&[]).all().extremes()), (Some((0.0, 20.0)), None));
        assert!(of(&points).all().finite().is_none());
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for place in [0, 9, 20] {
                let mut points = points.clone();
                points[place].1 = odd;
                assert!(of(&points).all().extremes().is_some_and(|(low, high)| !(high - low).is_finite()));
                let others = points.iter().filter(|(_, y)| y.is_finite());
                let high = others.map(|(_, y)| *y).fold(0.0, f64::max);
                assert_eq!(of(&points).all().shown((0.0, 20.0)).map(|(_, high)| high), Some(high));
                assert_eq!(of(&points).all().finite().map(|points| points.all().len()), Some(20));
            }
        }
    }

    #[test]
    fn heights_are_scaled_and_ends_are_outermost() {
        let points = Points { scale: 10.0, ..[1.0, -2.0, 3.0, -2.0, 3.0].into_iter().zip([0.0; 5]).collect() };
        assert_eq!(points.all().last(), Some((3.0, 0.0)));
        let heights = [3.0, -2.0, 3.0, -2.0, 1.0];
        let points = Points { scale: 10.0, ..(0..5).map(f64::from).zip(heights).collect() };
        assert_eq!(points.first(), Some((0.0, 30.0)));
        assert_eq!(points.all().ends(), Some([(1.0, -20.0), (2.0, 30.0)]));
        assert_eq!(points.all().extremes(), Some((-20.0, 30.0)));
        assert_eq!(points.magnitudes().all().slice(1..5).ends(), Some([(4.0, 10.0), (2.0, 30.0)]));
        assert_eq!(points.all().within((1.0, 2.5)).heights().collect::<Vec<_>>(), [-20.0, 30.0]);
    }

    #[test]
    fn columns_are_found_whatever_their_lengths() {
        // Lengths that are alike, grow and fall, and jump over columns.
        for step in [0.3, 0.33, 1.0, 0.01, 7.5] {
            let at = |index: i32| {
                if index % 50 < 40 { step * f64::from(index) } else { step * f64::from(index - index % 3) }
            };
            let points: Points = (0..400).map(|index| (at(index).max(at(index - 1)), f64::from(index))).collect();
            #[allow(clippy::cast_possible_truncation)]
            let column = |x: f64| (x / 2.0) as i64;
            let groups: Vec<Part> = points.all().columns(column).collect();
            assert_eq!(groups.iter().map(|group| group.len()).sum::<usize>(), 400);
            let ends = |group: &Part| [group.times()[0], group.times()[group.len() - 1]].map(column);
            assert!(groups.iter().all(|group| ends(group)[0] == ends(group)[1]));
            assert!(groups.windows(2).all(|pair| ends(&pair[0])[1] < ends(&pair[1])[0]));
        }
    }
}
