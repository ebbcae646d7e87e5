//! Which points of a curve the eye can tell from the line through the others.

use super::points::Part;

/// By how many px a line may pass a point above or below: less than the half unit by which all coordinates are rounded.
pub(super) const CLOSE: f64 = 0.03;

/// Two points per column of pixels, the smallest and the largest, and both ends: all visible features of the curve remain. Of these
/// points those are left out that are no farther from the line than `close`. All values are finite.
pub(super) fn decimate(points: Part, range: (f64, f64), count: f64, close: f64) -> Vec<(f64, f64)> {
    let width = (range.1 - range.0) / count;
    #[allow(clippy::cast_possible_truncation)] // thousands at most; what is inside is not left of the range
    let column = |x: f64| ((x - range.0) / width) as i64;
    let inside = points.within(range);
    let mut kept: Vec<(f64, f64)> = inside.get(0).into_iter().collect();
    for [low, high] in inside.columns(column).filter_map(Part::ends) {
        kept.extend(if low.0 <= high.0 { [low, high] } else { [high, low] });
    }
    kept.extend(inside.last());
    kept.dedup();
    straightened(&kept, close)
}

/// Leaves out points that are no more than `close` above or below the line between those that stay: smooth curves need few, settled
/// ones two.
pub(super) fn straightened(points: &[(f64, f64)], close: f64) -> Vec<(f64, f64)> {
    let Some((first, others)) = points.split_first() else { return Vec::new() };
    let mut kept = vec![*first];
    let (mut from, mut last) = (*first, *first);
    // Slopes of the lines from the point that stays that pass all since then.
    let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
    for point in others {
        let slope = |y: f64| (y - from.1) / (point.0 - from.0);
        let is_straight = point.0 > last.0 && (least..=most).contains(&slope(point.1));
        if !is_straight && last != from {
            kept.push(last);
            from = last;
            (least, most) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let slope = |y: f64| (y - from.1) / (point.0 - from.0);
        (least, most) = (least.max(slope(point.1 - close)), most.min(slope(point.1 + close)));
        last = *point;
    }
    if last != from {
        kept.push(last);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::Points;

    #[test]
    fn decimation_keeps_every_peak_and_drops_flat_stretches() {
        let spike = |index: u32| if index == 31_234 { 9.0 } else { f64::from(index % 2) };
        let points: Vec<_> = (0..50_000).map(|index| (f64::from(index) * 1e-4, spike(index))).collect();
        let decimate = |points: &[(f64, f64)]| {
            let points: Points = points.iter().copied().collect();
            super::decimate(points.all(), (0.0, 5.0), 600.0, 1e-3)
        };
        let kept = decimate(&points);
        assert!(kept.len() <= 2 * 601 && kept.iter().any(|(_, y)| *y > 8.0));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[49_999]));
        let flat: Vec<_> = (0..50_000).map(|index| (f64::from(index) * 1e-4, 0.5)).collect();
        assert_eq!(decimate(&flat).len(), 2);
    }

    #[test]
    fn lines_pass_close_to_all_points_that_are_left_out() {
        let wave: Vec<_> = (0..2000).map(|index| f64::from(index) * 1e-3).map(|x| (x, (7.0 * x * x).sin())).collect();
        let kept = straightened(&wave, 1e-3);
        assert!(kept.len() < 400 && kept.iter().all(|point| wave.contains(point)), "{}", kept.len());
        assert_eq!((kept[0], kept[kept.len() - 1]), (wave[0], wave[1999]));
        for (x, y) in &wave {
            let end = kept.partition_point(|(end, _)| end < x).max(1);
            let ((x0, y0), (x1, y1)) = (kept[end - 1], kept[end]);
            assert!((y0 + (x - x0) / (x1 - x0) * (y1 - y0) - y).abs() <= 1.000_001e-3);
        }
        // What jumps back and forth at one time keeps all its points.
        let jumps = [(0.0, 0.0), (0.0, 5.0), (0.0, 3.0), (1.0, 3.0), (1.0, -9.0), (1.0, 2.0)];
        assert_eq!(straightened(&jumps, 1e-3), jumps);
        assert_eq!((straightened(&jumps[..1], 1.0).len(), straightened(&[], 1.0).len()), (1, 0));
    }
}
