//! The exact motion within one mode, and the signals that may end it.
//!
//! A *piece* is a duration τ with matrices of its own: the increment exp(𝒜τ) − I, and for each side the Legendre coefficients
//! over the piece of what is watched there, both linear in what the piece starts from. They come from the values at the nodes
//! of a Gauss rule, which are rows of exp(𝒜t). A ladder of pieces, each twice as long as the one before, makes any duration;
//! what remains below the shortest is the Taylor series itself, whose terms are the signals' coefficients in powers.
//!
//! The ladder begins at ατ ≤ 0.75 and ends at ατ ≤ 24, with the [growth] α of 𝒜: what is left out of the series of degree 17 is
//! below rounding, and so is what lies beyond the coefficients that are kept.
//!
//! [growth]: super::growth

use super::assembly::{ModeMatrices, Touching};
use super::growth::growth;
use super::layout::Layout;
use super::series::{Basis, MOST_TERMS, Series};
use crate::basis::{gauss, legendre};
use crate::exponential::{TAYLOR_NORM, doubled, exp_m1, orthogonalise};
use crate::kernel::{LANES, Panels};
use nalgebra::{DMatrix, DVector, RowDVector};
use std::sync::{Arc, OnceLock};

/// Pieces in the ladder.
pub(super) const RUNGS: u32 = 6;

/// Degree of the Taylor series.
const DEGREE: usize = 17;

/// The exact motion over one duration.
#[derive(Debug)]
pub(super) struct Piece {
    pub duration: f64,
    /// Increments of (x, Θ, Γ, Ψ) from (x, g, r).
    increment: Panels,
    /// Coefficients of both watched signals, one after the other, from (x, g, r).
    watched: Panels,
    /// Coefficients of each.
    terms: usize,
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

/// One mode: which sides touch is fixed.
#[derive(Debug)]
pub(super) struct Mode {
    pub touching: Touching,
    layout: Layout,
    matrix: DMatrix<f64>,
    /// 𝒜, for the Taylor series and for rates.
    pub panels: Panels,
    watched: [RowDVector<f64>; 2],
    /// Contact forces by side.
    force: [RowDVector<f64>; 2],
    /// The length of each watched row: times |(x, g)|, what rounding of the signal is measured by.
    pub sizes: [f64; 2],
    conservative: bool,
    /// Duration of the shortest piece \[s\], a power of two.
    base: f64,
    ladder: OnceLock<Vec<Piece>>,
}

impl Mode {
    pub fn new(touching: Touching, layout: Layout, matrices: ModeMatrices, conservative: bool) -> Self {
        let ModeMatrices { matrix, watched, force } = matrices;
        let alpha = growth(&matrix);
        let mut base = 1.0;
        while base * alpha > TAYLOR_NORM {
            base *= 0.5;
        }
        while 2.0 * base * alpha <= TAYLOR_NORM && base < 1.0 {
            base *= 2.0;
        }
        Self {
            touching,
            layout,
            panels: Panels::new(&matrix),
            sizes: watched.each_ref().map(|row| row.iter().map(|entry| entry * entry).sum::<f64>().sqrt()),
            watched,
            force,
            conservative,
            base,
            ladder: OnceLock::new(),
            matrix,
        }
    }

    /// The longest piece \[s\].
    pub fn longest_piece(&self) -> f64 {
        self.base * f64::from(1u32 << (RUNGS - 1))
    }

    /// The contact force at a side, from the extended vector's x and g.
    pub fn force(&self, side: usize, x: &[f64], forces: &[f64]) -> f64 {
        let row = self.force[side].as_slice();
        let of_state: f64 = row.iter().zip(x).map(|(row, x)| row * x).sum();
        let of_forces: f64 = row[self.layout.force()..].iter().zip(forces).map(|(row, g)| row * g).sum();
        of_state + of_forces
    }

