//! Weights in fours that begin at a line of the processor's cache.

use crate::blocks::four::Lanes;
use std::ops::{Deref, DerefMut};

/// A line. Elsewhere every other register would be read from two lines, and the weights of a usual grid would be on 17 lines, not 16.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
struct Line([Lanes; 2]);

/// Weights in fours.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Weights {
    lines: Vec<Line>,
    fours: usize,
}

impl Weights {
    /// As many fours of zeros.
    pub fn zeros(fours: usize) -> Self {
        Self { lines: vec![Line([[0.0; 4]; 2]); fours.div_ceil(2)], fours }
    }
}

impl Clone for Weights {
    fn clone(&self) -> Self {
        Self { lines: self.lines.clone(), fours: self.fours }
    }

    /// The same in the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        if self.lines.len() == source.lines.len() {
            self.lines.copy_from_slice(&source.lines);
            self.fours = source.fours;
        } else {
            *self = source.clone();
        }
    }
}

impl Deref for Weights {
    type Target = [Lanes];

    #[inline]
    fn deref(&self) -> &[Lanes] {
        // SAFETY: a line is two fours without anything between them, and there are as many lines as hold the fours.
        unsafe { std::slice::from_raw_parts(self.lines.as_ptr().cast(), self.fours) }
    }
}

impl DerefMut for Weights {
    #[inline]
    fn deref_mut(&mut self) -> &mut [Lanes] {
        // SAFETY: as above, and nobody else has them.
        unsafe { std::slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast(), self.fours) }
    }
}
