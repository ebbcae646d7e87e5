//! The invariant planes of a plant without built-in uncertainties: each pairs a left and a right singular vector of K.
//!
//! With K q = s p and Kᵀ p = s q the motion of (p, q) is a ↦ s b, b ↦ −s a − κ s² b. All planes together are orthonormal, for
//! equal and for overdamped motions too.

use super::plane::{Plane, Planes};
use super::twofold::{Long, Twofold};
use super::vibration::Vibration;
use nalgebra::{DMatrix, DVector};

const SWEEPS: usize = 40;

/// None if K has no inverse.
pub(super) fn planes(vibration: &Vibration) -> Option<Planes> {
    let n = vibration.size;
    let right = refined(&vibration.rates, &rotations(&vibration.rates));
    let mut planes = Vec::with_capacity(n);
    let mut inverse = DMatrix::zeros(2 * n, 2 * n);
    for (j, (q, image)) in right.into_iter().enumerate() {
        let s = image.dot(&image).sqrt();
        let mut p = image;
        p.scale(Twofold::ONE / s);
        if !(s.hi > 0.0 && p.hi.iter().all(|entry| entry.is_finite())) {
            return None;
        }
        inverse.view_mut((2 * j, 0), (1, n)).tr_copy_from(&DVector::from_column_slice(&p.hi));
        inverse.view_mut((2 * j + 1, n), (1, n)).tr_copy_from(&DVector::from_column_slice(&q.hi));
        let viscous = s * s * Twofold::from(vibration.viscosity);
        planes.push(Plane {
            basis: [joined(p, Long::zeros(n)), joined(Long::zeros(n), q)],
            motion: [[Twofold::default(), s], [-s, -viscous]],
        });
    }
    Some(Planes { planes, inverse })
}

fn joined(mut upper: Long, mut lower: Long) -> Long {
    upper.hi.append(&mut lower.hi);
    upper.lo.append(&mut lower.lo);
    upper
}

/// Cosine and sine of the rotation that makes two columns orthogonal, from their squared lengths and their inner product
/// (one-sided Jacobi, Hestenes).
fn tangent(difference: f64, product: f64) -> f64 {
    let zeta = difference / (2.0 * product);
    let root = (1.0 + zeta * zeta).sqrt();
    if zeta < 0.0 { -1.0 / (root - zeta) } else { 1.0 / (root + zeta) }
}

/// Right singular vectors in plain precision.
fn rotations(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.ncols();
    let mut images = matrix.clone();
    let mut right = DMatrix::identity(n, n);
    for _ in 0..SWEEPS {
        let mut done = true;
        for j in 1..n {
            for i in 0..j {
                let (first, second) = (images.column(i), images.column(j));
                let product = first.dot(&second);
                let (alpha, beta) = (first.norm_squared(), second.norm_squared());
                if product.abs() <= f64::EPSILON * (alpha * beta).sqrt() {
                    continue;
                }
                done = false;
                let tangent = tangent(beta - alpha, product);
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                for matrix in [&mut images, &mut right] {
                    rotate(matrix, i, j, cosine, cosine * tangent);
                }
            }
        }
        if done {
            break;
        }
    }
    right
}

fn rotate(matrix: &mut DMatrix<f64>, i: usize, j: usize, cosine: f64, sine: f64) {
    let (mut first, mut second) = matrix.columns_range_pair_mut(i, j);
    for (p, q) in first.iter_mut().zip(second.iter_mut()) {
        (*p, *q) = (cosine * *p - sine * *q, sine * *p + cosine * *q);
    }
}

/// The right singular vectors and their images, in twice the precision: rotated until they are orthogonal to some 25
/// digits.
fn refined(matrix: &DMatrix<f64>, right: &DMatrix<f64>) -> Vec<(Long, Long)> {
    let mut vectors: Vec<Long> = Vec::with_capacity(right.ncols());
    for column in right.column_iter() {
        // Gram and Schmidt: orthonormal as well to the last digit.
        let mut vector = Long::of(column.as_slice());
        for other in &vectors {
            let along = vector.dot(other);
            vector.add_multiple(-along, other);
        }
        let length = vector.dot(&vector).sqrt();
        vector.scale(Twofold::ONE / length);
        vectors.push(vector);
    }
    let mut pairs: Vec<(Long, Long)> = vectors
        .into_iter()
        .map(|vector| {
            let mut image = Long::zeros(matrix.nrows());
            for (j, column) in matrix.column_iter().enumerate() {
                image.add_scaled(vector.get(j), column.as_slice());
            }
            (vector, image)
        })
        .collect();
    for _ in 0..4 {
        let mut largest = 0.0f64;
        let mut squares: Vec<Twofold> = pairs.iter().map(|(_, image)| image.dot(image)).collect();
        for j in 1..pairs.len() {
            for i in 0..j {
                let product = pairs[i].1.dot(&pairs[j].1);
                if product.hi.abs() <= 1e-28 * (squares[i].hi * squares[j].hi).sqrt() {
                    continue;
                }
                let zeta = (squares[j] - squares[i]) / (product + product);
                let root = (Twofold::ONE + zeta * zeta).sqrt();
                let tangent =
                    if zeta.hi < 0.0 { -(Twofold::ONE / (root - zeta)) } else { Twofold::ONE / (root + zeta) };
                let cosine = Twofold::ONE / (Twofold::ONE + tangent * tangent).sqrt();
                largest = largest.max(tangent.hi.abs());
                let (head, tail) = pairs.split_at_mut(j);
                let (first, second) = (&mut head[i], &mut tail[0]);
                turn(&mut first.0, &mut second.0, cosine, cosine * tangent);
                turn(&mut first.1, &mut second.1, cosine, cosine * tangent);
                squares[i] = squares[i] - tangent * product;
                squares[j] = squares[j] + tangent * product;
            }
        }
        if largest < 1e-9 {
            break;
        }
    }
    pairs
}

fn turn(first: &mut Long, second: &mut Long, cosine: Twofold, sine: Twofold) {
    let before = first.clone();
    first.scale(cosine);
    first.add_multiple(-sine, second);
    second.scale(cosine);
    second.add_multiple(sine, &before);
}
