//! How much of each pixel a shape covers: exactly, but for what it covers twice.
//!
//! Every edge leaves in each pixel that it crosses how far it goes down there, and how much of the pixel is to the right of that. The
//! sum of the first from the left gives the pixels that lie between edges, without looking at them one by one. A shape of a chart has
//! few edges, so there are few such cells.

use resvg::tiny_skia::{Path, PathSegment, Transform};

/// How many shades there are between none and all of a pixel.
pub(crate) const LEVELS: u8 = 10;

/// How far in pixels a line may pass a curve.
const CLOSE: f32 = 0.05;

/// A place in pixels, to the right and down.
pub(crate) type Point = (f32, f32);

/// A part of the edges in one pixel.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    row: u32,
    column: u32,
    /// How far they go down, in heights of a pixel.
    down: f32,
    /// How much of the pixel is to the right of them; less where they go up.
    area: f32,
}

/// The edges of one shape.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    /// Size of the picture in pixels.
    size: (f32, f32),
    crossed: Vec<Cell>,
    /// The same by rows.
    sorted: Vec<Cell>,
    /// Where each row begins in it.
    begins: Vec<u32>,
}

impl Cells {
    /// None yet, in a picture of so many columns and rows: what is beyond is not drawn.
    pub(crate) fn new(columns: u32, rows: u32) -> Self {
        Self { size: (columns as f32, rows as f32), ..Self::default() }
    }

    /// Adds an edge. The edges of a shape must be closed.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between zero and the height
    pub(crate) fn edge(&mut self, from: Point, to: Point) {
        let (sign, top, bottom) = if from.1 < to.1 { (1.0, from, to) } else { (-1.0, to, from) };
        let slope = (bottom.0 - top.0) / (bottom.1 - top.1);
        let (mut y, last) = (top.1.max(0.0), bottom.1.min(self.size.1));
        let mut x = if y > top.1 { top.0 + (y - top.1) * slope } else { top.0 };
        let mut row = y as u32;
        while y < last {
            let end = last.min((row + 1) as f32);
            let x_end = if end == bottom.1 { bottom.0 } else { top.0 + (end - top.1) * slope };
            self.within_row(row, x.min(x_end), x.max(x_end), sign * (end - y));
            (x, y, row) = (x_end, end, row + 1);
        }
    }

    /// A part of an edge within a row, from left to right, which goes so far down.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between zero and the width
    fn within_row(&mut self, row: u32, mut left: f32, mut right: f32, mut down: f32) {
        // What is left of the picture has all of it to its right; what is right of it does not count.
        if right <= 0.0 {
            return self.add(Cell { row, column: 0, down, area: down });
        }
        if left < 0.0 {
            let part = down * left / (left - right);
            self.add(Cell { row, column: 0, down: part, area: part });
            (left, down) = (0.0, down - part);
        }
        if left >= self.size.0 {
            return;
        }
        if right > self.size.0 {
            down *= (self.size.0 - left) / (right - left);
            right = self.size.0;
        }
        let (first, last) = (left as u32, right as u32);
        if first == last {
            let area = down * (1.0 - (0.5 * (left + right) - first as f32));
            self.add(Cell { row, column: first, down, area });
            return;
        }
        let slope = down / (right - left);
        let width = (first + 1) as f32 - left;
        self.add(Cell { row, column: first, down: slope * width, area: 0.5 * slope * width * width });
        for column in first + 1..last {
            self.add(Cell { row, column, down: slope, area: 0.5 * slope });
        }
        let width = right - last as f32;
        self.add(Cell { row, column: last, down: slope * width, area: slope * width * (1.0 - 0.5 * width) });
    }

    fn add(&mut self, new: Cell) {
        match self.crossed.last_mut() {
            Some(last) if (last.row, last.column) == (new.row, new.column) => {
                last.down += new.down;
                last.area += new.area;
            }
            _ => self.crossed.push(new),
        }
    }

