//! Which numbers an axis shows, and which points of a curve the eye can see.

use std::borrow::Cow;
use std::ops::Range;

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
fn columns(mut points: &[(f64, f64)], column: impl Fn(f64) -> i64) -> impl Iterator<Item = &[(f64, f64)]> {
    std::iter::from_fn(move || {
        let here = column(points.first()?.0);
        // A search: columns are few, points many.
        let group;
        (group, points) = points.split_at(points.partition_point(|(x, _)| column(*x) == here));
        Some(group)
    })
}

/// Two points per column of pixels, the smallest and the largest, and both ends: all visible features of the curve remain. Of these
/// points those are left out that are no farther from the line than `close`.
pub(super) fn decimate(points: &[(f64, f64)], range: (f64, f64), count: f64, close: f64) -> Vec<(f64, f64)> {
    let width = (range.1 - range.0) / count;
    #[allow(clippy::cast_possible_truncation)] // thousands at most; what is inside is not left of the range
    let column = |x: f64| ((x - range.0) / width) as i64;
    let inside = within(points, range);
    let mut kept: Vec<(f64, f64)> = inside.first().copied().into_iter().collect();
    for group in columns(inside, column) {
        let (mut low, mut high) = (&group[0], &group[0]);
        for point in group {
            if point.1.total_cmp(&low.1).is_lt() {
                low = point;
            }
            if point.1.total_cmp(&high.1).is_ge() {
                high = point;
            }
        }
        kept.extend(if low.0 <= high.0 { [*low, *high] } else { [*high, *low] });
    }
    kept.extend(inside.last());
    kept.dedup();
    straightened(&kept, close)
}

/// Width in px below which one oscillation is too fast to be seen.
const BIN: f64 = 4.0;
/// Smaller swings in px are no thicker than the line.
const SMALLEST: f64 = 3.0;
/// By how many px a curve must have left an extreme to have turned there: the line's own width hides what is less.
const TURN: f64 = 2.0;
/// Fewer bins than this in a row, with a swing or two, show as they are: a dip, a kick, or a ripple that soon is over.
const FEWEST: usize = 4;

/// By how many px a line may pass a point above or below: less than the half unit by which all coordinates are rounded.
const CLOSE: f64 = 0.03;

/// A piece of a curve.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Piece {
    /// A part that the eye can follow.
    Line(Vec<(f64, f64)>),
    /// Where it swings faster than the picture can show: its upper and its lower edge.
    Band(Vec<(f64, f64)>, Vec<(f64, f64)>),
}

/// Points within a few px, and how often the curve turns there.
pub(super) struct Bin<'a> {
    points: &'a [(f64, f64)],
    /// The place of the first of them.
    from: usize,
    low: f64,
    high: f64,
    turns: u32,
}

impl Bin<'_> {
    pub(super) fn left(&self) -> f64 {
        self.points[0].0
    }
    pub(super) fn right(&self) -> f64 {
        self.points[self.points.len() - 1].0
    }
}

/// A curve as lines, and as bands where it chatters. `size` is that of the plot in px, `y_span` the range of its vertical
/// axis.
pub(super) fn pieces(points: &[(f64, f64)], range: (f64, f64), y_span: f64, size: (f64, f64)) -> Vec<Piece> {
    let inside = inside(points, range);
    let bins = bins(&inside, range, size.1 / y_span, size.0);
    let piece = |(fast, part): (bool, Range<usize>)| {
        let (first, last) = (&bins[part.start], &bins[part.end - 1]);
        if fast {
            let edge = |value: fn(&Bin) -> f64| {
                let middle = bins[part.clone()].iter().map(|bin| (f64::midpoint(bin.left(), bin.right()), value(bin)));
                let ends = [(first.left(), value(first)), (last.right(), value(last))];
                std::iter::once(ends[0]).chain(middle).chain(std::iter::once(ends[1])).collect::<Vec<_>>()
            };
            let edge = |value| straightened(&edge(value), CLOSE * y_span / size.1);
            Piece::Band(edge(|bin| bin.high), edge(|bin| bin.low))
        } else {
            // Lines begin and end where bands do.
            let line = first.from.saturating_sub(1)..(last.from + last.points.len() + 1).min(inside.len());
            // Five columns for four px.
            Piece::Line(decimate(&inside[line], range, size.0 * 1.25, CLOSE * y_span / size.1))
        }
    };
    stretches(&bins, size.1 / y_span).into_iter().map(piece).collect()
}

/// Neighbouring bins, and whether the curve swings fast in them.
pub(super) fn stretches(bins: &[Bin], px: f64) -> Vec<(bool, Range<usize>)> {
    let swings: Vec<bool> = bins.iter().map(|bin| bin.turns >= 2 && (bin.high - bin.low) * px > SMALLEST).collect();
    let swings_at = |index: Option<usize>| index.and_then(|index| swings.get(index)).copied().unwrap_or(false);
    // One calm bin between two others is no calm.
    let mut fast: Vec<bool> = (0..bins.len())
        .map(|index| swings[index] || (swings_at(index.checked_sub(1)) && swings_at(Some(index + 1))))
        .collect();
    for short in fast.chunk_by_mut(|a, b| a == b).filter(|stretch| stretch.len() < FEWEST) {
        short.fill(false);
    }
    let mut from = 0;
    let stretch = |fast: &[bool]| {
        let part = from..from + fast.len();
        from = part.end;
        (fast[0], part)
    };
    fast.chunk_by(|a, b| a == b).map(stretch).collect()
}

