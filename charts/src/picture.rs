//! A picture of few colours while it is drawn: each pixel is the place of its colour in a list.
//!
//! That takes half the memory of colours themselves, and what a brush makes of a colour has to be computed only once. Shades are
//! counted in [`LEVELS`]: edges of charts need no more, and fewer colours make smaller files.

use std::collections::HashMap;
use std::ops::Range;

use crate::cells::LEVELS;
use crate::indexed::{Indexed, MOST};

/// Most pictures have no more pixels than this.
const USUAL: usize = 1 << 21;

/// Red, green and blue.
pub(crate) type Color = [u8; 3];

/// Rows of pixels.
#[derive(Debug)]
pub(crate) struct Picture {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pixels: Vec<u16>,
    colors: Vec<Color>,
    places: HashMap<Color, u16>,
    brushes: Vec<Brush>,
}

/// A colour to draw with.
#[derive(Debug)]
struct Brush {
    color: Color,
    /// Of 255.
    opacity: u8,
    /// The place of the colour itself, once it is needed.
    place: Option<u16>,
    /// For each colour and level what comes out, plus one; zero until it is known.
    over: Vec<u16>,
}

impl Picture {
    /// A picture of one colour, in memory that may have been used before.
    pub(crate) fn new(columns: u32, rows: u32, color: Color, mut memory: Vec<u16>) -> Option<Self> {
        let (columns, rows) = (usize::try_from(columns).ok()?, usize::try_from(rows).ok()?);
        let count = columns.checked_mul(rows).filter(|count| *count > 0)?;
        if memory.capacity() < count {
            // To make it longer would copy what is in it. What is never used of the new memory costs nothing.
            memory = Vec::new();
            memory.try_reserve_exact(count.max(USUAL)).ok()?;
        }
        memory.clear();
        memory.resize(count, 0);
        let places = HashMap::from([(color, 0)]);
        Some(Self { columns, rows, pixels: memory, colors: vec![color], places, brushes: Vec::new() })
    }

    /// The brush of a colour with an opacity of 255.
    pub(crate) fn brush(&mut self, color: Color, opacity: u8) -> usize {
        let known = self.brushes.iter().position(|brush| (brush.color, brush.opacity) == (color, opacity));
        known.unwrap_or_else(|| {
            self.brushes.push(Brush { color, opacity, place: None, over: Vec::new() });
            self.brushes.len() - 1
        })
    }

    /// Lays a brush over neighbouring pixels of a row, this many [`LEVELS`] thick, at least one.
    ///
    /// # Panics
    /// When there are no such pixels, or there is no such brush.
    pub(crate) fn lay(&mut self, brush: usize, row: usize, columns: Range<usize>, level: u8) {
        let begin = row * self.columns;
        let pixels = begin + columns.start..begin + columns.end;
        if level == LEVELS && self.brushes[brush].opacity == u8::MAX {
            let place = match self.brushes[brush] {
                Brush { place: Some(place), .. } => place,
                Brush { color, .. } => self.place(color),
            };
            self.brushes[brush].place = Some(place);
            self.pixels[pixels].fill(place);
            return;
        }
        // Most pixels are like the one before.
        let mut last: Option<(u16, u16)> = None;
        for at in pixels {
            let before = self.pixels[at];
            let after = match last {
                Some((same, after)) if same == before => after,
                _ => self.over(brush, before, level),
            };
            last = Some((before, after));
            self.pixels[at] = after;
        }
    }

    /// The same for one pixel.
    ///
    /// # Panics
    /// When there is no such pixel, or there is no such brush.
    #[inline]
    pub(crate) fn lay_one(&mut self, brush: usize, row: usize, column: usize, level: u8) {
        let at = row * self.columns + column;
        self.pixels[at] = self.over(brush, self.pixels[at], level);
    }

    /// The place of what a brush makes of the colour at a place.
    #[inline]
    fn over(&mut self, brush: usize, before: u16, level: u8) -> u16 {
        let at = usize::from(before) * usize::from(LEVELS) + usize::from(level) - 1;
        match self.brushes[brush].over.get(at) {
            Some(known) if *known > 0 => known - 1,
            _ => self.mixed(brush, before, level, at),
        }
    }

    /// The same, where it is not known yet.
    fn mixed(&mut self, brush: usize, before: u16, level: u8, at: usize) -> u16 {
        let Brush { color, opacity, .. } = self.brushes[brush];
        let part = f32::from(level) / f32::from(LEVELS) * f32::from(opacity) / 255.0;
        let under = self.colors[usize::from(before)];
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 255
        let mix = |before: u8, with: u8| (f32::from(before) * (1.0 - part) + f32::from(with) * part + 0.5) as u8;
        let place = self.place(std::array::from_fn(|part| mix(under[part], color[part])));
        let over = &mut self.brushes[brush].over;
        if over.len() <= at {
            over.resize((usize::from(before) + 1) * usize::from(LEVELS), 0);
        }
        over[at] = place + 1;
        place
    }

    /// The place of a colour. Of more colours than any chart has, the last one stands for the others.
    fn place(&mut self, color: Color) -> u16 {
        if let Some(known) = self.places.get(&color) {
            return *known;
        }
        let count = self.colors.len();
        if count <= MOST {
            self.colors.push(color);
        }
        let place = u16::try_from(count.min(MOST)).unwrap_or_default();
        self.places.insert(color, place);
        place
    }

    /// The picture with a palette, if one can stand for its colours; and the memory for another one.
    pub(crate) fn indexed(self, bytes: Vec<u8>) -> (Option<Indexed>, Vec<u16>) {
        (Indexed::of(self.columns, &self.pixels, &self.colors, bytes), self.pixels)
    }

    /// The colour of a pixel.
    #[cfg(test)]
    pub(crate) fn color(&self, column: usize, row: usize) -> Color {
        self.colors[usize::from(self.pixels[row * self.columns + column])]
    }
}