    /// Adds a closed path.
    pub(crate) fn path(&mut self, path: &Path, transform: Transform) {
        let at = |x: f32, y: f32| {
            let Transform { sx, kx, ky, sy, tx, ty } = transform;
            (sx * x + kx * y + tx, ky * x + sy * y + ty)
        };
        let (mut begin, mut here) = ((0.0, 0.0), (0.0, 0.0));
        for segment in path.segments() {
            match segment {
                PathSegment::MoveTo(p) => {
                    self.edge(here, begin);
                    begin = at(p.x, p.y);
                    here = begin;
                }
                PathSegment::LineTo(p) => {
                    let to = at(p.x, p.y);
                    self.edge(here, to);
                    here = to;
                }
                PathSegment::QuadTo(c, p) => {
                    let (c, to) = (at(c.x, c.y), at(p.x, p.y));
                    let bend = bend(here, c, to);
                    self.curve(here, to, 0.25 * bend, |t| {
                        let weights = [(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t];
                        sum(weights, [here, c, to])
                    });
                    here = to;
                }
                PathSegment::CubicTo(c, d, p) => {
                    let (c, d, to) = (at(c.x, c.y), at(d.x, d.y), at(p.x, p.y));
                    let bend = bend(here, c, d).max(bend(c, d, to));
                    self.curve(here, to, 0.75 * bend, |t| {
                        let u = 1.0 - t;
                        sum([u * u * u, 3.0 * t * u * u, 3.0 * t * t * u, t * t * t], [here, c, d, to])
                    });
                    here = to;
                }
                PathSegment::Close => {
                    self.edge(here, begin);
                    here = begin;
                }
            }
        }
        self.edge(here, begin);
    }

    /// Adds a curve that bends by so many pixels, as lines.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
    fn curve(&mut self, from: Point, to: Point, bend: f32, at: impl Fn(f32) -> Point) {
        let parts = (bend / CLOSE).sqrt().ceil().clamp(1.0, 64.0) as u8;
        let mut before = from;
        for part in 1..parts {
            let here = at(f32::from(part) / f32::from(parts));
            self.edge(before, here);
            before = here;
        }
        self.edge(before, to);
    }

    /// Ends the shape: hands out which pixels it covers, as row, first column, their number and how much of them, of [`LEVELS`].
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the size is that of a picture
    pub(crate) fn cover(&mut self, mut covered: impl FnMut(usize, usize, usize, u8)) {
        let first = self.sort();
        for (index, ends) in self.begins.windows(2).enumerate() {
            let row = first as usize + index;
            let cells = &mut self.sorted[ends[0] as usize..ends[1] as usize];
            sort(cells);
            let (mut down, mut next) = (0.0, 0);
            for same in cells.chunk_by(|a, b| a.column == b.column) {
                let column = same[0].column as usize;
                let (more, area) =
                    same.iter().fold((0.0, 0.0), |(down, area), cell| (down + cell.down, area + cell.area));
                let between = level(down);
                if between > 0 && column > next {
                    covered(row, next, column - next, between);
                }
                let here = level(down + area);
                // The right end of the picture is no column.
                if here > 0 && (column as f32) < self.size.0 {
                    covered(row, column, 1, here);
                }
                (down, next) = (down + more, column + 1);
            }
            let (rest, width) = (level(down), self.size.0 as usize);
            if rest > 0 && next < width {
                covered(row, next, width - next, rest);
            }
        }
        self.crossed.clear();
    }

    /// The same of a rectangle, instead of any shape.
    pub(crate) fn cover_rectangle(&self, low: Point, high: Point, mut covered_by: impl FnMut(usize, usize, usize, u8)) {
        let (left, across) = covered(low.0, high.0, self.size.0);
        let (top, down) = covered(low.1, high.1, self.size.1);
        for (row, down) in down.into_iter().enumerate() {
            let mut column = left;
            for alike in across.chunk_by(|a, b| a == b) {
                let level = level(down * alike[0]);
                if level > 0 {
                    covered_by(top + row, column, alike.len(), level);
                }
                column += alike.len();
            }
        }
    }

    /// Sorts the cells by their rows, and returns the first of these.
    fn sort(&mut self) -> u32 {
        let rows = self.crossed.iter().map(|cell| cell.row);
        let (low, high) = rows.fold((u32::MAX, 0), |(low, high), row| (low.min(row), high.max(row)));
        self.begins.clear();
        if low > high {
            return 0;
        }
        // How many are in the rows above, moved on with each cell of the row.
        self.begins.resize((high - low) as usize + 3, 0);
        for cell in &self.crossed {
            self.begins[(cell.row - low) as usize + 2] += 1;
        }
        let mut above = 0;
        for count in &mut self.begins {
            above += *count;
            *count = above;
        }
        self.sorted.resize(self.crossed.len(), Cell::default());
        for cell in &self.crossed {
            let place = &mut self.begins[(cell.row - low) as usize + 1];
            self.sorted[*place as usize] = *cell;
            *place += 1;
        }
        self.begins.pop();
        low
    }
}

/// So much of a pixel in [`LEVELS`].
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between zero and the levels
fn level(area: f32) -> u8 {
    (area.abs().min(1.0) * f32::from(LEVELS) + 0.5) as u8
}

/// How much of each pixel in a line from 0 to `count` lies between two places, as the first pixel and parts of this and those that follow.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between zero and a count of pixels
fn covered(from: f32, to: f32, count: f32) -> (usize, Vec<f32>) {
    let (from, to) = (from.clamp(0.0, count), to.clamp(0.0, count));
    let first = from as usize;
    let part = |pixel: usize| to.min(pixel as f32 + 1.0) - from.max(pixel as f32);
    (first, (first..to.ceil() as usize).map(part).collect())
}

/// Sorts the cells of a row from left to right. Most are few, and nearly sorted.
fn sort(cells: &mut [Cell]) {
    const FEW: usize = 24;
    if cells.len() > FEW {
        return cells.sort_unstable_by_key(|cell| cell.column);
    }
    for end in 1..cells.len() {
        let mut at = end;
        while at > 0 && cells[at - 1].column > cells[at].column {
            cells.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// How far the middle one of three points is from where the others have it.
fn bend(from: Point, middle: Point, to: Point) -> f32 {
    (from.0 - 2.0 * middle.0 + to.0).abs().max((from.1 - 2.0 * middle.1 + to.1).abs())
}

fn sum<const N: usize>(weights: [f32; N], points: [Point; N]) -> Point {
    let parts = weights.into_iter().zip(points);
    parts.fold((0.0, 0.0), |(x, y), (weight, point)| (x + weight * point.0, y + weight * point.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The levels of a picture of 8 × 4 pixels with this polygon.
    fn levels(corners: &[Point]) -> [[u8; 8]; 4] {
        let mut cells = Cells::new(8, 4);
        for (index, corner) in corners.iter().enumerate() {
            cells.edge(*corner, corners[(index + 1) % corners.len()]);
        }
        let mut levels = [[0; 8]; 4];
        cells.cover(|row, column, count, level| levels[row][column..column + count].fill(level));
        levels
    }

    #[test]
    fn pixels_are_covered_by_the_area_of_the_shape_in_them() {
        let rectangle = levels(&[(1.5, 1.0), (4.25, 1.0), (4.25, 2.5), (1.5, 2.5)]);
        assert_eq!(rectangle, [[0; 8], [0, 5, 10, 10, 3, 0, 0, 0], [0, 3, 5, 5, 1, 0, 0, 0], [0; 8]]);
        // The other way round it is the same.
        let triangle = levels(&[(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)]);
        assert_eq!(triangle, levels(&[(0.0, 4.0), (4.0, 0.0), (0.0, 0.0)]));
        assert_eq!(triangle[1], [10, 10, 5, 0, 0, 0, 0, 0]);
        let flat = levels(&[(0.0, 2.0), (8.0, 2.0), (8.0, 3.0)]);
        assert_eq!(flat[2], [1, 2, 3, 4, 6, 7, 8, 9]);
    }

    #[test]
    fn what_is_beyond_the_picture_is_cut_off_and_odd_numbers_break_nothing() {
        assert_eq!(levels(&[(-9.0, -9.0), (20.0, -9.0), (20.0, 9.0), (-9.0, 9.0)]), [[10; 8]; 4]);
        assert_eq!(levels(&[(-4.0, 0.0), (12.0, 0.0), (12.0, 2.0), (-4.0, 2.0)])[1..3], [[10; 8], [0; 8]]);
        // Half of a pixel on each side.
        let slanted = levels(&[(-2.0, 0.0), (2.0, 4.0), (12.0, 4.0), (8.0, 0.0)]);
        assert_eq!(slanted[2], [5, 10, 10, 10, 10, 10, 10, 10]);
        assert_eq!(slanted[3], [0, 5, 10, 10, 10, 10, 10, 10]);
        for odd in [f32::NAN, f32::INFINITY, f32::MAX] {
            levels(&[(odd, 1.0), (3.0, odd), (odd, odd)]);
            levels(&[(0.0, 0.0), (-odd, 2.0), (odd, 4.0)]);
        }
    }
}
