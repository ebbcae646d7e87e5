//! Which numbers an axis shows, and which points of a curve the eye can see.

/// Round values inside a range, about `wanted` of them, and the decimals they need.
pub(super) fn ticks(range: (f64, f64), wanted: f64) -> (Vec<f64>, usize) {
    let raw = (range.1 - range.0) / wanted.max(1.0);
    let power = 10_f64.powf(raw.log10().floor());
    let distance = |step: &f64| (step / raw).ln().abs();
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let step = steps.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(power);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a handful
    let decimals = (-step.log10() - 1e-9).ceil().max(0.0) as usize;
    let mut ticks = Vec::new();
    let mut index = (range.0 / step - 1e-9).ceil();
    while index * step <= range.1 + 1e-9 * step {
        ticks.push(index * step);
        index += 1.0;
    }
    (ticks, decimals)
}

/// Two points per column of pixels, the smallest and the largest, and both ends: what the eye could see of the curve
/// stays.
pub(super) fn decimate(points: &[(f64, f64)], range: (f64, f64), columns: f64) -> Vec<(f64, f64)> {
    let width = (range.1 - range.0) / columns;
    #[allow(clippy::cast_possible_truncation)] // thousands at most
    let column = |x: f64| ((x - range.0) / width).floor() as i64;
    let inside: Vec<_> =
        points.iter().copied().filter(|(x, y)| *x >= range.0 && *x <= range.1 && y.is_finite()).collect();
    let mut kept: Vec<(f64, f64)> = inside.first().copied().into_iter().collect();
    for group in inside.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let by_y = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let mut extremes: Vec<_> =
            [group.iter().min_by(by_y), group.iter().max_by(by_y)].into_iter().flatten().copied().collect();
        extremes.sort_by(|a, b| a.0.total_cmp(&b.0));
        kept.extend(extremes);
    }
    kept.extend(inside.last());
    kept.dedup();
    without_collinear(kept)
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

/// Leaves out points on a horizontal line between their neighbours: settled curves are long and flat.
fn without_collinear(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::with_capacity(points.len());
    for point in points {
        if let [.., before, last] = kept.as_slice()
            && before.1.to_bits() == last.1.to_bits()
            && last.1.to_bits() == point.1.to_bits()
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((0.0, 5.0), 5.0), (vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 0));
        let (values, decimals) = ticks((-0.012, 0.53), 6.0);
        assert_eq!((values.len(), decimals), (6, 1));
        assert_eq!(ticks((0.0, 0.003), 3.0).1, 3);
    }

    #[test]
    fn decimation_keeps_every_peak_and_drops_flat_stretches() {
        let spike = |index: u32| if index == 31_234 { 9.0 } else { f64::from(index % 2) };
        let points: Vec<_> = (0..50_000).map(|index| (f64::from(index) * 1e-4, spike(index))).collect();
        let kept = decimate(&points, (0.0, 5.0), 600.0);
        assert!(kept.len() <= 2 * 601 && kept.iter().any(|(_, y)| *y > 8.0));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[49_999]));
        let flat: Vec<_> = (0..50_000).map(|index| (f64::from(index) * 1e-4, 0.5)).collect();
        assert_eq!(decimate(&flat, (0.0, 5.0), 600.0).len(), 2);
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