pub(super) fn bins<'a>(points: &'a [(f64, f64)], range: (f64, f64), px: f64, width: f64) -> Vec<Bin<'a>> {
    #[allow(clippy::cast_possible_truncation)] // thousands at most; no point is left of the range
    let place = |x: f64| ((x - range.0) / (range.1 - range.0) * width / BIN) as i64;
    let mut extreme = points.first().map_or(0.0, |first| first.1);
    let mut direction = 0.0;
    let mut from = 0;
    let bin = |points: &'a [(f64, f64)]| {
        let (mut low, mut high, mut turns) = (f64::INFINITY, f64::NEG_INFINITY, 0);
        for (_, y) in points {
            (low, high) = (low.min(*y), high.max(*y));
            let left = (y - extreme) * px;
            if if direction == 0.0 { left.abs() > TURN } else { direction * left < -TURN } {
                turns += u32::from(direction != 0.0);
                direction = left.signum();
                extreme = *y;
            } else if direction * left > 0.0 {
                extreme = *y;
            }
        }
        let bin = Bin { points, from, low, high, turns };
        from += points.len();
        bin
    };
    columns(points, place).map(bin).collect()
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

/// Leaves out points that are no more than `close` above or below the line between those that stay: smooth curves need few, settled
/// ones two.
fn straightened(points: &[(f64, f64)], close: f64) -> Vec<(f64, f64)> {
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
    use crate::chart::{Chatter, chatter};

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
        let kept = decimate(&points, (0.0, 5.0), 600.0, 1e-3);
        assert!(kept.len() <= 2 * 601 && kept.iter().any(|(_, y)| *y > 8.0));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[49_999]));
        let flat: Vec<_> = (0..50_000).map(|index| (f64::from(index) * 1e-4, 0.5)).collect();
        assert_eq!(decimate(&flat, (0.0, 5.0), 600.0, 1e-3).len(), 2);
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
    fn what_swings_too_fast_is_a_band_and_the_rest_a_line() {
        // 90 Hz in the middle of a ramp of 4 s, 400 px wide: 0.9 swings per px.
        let wave =
            |t: f64| if (1.0..3.0).contains(&t) { 0.2 * (2.0 * std::f64::consts::PI * 90.0 * t).sin() } else { 0.0 };
        let points: Vec<_> = (0..=4000).map(|row| f64::from(row) * 1e-3).map(|t| (t, t + wave(t))).collect();
        let pieces = pieces(&points, (0.0, 4.0), 5.0, (400.0, 300.0));
        let [Piece::Line(before), Piece::Band(upper, lower), Piece::Line(after)] = &pieces[..] else {
            panic!("{} pieces", pieces.len());
        };
        assert!((upper[0].0 - 1.0).abs() < 0.05 && (upper[upper.len() - 1].0 - 3.0).abs() < 0.05);
        assert!(upper.iter().zip(lower).all(|(u, l)| (u.1 - l.1 - 0.4).abs() < 0.06), "as wide as it swings");
        assert_eq!((before[0], after[after.len() - 1]), ((0.0, 0.0), (4.0, 4.0)));
        let Chatter { at, span, period } = chatter(&points, (0.0, 4.0), 400.0).unwrap();
        assert!((at - 2.0).abs() < 0.05 && (span - 2.0).abs() < 0.1, "{at} {span}");
        // A sixteenth of the stretch has some ten swings, of which the last is cut off.
        assert!((period * 90.0 - 1.0).abs() < 0.1, "{period}");
        let kick: Vec<_> = (0..=4000).map(|row| (f64::from(row) * 1e-3, if row == 9 { 9.0 } else { 0.0 })).collect();
        assert_eq!(chatter(&kick, (0.0, 4.0), 400.0), None);
    }

    #[test]
    fn a_curve_with_a_dip_or_two_is_a_line() {
        // A force that rises within 0.3 s of 5 s, steeper than a bin is wide, and dips while it does; 525 px × 350 px.
        let bump = |t: f64, at: f64, width: f64| (-((t - at) / width).powi(2)).exp();
        for (depth, at, width) in [(0.025, 0.05, 4e-3), (0.05, 0.05, 4e-3), (0.3, 0.05, 8e-3), (0.1, 0.04, 2e-3)] {
            let force = |t: f64| {
                let start = 0.01 * (1.0 - (600.0 * t).cos()) * bump(t, 0.0, 6e-3);
                0.5 * (1.0 - (-t / 0.06).exp()) + start - depth * (bump(t, at, width) + bump(t, at + 0.04, width))
            };
            let points: Vec<_> = (0..=50_000).map(|row| f64::from(row) * 1e-4).map(|t| (t, force(t))).collect();
            let pieces = pieces(&points, (0.0, 5.0), 0.75, (525.0, 350.0));
            let [Piece::Line(line)] = &pieces[..] else { panic!("depth {depth}: {} pieces", pieces.len()) };
            // The dip is all there.
            let fall = |points: &[(f64, f64)]| {
                let fall = |(high, most): (f64, f64), y: f64| (high.max(y), most.max(high - y));
                points.iter().fold((f64::NEG_INFINITY, 0.0), |last, (_, y)| fall(last, *y)).1
            };
            assert!((fall(line) - fall(&points)).abs() < 0.75 / 350.0, "depth {depth}");
            assert_eq!(chatter(&points, (0.0, 5.0), 400.0), None);
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
