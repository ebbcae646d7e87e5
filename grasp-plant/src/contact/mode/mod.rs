//! The exact motion within one mode, and the signals that may end it.
//!
//! A *piece* is a duration τ with matrices of its own: the increment exp(𝒜τ) − I, and for each side the Legendre coefficients
//! over the piece of what is watched there, both linear in what the piece starts from. They come from the values at the nodes
//! of a Gauss rule, which are rows of exp(𝒜t). A ladder of pieces, each twice as long as the one before, makes any duration;
//! what remains below the shortest is the Taylor series itself, whose terms are the signals' coefficients in powers.
//!
//! The ladder begins at ατ ≤ 0.75 and ends at ατ ≤ 24, with the [growth] α of 𝒜: what is left out of the series of degree 17 is
//! below rounding, and so is what lies beyond the coefficients that are kept. A [stiff] decay is apart from all that: α is the growth
//! of the rest, and the signals have an exponential of their own.
//!
//! [growth]: super::growth
//! [stiff]: super::stiff

use super::assembly::{ModeMatrices, Touching};
use super::decay::decay;
use super::growth::growth;
use super::layout::Layout;
use super::piece::{Fading, Motion, Piece, Scratch};
use super::series::{Basis, MOST_TERMS};
use super::stiff::Stiff;
use crate::basis::{gauss, legendre};
use crate::exponential::{TAYLOR_NORM, doubled, exp_m1, orthogonalise};
use crate::kernel::{LANES, Panels, dot};
use nalgebra::{DMatrix, DVector, RowDVector};
use std::sync::OnceLock;

/// Pieces in the ladder.
pub(super) const RUNGS: u32 = 6;

/// Degree of the Taylor series.
const DEGREE: usize = 17;

/// One mode: which sides touch is fixed.
#[derive(Debug)]
pub(super) struct Mode {
    pub touching: Touching,
    layout: Layout,
    matrix: DMatrix<f64>,
    /// 𝒜, for the Taylor series and for rates.
    pub panels: Panels,
    watched: [RowDVector<f64>; 2],
    /// The longest duration for the Taylor series of 𝒜 \[s\].
    taylor: f64,
    stiff: Option<Stiff>,
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
    /// `relaxes`: faces that touch nothing are deformed, and what is watched has an exponential for them.
    pub fn new(touching: Touching, layout: Layout, matrices: ModeMatrices, conservative: bool, relaxes: bool) -> Self {
        let ModeMatrices { matrix, watched, force } = matrices;
        let alpha = growth(&matrix);
        let stiff = if relaxes { None } else { Stiff::of(&matrix, &watched, alpha) };
        Self {
            taylor: within(alpha),
            base: within(stiff.as_ref().map_or(alpha, |stiff| stiff.growth)),
            stiff,
            touching,
            layout,
            panels: Panels::new(&matrix),
            sizes: watched.each_ref().map(|row| row.iter().map(|entry| entry * entry).sum::<f64>().sqrt()),
            watched,
            force,
            conservative,
            ladder: OnceLock::new(),
            matrix,
        }
    }

    /// The longest piece \[s\].
    pub fn longest_piece(&self) -> f64 {
        self.base * f64::from(1u32 << (RUNGS - 1))
    }

    /// What is stiff over a duration: in a short time, nothing is.
    fn stiff_over(&self, duration: f64) -> Option<&Stiff> {
        self.stiff.as_ref().filter(|_| duration > self.taylor)
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
        while part > self.taylor {
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
        let stiff = self.stiff_over(duration);
        let unit = if stiff.is_some() { self.base } else { self.taylor };
        // Bessel functions of half the argument: these many coefficients are above rounding.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 14 and MOST_TERMS")]
        let terms = (14.0 + 1.25 * duration / unit * TAYLOR_NORM).ceil().min((MOST_TERMS - 2) as f64) as usize;
        let rule = gauss(terms);
        // Coefficient m is (2m + 1) ∫ P_m of the signal, by that rule.
        let mut factors = vec![0.0; terms * terms];
        for ((node, weight), factors) in rule.iter().zip(factors.chunks_exact_mut(terms)) {
            for (m, factor) in factors.iter_mut().enumerate() {
                *factor = (2 * m + 1) as f64 * weight * legendre(m, 2.0 * node - 1.0);
            }
        }
        let (rest, rows) = stiff.map_or((&self.matrix, &self.watched), |s| (&s.rest, &s.watched));
        let transposed = Panels::new(&rest.transpose());
        let mut watched = DMatrix::zeros(2 * terms, layout.drive());
        for side in 0..2 {
            let mut row: DVector<f64> = rows[side].transpose();
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
        let fading = stiff.map(|stiff| Fading {
            content: (0..layout.drive()).map(|column| stiff.left[source(column)]).collect(),
            watched: stiff.of_right,
            rate: stiff.rate * duration,
        });
        Piece { duration, increment: Panels::new(&increment), watched: Panels::new(&watched), terms, fading }
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
        let stiff = self.stiff_over(duration);
        let (panels, watched) = stiff.map_or((&self.panels, &self.watched), |s| (&s.panels, &s.watched));
        let mut term: Scratch = [[0.0; LANES]; Layout::MOST_PANELS];
        let mut next: Scratch = term;
        term.as_flattened_mut()[..n].copy_from_slice(&drive[..n]);
        term.as_flattened_mut()[self.layout.force()..size].copy_from_slice(&drive[n..]);
        let content = stiff.map(|stiff| (stiff, dot(stiff.left.as_slice(), term.as_flattened())));
        let mut coefficients = [[0.0; DEGREE + 1]; 2];
        for side in 0..2 {
            coefficients[side][0] = dot(watched[side].as_slice(), term.as_flattened());
        }
        motion.increment = [[0.0; LANES]; Layout::MOST_PANELS];
        for m in 1..=DEGREE {
            panels.multiply(&term.as_flattened()[..size], &mut next);
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
                coefficients[side][m] = dot(watched[side].as_slice(), term.as_flattened());
            }
        }
        for (series, terms) in motion.watched.iter_mut().zip(&coefficients) {
            series.assign(Basis::Powers, terms);
        }
        if let Some((stiff, content)) = content {
            let rate = stiff.rate * duration;
            let gone = content * (1.0 - decay(rate));
            for (increment, right) in motion.increment.as_flattened_mut().iter_mut().zip(stiff.right.iter()) {
                *increment -= gone * right;
            }
            for (series, watched) in motion.watched.iter_mut().zip(stiff.of_right) {
                (series.amplitude, series.rate) = (watched * content, rate);
            }
        }
    }
}

/// The longest power of two, of s and up to one, within which a matrix of this growth is one for a Taylor series.
fn within(growth: f64) -> f64 {
    let mut longest = 1.0;
    while longest * growth > TAYLOR_NORM {
        longest *= 0.5;
    }
    longest
}

#[cfg(test)]
mod tests;
