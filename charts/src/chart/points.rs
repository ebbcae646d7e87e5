//! The points of a curve: those that are shown, how far they go up and down, and where they cross a height.

use std::borrow::Cow;

/// The points of a curve that are within a range and finite.
pub(super) fn inside(points: &[(f64, f64)], range: (f64, f64)) -> Cow<'_, [(f64, f64)]> {
    let within = within(points, range);
    if extremes(within).is_none_or(|(low, high)| (high - low).is_finite()) {
        return Cow::Borrowed(within);
    }
    within.iter().copied().filter(|(_, y)| y.is_finite()).collect()
}

/// The points of a curve that are within a range.
pub(super) fn within(points: &[(f64, f64)], range: (f64, f64)) -> &[(f64, f64)] {
    let from = points.partition_point(|(x, _)| *x < range.0);
    &points[from..points.partition_point(|(x, _)| *x <= range.1).max(from)]
}

/// The smallest and the largest value of points; they are no numbers if some value is none, and nothing without points.
pub(super) fn extremes(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    // Side by side, so that one comparison needs not wait for the one before.
    const LANES: usize = 8;
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    // Zero, but for what is no number or infinite.
    let mut odd = [0.0; LANES];
    let (groups, rest) = points.as_chunks::<LANES>();
    let mut take = |lane: usize, y: f64| {
        low[lane] = if y < low[lane] { y } else { low[lane] };
        high[lane] = if y > high[lane] { y } else { high[lane] };
        odd[lane] += y * 0.0;
    };
    for group in groups {
        for (lane, (_, y)) in group.iter().enumerate() {
            take(lane, *y);
        }
    }
    for (_, y) in rest {
        take(0, *y);
    }
    let odd: f64 = odd.iter().sum();
    let low = low.into_iter().fold(f64::INFINITY, f64::min);
    let high = high.into_iter().fold(f64::NEG_INFINITY, f64::max);
    (!points.is_empty()).then_some((low + odd, high + odd))
}

/// The smallest and the largest of the finite values within a range.
pub(super) fn shown(points: &[(f64, f64)], range: (f64, f64)) -> Option<(f64, f64)> {
    let (low, high) = extremes(within(points, range))?;
    if (high - low).is_finite() { Some((low, high)) } else { extremes(&inside(points, range)) }
}

/// Points from left to right in groups of one column each; `column` rises with the time.
pub(super) fn columns(mut points: &[(f64, f64)], column: impl Fn(f64) -> i64) -> impl Iterator<Item = &[(f64, f64)]> {
    std::iter::from_fn(move || {
        let here = column(points.first()?.0);
        // A search: columns are few, points many.
        let group;
        (group, points) = points.split_at(points.partition_point(|(x, _)| column(*x) == here));
        Some(group)
    })
}

/// The pieces of a curve between two heights; each ends where the curve leaves.
pub(super) fn cut(points: &[(f64, f64)], (low, high): (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let is_inside = |y: f64| (low..=high).contains(&y);
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = Vec::new();
    for (index, &(x, y)) in points.iter().enumerate() {
        if let Some(&(x0, y0)) = index.checked_sub(1).and_then(|before| points.get(before)) {
            // Where the way from the point before crosses the heights, in its order.
            let mut crossings: Vec<(f64, f64)> = [low, high]
                .into_iter()
                .filter(|edge| (y0 < *edge) != (y < *edge) && (y0 - y).abs() > 0.0)
                .map(|edge| (x0 + (edge - y0) / (y - y0) * (x - x0), edge))
                .collect();
            if y < y0 {
                crossings.reverse();
            }
            for crossing in crossings {
                piece.push(crossing);
                if piece.len() > 1 && !is_inside(f64::midpoint(crossing.1, y)) {
                    pieces.push(std::mem::take(&mut piece));
                }
            }
        }
        if is_inside(y) {
            piece.push((x, y));
        } else {
            piece.clear();
        }
    }
    pieces.push(piece);
    pieces.retain(|piece| !piece.is_empty());
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_are_of_all_points_and_tell_what_is_no_number() {
        let points: Vec<_> = (0..21).map(|index| (f64::from(index), f64::from(index * 13 % 21))).collect();
        assert_eq!((extremes(&points), extremes(&[])), (Some((0.0, 20.0)), None));
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for place in [0, 9, 20] {
                let mut points = points.clone();
                points[place].1 = odd;
                assert!(extremes(&points).is_some_and(|(low, high)| !(high - low).is_finite()));
                let others = points.iter().filter(|(_, y)| y.is_finite());
                let high = others.map(|(_, y)| *y).fold(0.0, f64::max);
                assert_eq!(shown(&points, (0.0, 20.0)).map(|(_, high)| high), Some(high));
                assert_eq!(inside(&points, (0.0, 20.0)).len(), 20);
            }
        }
    }

    #[test]
    fn curves_are_cut_where_they_leave_the_axis() {
        let points = [(0.0, 4.0), (1.0, 0.0), (2.0, 0.0), (4.0, -4.0), (5.0, -4.0), (6.0, 4.0), (8.0, 0.0)];
        assert_eq!(
            cut(&points, (-1.0, 2.0)),
            [
                vec![(0.5, 2.0), (1.0, 0.0), (2.0, 0.0), (2.5, -1.0)],
                vec![(5.375, -1.0), (5.75, 2.0)],
                vec![(7.0, 2.0), (8.0, 0.0)],
            ]
        );
        assert_eq!(cut(&points[..3], (-9.0, 9.0)), [points[..3].to_vec()]);
    }
}
