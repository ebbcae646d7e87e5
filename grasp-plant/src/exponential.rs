//! exp(X) − I of a matrix, without the I.
//!
//! nalgebra's `exp` computes exp(X) itself. There the increments of slow motions lose their digits to the 1 on the
//! diagonal, and the steps of this plant need these digits. So this module computes the increment D with nalgebra's
//! matrices, by a polynomial and doublings: exp(2X) − I is 2D + D².

use crate::kernel::product;
use nalgebra::DMatrix;

/// Norm at which the remainder of the degree-16 Taylor polynomial of exp is below the rounding unit: 0.75¹⁷/17! = 2·10⁻¹⁷.
pub(crate) const TAYLOR_NORM: f64 = 0.75;

/// exp(X) − I for powers of X that are not above those of [`TAYLOR_NORM`] from the twelfth on, as those of ‖X‖ ≤ [`TAYLOR_NORM`] are: the Taylor polynomial of degree 16 by Paterson and Stockmeyer, six products.
pub(crate) fn exp_m1(x: &DMatrix<f64>) -> DMatrix<f64> {
    let coefficient: [f64; 17] = {
        let mut c = [1.0; 17];
        for m in 1..17 {
            c[m] = c[m - 1] / m as f64;
        }
        c
    };
    let squared = product(x, x);
    let cubed = product(&squared, x);
    let fourth = product(&squared, &squared);
    let cubic_part =
        |first: usize| x * coefficient[first + 1] + &squared * coefficient[first + 2] + &cubed * coefficient[first + 3];
    let mut sum = cubic_part(12) + &fourth * coefficient[16];
    for first in [8, 4, 0] {
        // sum ← x⁴ (c_{first+4} + sum) + c_{first+1} x + c_{first+2} x² + c_{first+3} x³
        for i in 0..sum.nrows() {
            sum[(i, i)] += coefficient[first + 4];
        }
        sum = product(&fourth, &sum) + cubic_part(first);
    }
    sum
}

/// exp(2X) − I from D = exp(X) − I.
pub(crate) fn doubled(increment: &DMatrix<f64>) -> DMatrix<f64> {
    product(increment, increment) + increment * 2.0
}

/// One Newton–Schulz step towards the nearest orthogonal Φ = I + D, on the leading n × n block of D:
/// with E = D + Dᵀ + DᵀD = ΦᵀΦ − I, Φ ← Φ (I − E/2).
pub(crate) fn orthogonalise(increment: &mut DMatrix<f64>, n: usize) {
    let mut leading = increment.view_mut((0, 0), (n, n));
    let block = leading.clone_owned();
    let transposed = block.transpose();
    let defect = product(&transposed, &block) + (&block + &transposed);
    let excess = product(&block, &defect) + defect;
    leading -= excess * 0.5;
}

/// The largest sum of magnitudes in a column.
pub(crate) fn one_norm(matrix: &DMatrix<f64>) -> f64 {
    matrix.column_iter().map(|column| column.iter().map(|entry| entry.abs()).sum()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// exp(θ [0 −1; 1 0]) − I has cos θ − 1 = −2 sin²(θ/2) on its diagonal and ±sin θ beside it: also for angles whose
    /// cosine is 1 to the last bit.
    #[test]
    fn small_rotations_keep_all_their_digits() {
        for angle in [1e-12_f64, 1e-9, 1e-4, 0.1, 0.7] {
            let increment = exp_m1(&DMatrix::from_row_slice(2, 2, &[0.0, -angle, angle, 0.0]));
            let cosine_less_one = -2.0 * (angle / 2.0).sin().powi(2);
            for i in 0..2 {
                assert!((increment[(i, i)] / cosine_less_one - 1.0).abs() < 1e-15, "{angle}: {increment}");
            }
            assert!((increment[(1, 0)] / angle.sin() - 1.0).abs() < 1e-15, "{angle}: {increment}");
            assert_eq!(increment[(0, 1)].to_bits(), (-increment[(1, 0)]).to_bits());
        }
    }

    #[test]
    fn doubling_adds_exponents() {
        let x = DMatrix::from_fn(5, 5, |i, j| ((i * 3 + j * 7) as f64).sin() * 0.05);
        let (twice, once) = (exp_m1(&(&x * 2.0)), exp_m1(&x));
        assert!(one_norm(&(doubled(&once) - &twice)) < 1e-15 * one_norm(&twice));
    }
}
