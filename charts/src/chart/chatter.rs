//! Where a curve swings faster than a picture can show.

use super::Points;
use super::bands::{bins, stretches};

/// Where a curve chatters in a picture of some width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chatter {
    /// Time in the middle of the longest stretch.
    pub at: f64,
    /// How long the stretch is.
    pub span: f64,
    /// How long a swing takes there.
    pub period: f64,
}

/// Where a curve chatters longest in a picture of this width in px, if it does.
#[must_use]
pub fn chatter(points: &Points, range: (f64, f64), width: f64) -> Option<Chatter> {
    let within = points.all().within(range);
    let finite = within.finite();
    let inside = finite.as_ref().map_or(within, Points::all);
    let (low, high) = inside.extremes()?;
    let px = 200.0 / (high - low).max(f64::MIN_POSITIVE);
    let bins = bins(inside, range, px, width);
    let stretches = stretches(&bins, px).into_iter().filter(|(fast, _)| *fast);
    let stretches = stretches.map(|(_, part)| (bins[part.start].left(), bins[part.end - 1].right()));
    let (from, to) = stretches.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    let at = f64::midpoint(from, to);
    // An oscillation must cover a good part of the band's height; a ripple does not count.
    let near = (at, at + (to - from) / 16.0);
    let near = points.all().within(near);
    let (low, high) = near.shown((f64::NEG_INFINITY, f64::INFINITY))?;
    let (mut is_up, mut turns) = (None, 0_u32);
    for y in near.heights() {
        let side = match (y - low) / (high - low) {
            share if share > 0.7 => true,
            share if share < 0.3 => false,
            _ => continue,
        };
        turns += u32::from(is_up.is_some_and(|is_up| is_up != side));
        is_up = Some(side);
    }
    let period = (to - from) / 8.0 / f64::from(turns);
    (turns > 3).then_some(Chatter { at, span: to - from, period })
}
