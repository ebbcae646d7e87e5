//! The exact motion over one duration, by matrices.

use super::layout::Layout;
use super::mode::Mode;
use super::series::{Basis, MOST_TERMS, Series};
use crate::kernel::{LANES, Panels, dot};
use std::sync::Arc;

/// The exact motion over one duration.
#[derive(Debug)]
pub(super) struct Piece {
    pub duration: f64,
    /// Increments of (x, Θ, Γ, Ψ) from (x, g, r).
    pub increment: Panels,
    /// Coefficients of both watched signals, one after the other, from (x, g, r).
    pub watched: Panels,
    /// Coefficients of each.
    pub terms: usize,
    /// What decays apart from them.
    pub fading: Option<Fading>,
}

/// A stiff decay over one duration.
#[derive(Debug)]
pub(super) struct Fading {
    /// uᵀ, from (x, g, r).
    pub content: Vec<f64>,
    /// What is watched on each side, of v.
    pub watched: [f64; 2],
    /// μτ.
    pub rate: f64,
}

/// Buffers.
pub(super) type Scratch = [[f64; LANES]; Layout::MOST_PANELS];

/// What a piece did.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// Increments of (x, Θ, Γ, Ψ), then padding.
    pub increment: Scratch,
    /// What is watched on each side, over the piece.
    pub watched: [Series; 2],
}

impl Motion {
    pub fn none() -> Self {
        let zero = Series::new(Basis::Powers, &[]);
        Self { increment: [[0.0; LANES]; Layout::MOST_PANELS], watched: [zero; 2] }
    }
}

impl Piece {
    /// The motion over the piece, from (x, g, r), or from (x, g) if the forces are held.
    pub fn motion(&self, drive: &[f64], motion: &mut Motion) {
        let mut watched = [[0.0; LANES]; (2 * MOST_TERMS).div_ceil(LANES)];
        self.increment.multiply(drive, &mut motion.increment);
        self.watched.multiply(drive, &mut watched);
        let coefficients = watched.as_flattened();
        for (side, series) in motion.watched.iter_mut().enumerate() {
            series.assign(Basis::Legendre, &coefficients[side * self.terms..(side + 1) * self.terms]);
        }
        if let Some(fading) = &self.fading {
            fading.add(drive, motion);
        }
    }

    /// The increments alone.
    pub fn increment(&self, drive: &[f64], increment: &mut Scratch) {
        self.increment.multiply(drive, increment);
    }
}

impl Fading {
    fn add(&self, drive: &[f64], motion: &mut Motion) {
        let content = dot(&self.content, drive);
        for (series, watched) in motion.watched.iter_mut().zip(self.watched) {
            (series.amplitude, series.rate) = (watched * content, self.rate);
        }
    }
}

/// The pieces of the step sizes in use, for all modes, most recent first. Clones share them.
#[derive(Clone, Debug, Default)]
pub(super) struct Cache {
    entries: Vec<(f64, Arc<[Piece; 4]>)>,
}

impl Cache {
    /// The pieces of a duration, made now if it is not among those of the last `capacity` sizes.
    pub fn get(&mut self, modes: &[Mode; 4], duration: f64, capacity: usize) -> Arc<[Piece; 4]> {
        match self.entries.iter().position(|(size, _)| size.to_bits() == duration.to_bits()) {
            Some(0) => (),
            Some(index) => self.entries[..=index].rotate_right(1),
            None => {
                self.entries.truncate(capacity - 1);
                self.entries.insert(0, (duration, Arc::new(modes.each_ref().map(|mode| mode.piece(duration)))));
            }
        }
        self.entries[0].1.clone()
    }
}
