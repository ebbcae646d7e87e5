//! The edges of a line through points, with round corners and flat ends.

use crate::cells::{Cells, Point};

/// How far in pixels the sides of a corner may be from its circle.
const CLOSE: f32 = 0.05;

/// A piece of the line.
#[derive(Clone, Copy)]
struct Piece {
    to: Point,
    length: f32,
    /// Its direction, of length one.
    along: Point,
    /// From its middle to its left edge, as one looks along it where y goes up.
    across: Point,
}

impl Piece {
    fn new(from: Point, to: Point, half: f32) -> Option<Self> {
        let (x, y) = (to.0 - from.0, to.1 - from.1);
        let length = (x * x + y * y).sqrt();
        let along = (x / length, y / length);
        (length > 0.0).then_some(Self { to, length, along, across: (-along.1 * half, along.0 * half) })
    }
}

/// Adds a line of this half width in pixels.
pub(crate) fn line(cells: &mut Cells, points: impl IntoIterator<Item = Point>, half: f32) {
    let mut points = points.into_iter();
    let Some(mut from) = points.next() else { return };
    // A chord of this angle is so close to the circle.
    let angle = 2.0 * (2.0 * CLOSE / half.max(CLOSE)).sqrt();
    let straight = angle.cos();
    let mut before: Option<Piece> = None;
    for to in points {
        let Some(piece) = Piece::new(from, to, half) else { continue };
        match &before {
            Some(before) => corner(cells, before, &piece, angle, straight),
            None => cells.edge(minus(from, piece.across), plus(from, piece.across)),
        }
        cells.edge(plus(from, piece.across), plus(to, piece.across));
        cells.edge(minus(to, piece.across), minus(from, piece.across));
        before = Some(piece);
        from = to;
    }
    if let Some(Piece { to, across, .. }) = before {
        cells.edge(plus(to, across), minus(to, across));
    }
}

/// Joins the edges of two pieces, which end and begin at right angles to them.
fn corner(cells: &mut Cells, before: &Piece, after: &Piece, angle: f32, straight: f32) {
    let (at, dot) = (before.to, before.along.0 * after.along.0 + before.along.1 * after.along.1);
    if dot >= straight {
        cells.edge(plus(at, before.across), plus(at, after.across));
        cells.edge(minus(at, after.across), minus(at, before.across));
        return;
    }
    let cross = before.along.0 * after.along.1 - before.along.1 * after.along.0;
    let turn = cross.atan2(dot);
    // One edge takes the short way: through the point where both edges meet, if they are long enough. The parts beyond it, which
    // were or will be added, are taken back by that.
    let side = if turn > 0.0 { 1.0 } else { -1.0 };
    let half = 1.0 / (1.0 + dot);
    let beyond = cross.abs() * half;
    let reach = (before.across.0.hypot(before.across.1)) * beyond;
    let meeting = if reach <= before.length.min(after.length) {
        let across = plus(before.across, after.across);
        (at.0 + side * across.0 * half, at.1 + side * across.1 * half)
    } else {
        at
    };
    let [begin, end] = [before, after].map(|piece| (side * piece.across.0, side * piece.across.1));
    directed(cells, plus(at, begin), meeting, side);
    directed(cells, meeting, plus(at, end), side);
    // The other one goes around.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some dozens
    let parts = (turn.abs() / angle).ceil().clamp(1.0, 64.0) as u16;
    let (sin, cos) = (turn / f32::from(parts)).sin_cos();
    let mut arm = (-begin.0, -begin.1);
    let mut rim = plus(at, arm);
    for part in 1..=parts {
        arm = (arm.0 * cos - arm.1 * sin, arm.0 * sin + arm.1 * cos);
        let next = if part == parts { minus(at, end) } else { plus(at, arm) };
        directed(cells, rim, next, -side);
        rim = next;
    }
}

/// Adds an edge of the left side forwards, one of the right side backwards.
fn directed(cells: &mut Cells, from: Point, to: Point, side: f32) {
    if side > 0.0 {
        cells.edge(from, to);
    } else {
        cells.edge(to, from);
    }
}

fn plus(point: Point, by: Point) -> Point {
    (point.0 + by.0, point.1 + by.1)
}

fn minus(point: Point, by: Point) -> Point {
    (point.0 - by.0, point.1 - by.1)
}