    /// exp(𝒜τ) − I.
    fn increment(&self, duration: f64) -> DMatrix<f64> {
        let (mut part, mut doublings) = (duration, 0);
        while part > self.base {
            part *= 0.5;
            doublings += 1;
        }
        let mut increment = exp_m1(&(&self.matrix * part));
        for _ in 0..doublings {
            increment = doubled(&increment);
        }
        if self.conservative && doublings > 0 {
            orthogonalise(&mut increment, self.layout.size());
        }
        increment
    }

    /// A piece of any duration up to the longest.
    pub fn piece(&self, duration: f64) -> Piece {
        let layout = self.layout;
        let n = layout.size();
        // Θ, Γ and Ψ start from zero.
        let source = |column: usize| if column < n { column } else { column - n + layout.force() };
        let whole = self.increment(duration);
        let increment =
            DMatrix::from_fn(layout.increments(), layout.drive(), |row, column| whole[(row, source(column))]);
        // Bessel functions of half the argument: these many coefficients are above rounding.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 14 and MOST_TERMS")]
        let terms = (14.0 + 1.25 * duration / self.base * TAYLOR_NORM).ceil().min((MOST_TERMS - 2) as f64) as usize;
        let rule = gauss(terms);
        // Coefficient m is (2m + 1) ∫ P_m of the signal, by that rule.
        let mut factors = vec![0.0; terms * terms];
        for ((node, weight), factors) in rule.iter().zip(factors.chunks_exact_mut(terms)) {
            for (m, factor) in factors.iter_mut().enumerate() {
                *factor = (2 * m + 1) as f64 * weight * legendre(m, 2.0 * node - 1.0);
            }
        }
        let transposed = Panels::new(&self.matrix.transpose());
        let mut watched = DMatrix::zeros(2 * terms, layout.drive());
        for side in 0..2 {
            let mut row: DVector<f64> = self.watched[side].transpose();
            let mut time = 0.0;
            for ((node, _), factors) in rule.iter().zip(factors.chunks_exact(terms)) {
                self.carry(&transposed, node * duration - time, row.as_mut_slice());
                time = node * duration;
                for (column, coefficients) in watched.as_mut_slice().chunks_exact_mut(2 * terms).enumerate() {
                    let value = row[source(column)];
                    for (coefficient, factor) in coefficients[side * terms..].iter_mut().zip(factors) {
                        *coefficient += factor * value;
                    }
                }
            }
        }
        Piece { duration, increment: Panels::new(&increment), watched: Panels::new(&watched), terms }
    }

    /// z ← exp(matrix·duration) z by its Taylor series, in as many parts as it takes.
    fn carry(&self, matrix: &Panels, duration: f64, z: &mut [f64]) {
        let parts = (duration / self.base).ceil().max(1.0);
        let part = duration / parts;
        let mut scratch = [[0.0; LANES]; Layout::MOST_PANELS];
        let mut i = 0.0;
        while i < parts {
            let mut term = z.to_vec();
            for m in 1..=DEGREE {
                matrix.multiply(&term, &mut scratch);
                for ((term, product), z) in term.iter_mut().zip(scratch.as_flattened()).zip(z.iter_mut()) {
                    *term = product * part / m as f64;
                    *z += *term;
                }
            }
            i += 1.0;
        }
    }

    /// The ladder's pieces, shortest first. They are made when first asked for.
    pub fn ladder(&self) -> &[Piece] {
        self.ladder.get_or_init(|| (0..RUNGS).map(|rung| self.piece(self.base * f64::from(1u32 << rung))).collect())
    }

    /// The longest piece of the ladder that is no longer than this, among its `most` shortest ones, and its place.
    pub fn rung(&self, duration: f64, most: usize) -> Option<(usize, &Piece)> {
        self.ladder().iter().enumerate().take(most).rev().find(|(_, piece)| piece.duration <= duration)
    }

    /// The longest duration for [`Self::short`] \[s\].
    pub fn base(&self) -> f64 {
        self.base
    }

