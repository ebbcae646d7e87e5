//! A curve as lines, and as bands where it swings faster than a picture can show.

use std::ops::Range;

use super::Points;
use super::points::Part;
use super::thinned::{CLOSE, decimate, straightened};

/// Width in px below which one oscillation is too fast to be seen.
const BIN: f64 = 4.0;
/// Smaller swings in px are no thicker than the line.
const SMALLEST: f64 = 3.0;
/// By how many px a curve must have left an extreme to have turned there: the line's own width hides what is less.
const TURN: f64 = 2.0;
/// Fewer bins than this in a row, with a swing or two, show as they are: a dip, a kick, or a ripple that soon is over.
const FEWEST: usize = 4;

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
    points: Part<'a>,
    left: f64,
    right: f64,
    /// The place of the first of them.
    from: usize,
    low: f64,
    high: f64,
    turns: u32,
}

impl Bin<'_> {
    pub(super) fn left(&self) -> f64 {
        self.left
    }
    pub(super) fn right(&self) -> f64 {
        self.right
    }
}

/// A curve as lines, and as bands where it chatters. `size` is that of the plot in px, `y_span` the range of its vertical
/// axis.
pub(super) fn pieces(points: &Points, range: (f64, f64), y_span: f64, size: (f64, f64)) -> Vec<Piece> {
    let within = points.all().within(range);
    let finite = within.finite();
    let inside = finite.as_ref().map_or(within, Points::all);
    let bins = bins(inside, range, size.1 / y_span, size.0);
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
            Piece::Line(decimate(inside.slice(line), range, size.0 * 1.25, CLOSE * y_span / size.1))
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

/// The bins of a curve whose values are finite.
pub(super) fn bins<'a>(points: Part<'a>, range: (f64, f64), px: f64, width: f64) -> Vec<Bin<'a>> {
    #[allow(clippy::cast_possible_truncation)] // thousands at most; no point is left of the range
    let place = |x: f64| ((x - range.0) / (range.1 - range.0) * width / BIN) as i64;
    let mut extreme = points.get(0).map_or(0.0, |first| first.1);
    let mut direction = 0.0;
    let mut from = 0;
    let bin = |points: Part<'a>| {
        let (low, high) = points.extremes().unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
        let mut turns = 0;
        // The farthest that the curve goes on here, and how far it could come back from there.
        let (on, back) = if direction > 0.0 { (high.max(extreme), low) } else { (low.min(extreme), high) };
        let points_that_may_turn = if direction * (back - on) * px < -TURN || direction == 0.0 {
            points
        } else {
            extreme = on;
            points.slice(0..0)
        };
        for y in points_that_may_turn.heights() {
            let left = (y - extreme) * px;
            if if direction == 0.0 { left.abs() > TURN } else { direction * left < -TURN } {
                turns += u32::from(direction != 0.0);
                direction = left.signum();
                extreme = y;
            } else if direction * left > 0.0 {
                extreme = y;
            }
        }
        let [left, right] = [points.get(0), points.last()].map(|end| end.map_or(0.0, |end| end.0));
        let bin = Bin { points, left, right, from, low, high, turns };
        from += points.len();
        bin
    };
    points.columns(place).map(bin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Chatter, chatter};

    #[test]
    fn what_swings_too_fast_is_a_band_and_the_rest_a_line() {
        // 90 Hz in the middle of a ramp of 4 s, 400 px wide: 0.9 swings per px.
        let wave =
            |t: f64| if (1.0..3.0).contains(&t) { 0.2 * (2.0 * std::f64::consts::PI * 90.0 * t).sin() } else { 0.0 };
        let points = (0..=4000).map(|row| f64::from(row) * 1e-3).map(|t| (t, t + wave(t))).collect::<Points>();
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
        let kick: Points = (0..=4000).map(|row| (f64::from(row) * 1e-3, if row == 9 { 9.0 } else { 0.0 })).collect();
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
            let curve = points.iter().copied().collect();
            let pieces = pieces(&curve, (0.0, 5.0), 0.75, (525.0, 350.0));
            let [Piece::Line(line)] = &pieces[..] else { panic!("depth {depth}: {} pieces", pieces.len()) };
            // The dip is all there.
            let fall = |points: &[(f64, f64)]| {
                let fall = |(high, most): (f64, f64), y: f64| (high.max(y), most.max(high - y));
                points.iter().fold((f64::NEG_INFINITY, 0.0), |last, (_, y)| fall(last, *y)).1
            };
            assert!((fall(line) - fall(&points)).abs() < 0.75 / 350.0, "depth {depth}");
            assert_eq!(chatter(&curve, (0.0, 5.0), 400.0), None);
        }
    }
}
