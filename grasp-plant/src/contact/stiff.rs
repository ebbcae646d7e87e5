//! A mode's fastest decay, apart from the rest.
//!
//! While both tips touch, ΔF is a damper on the tips' masses that the stiffest beams of the discretisation feel most: one real
//! eigenvalue −μ of 𝒜 is far beyond all others (2.4·10⁵ against 6.9·10⁴ 1/s at order 8, 1.2·10⁸ against 4.1·10⁶ 1/s at order 24).
//! What belongs to it decays by itself, with its right and left eigenvectors v and u, uᵀv = 1:
//!
//! ```text
//! e^{𝒜t} = e^{𝒜't} + (e^{−μt} − 1) v uᵀ,    𝒜' = 𝒜 + μ v uᵀ,
//! ```
//!
//! and 𝒜' has 0 in place of −μ. So pieces have to be short for 𝒜' only.

use super::growth::growth;
use crate::kernel::{LANES, Panels, dot};
use nalgebra::{DMatrix, DVector, RowDVector};

/// Powers of 𝒜 after which an eigenvalue is not far enough beyond the others.
const MOST_POWERS: u32 = 200;

/// The longest u, v being 1 long: rounding of the content uᵀz is that of z, times this. It has 34 at order 8, 75 at order 24.
const MOST_OBLIQUE: f64 = 200.0;

/// The fastest decay.
#[derive(Debug)]
pub(super) struct Stiff {
    /// μ \[1/s\].
    pub rate: f64,
    /// v and u.
    pub right: DVector<f64>,
    pub left: DVector<f64>,
    /// 𝒜'.
    pub rest: DMatrix<f64>,
    pub panels: Panels,
    /// Its growth.
    pub growth: f64,
    /// What is watched on each side, w (I − v uᵀ) and w v.
    pub watched: [RowDVector<f64>; 2],
    pub of_right: [f64; 2],
}

impl Stiff {
    /// The fastest decay of a matrix whose growth is `alpha`, if pieces can be twice as long without it.
    pub fn of(matrix: &DMatrix<f64>, watched: &[RowDVector<f64>; 2], alpha: f64) -> Option<Self> {
        let (eigenvalue, right) = dominant(matrix).filter(|(eigenvalue, _)| *eigenvalue < 0.0)?;
        let (_, left) = dominant(&matrix.transpose())?;
        let left = &left / dot(left.as_slice(), right.as_slice());
        let of_right = watched.each_ref().map(|row| dot(row.as_slice(), right.as_slice()));
        // Rounding of what is watched, in units that the search has 64 of.
        let coarse = |side: usize| of_right[side].abs() * left.norm() > 8.0 * watched[side].norm();
        if left.norm() > MOST_OBLIQUE || coarse(0) || coarse(1) {
            return None;
        }
        let rest = matrix - (&right * eigenvalue) * left.transpose();
        let growth = growth(&rest);
        if 2.0 * growth > alpha {
            return None;
        }
        let watched = [0, 1].map(|side| &watched[side] - left.transpose() * of_right[side]);
        Some(Self { rate: -eigenvalue, panels: Panels::new(&rest), right, left, rest, growth, watched, of_right })
    }
}

/// The eigenvalue of largest magnitude and its eigenvector of length 1, by powers: if it is real, and far enough beyond the others.
fn dominant(matrix: &DMatrix<f64>) -> Option<(f64, DVector<f64>)> {
    let n = matrix.nrows();
    let panels = Panels::new(matrix);
    let mut vector = DVector::from_fn(n, |i, _| 1.0 + (i % 3) as f64);
    let mut scratch = vec![[0.0; LANES]; panels.panel_count()];
    // Powers go on until rounding stops them: the residual is an error of all that is watched, up to μτ|u| times.
    let mut best: Option<(f64, f64, DVector<f64>)> = None;
    for _ in 0..MOST_POWERS {
        vector /= vector.norm();
        panels.multiply(vector.as_slice(), &mut scratch);
        let next = DVector::from_column_slice(&scratch.as_flattened()[..n]);
        let eigenvalue = dot(vector.as_slice(), next.as_slice());
        // A matrix without growth has no stiff part.
        if eigenvalue == 0.0 {
            return None;
        }
        let residual = (&next - &vector * eigenvalue).norm() / eigenvalue.abs();
        if residual <= 1e-14 {
            if best.as_ref().is_some_and(|(least, ..)| residual > 0.9 * least) {
                break;
            }
            best = Some((residual, eigenvalue, vector));
        }
        vector = next;
    }
    best.map(|(_, eigenvalue, vector)| (eigenvalue, vector))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_decay_is_found_and_taken_away() {
        // A decay of 10⁶ 1/s beside an oscillation, in oblique coordinates.
        let mixing = DMatrix::from_row_slice(3, 3, &[1.0, 0.3, -0.2, 0.1, 1.0, 0.5, -0.4, 0.2, 1.0]);
        let inverse = mixing.clone().try_inverse().unwrap();
        let oscillator = [0.0, 300.0, 0.0, -300.0, 0.0, 0.0, 0.0, 0.0];
        let matrix = |decay: f64| {
            let diagonal: Vec<f64> = oscillator.iter().copied().chain([-decay]).collect();
            &mixing * DMatrix::from_row_slice(3, 3, &diagonal) * &inverse
        };
        let watched = [RowDVector::from_row_slice(&[1.0, 0.0, 0.0]), RowDVector::from_row_slice(&[0.0, 0.0, 1.0])];
        let far = matrix(1e6);
        let stiff = Stiff::of(&far, &watched, growth(&far)).unwrap();
        assert!((stiff.rate - 1e6).abs() < 1e-6, "{}", stiff.rate);
        assert!(stiff.growth < 1e3, "{}", stiff.growth);
        assert!((&stiff.rest * &stiff.right).norm() < 1e-8);
        for side in 0..2 {
            assert!((stiff.of_right[side] - dot(watched[side].as_slice(), stiff.right.as_slice())).abs() < 1e-15);
            assert!((&stiff.watched[side] * &stiff.right)[0].abs() < 1e-15);
        }
        // To rounding, also where each power takes away only two thirds of the rest.
        let slow = matrix(1000.0);
        let (eigenvalue, vector) = dominant(&slow).unwrap();
        let residual = (&slow * &vector - &vector * eigenvalue).norm() / eigenvalue.abs();
        assert!(residual < 1e-15, "{residual:e}");
        // Neither one that is near, nor one that grows, nor an oscillation.
        for near in [400.0, -1e6, 0.0] {
            assert!(Stiff::of(&matrix(near), &watched, growth(&matrix(near))).is_none(), "{near}");
        }
    }
}