    /// The motion over a duration no longer than the shortest piece, from (x, g, r).
    pub fn short(&self, duration: f64, drive: &[f64], motion: &mut Motion) {
        let (n, size) = (self.layout.size(), self.layout.extended());
        let mut term: Scratch = [[0.0; LANES]; Layout::MOST_PANELS];
        let mut next: Scratch = term;
        term.as_flattened_mut()[..n].copy_from_slice(&drive[..n]);
        term.as_flattened_mut()[self.layout.force()..size].copy_from_slice(&drive[n..]);
        let mut coefficients = [[0.0; DEGREE + 1]; 2];
        let read = |row: &RowDVector<f64>, z: &[f64]| row.iter().zip(z).map(|(row, z)| row * z).sum::<f64>();
        for side in 0..2 {
            coefficients[side][0] = read(&self.watched[side], term.as_flattened());
        }
        motion.increment = [[0.0; LANES]; Layout::MOST_PANELS];
        for m in 1..=DEGREE {
            self.panels.multiply(&term.as_flattened()[..size], &mut next);
            let factor = duration / m as f64;
            for ((term, product), increment) in term
                .as_flattened_mut()
                .iter_mut()
                .zip(next.as_flattened())
                .zip(motion.increment.as_flattened_mut())
                .take(size)
            {
                *term = factor * product;
                *increment += *term;
            }
            for side in 0..2 {
                coefficients[side][m] = read(&self.watched[side], term.as_flattened());
            }
        }
        for (series, terms) in motion.watched.iter_mut().zip(&coefficients) {
            series.assign(Basis::Powers, terms);
        }
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
    }

    /// The increments alone.
    pub fn increment(&self, drive: &[f64], increment: &mut Scratch) {
        self.increment.multiply(drive, increment);
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

#[cfg(test)]
mod tests {
    use super::super::assembly::Assembly;
    use super::*;
    use crate::parameters::{ContactModel, Parameters};

    fn modes(parameters: &Parameters) -> Vec<Mode> {
        let assembly = Assembly::new(parameters);
        [[false, false], [true, false], [false, true], [true, true]]
            .map(|touching| Mode::new(touching, assembly.layout, assembly.mode(touching), false))
            .into()
    }

    /// The Legendre series of each watched signal is that of the exact motion: at the nodes of another rule, by way of the
    /// shortest Taylor steps. Long pieces are put together from short ones.
    #[test]
    fn series_and_increments_are_those_of_the_motion() {
        for (model, order) in
            [(ContactModel::Unilateral, 8), (ContactModel::Compliant, 8), (ContactModel::Unilateral, 15)]
        {
            let parameters = Parameters { contact_model: model, order, ..Parameters::default() };
            for mode in modes(&parameters) {
                let layout = mode.layout;
                let drive: Vec<f64> = (0..layout.drive()).map(|i| (1.0 + i as f64).sin()).collect();
                let mut motion = Motion::none();
                for piece in mode.ladder() {
                    piece.motion(&drive, &mut motion);
                    let watched = motion.watched;
                    let mut z = vec![0.0; layout.extended()];
                    z[..layout.size()].copy_from_slice(&drive[..layout.size()]);
                    z[layout.force()..].copy_from_slice(&drive[layout.size()..]);
                    let start = z.clone();
                    let mut done = 0.0;
                    for node in [0.0, 0.013, 0.37, 0.77, 1.0] {
                        mode.carry(&mode.panels, (node - done) * piece.duration, &mut z);
                        done = node;
                        for side in 0..2 {
                            let exact: f64 = mode.watched[side].iter().zip(&z).map(|(row, z)| row * z).sum();
                            let found = watched[side].value_and_slope(node).0;
                            let scale = mode.sizes[side] * (layout.drive() as f64).sqrt();
                            let error = (found - exact).abs() / scale;
                            assert!(
                                error < 1e-13,
                                "{model:?} {:?} {:e} {node}: {error:e}",
                                mode.touching,
                                piece.duration
                            );
                        }
                    }
                    for (row, increment) in motion.increment.as_flattened()[..layout.increments()].iter().enumerate() {
                        assert!((z[row] - start[row] - increment).abs() < 1e-11, "{row} {increment}");
                    }
                }
            }
        }
    }
}
