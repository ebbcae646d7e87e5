//! Invariant planes of the vibration: two-dimensional, each with the 2 × 2 matrix of the motion in it.

use super::block::Block;
use super::twofold::{Long, Twofold};
use nalgebra::DMatrix;

/// A 2 × 2 matrix of twice the precision, by rows.
pub(super) type Wide = [[Twofold; 2]; 2];

/// A plane that the vibration leaves only by force.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    /// Two vectors that span it.
    pub basis: [Long; 2],
    /// A·basis = basis·motion.
    pub motion: Wide,
}

/// All planes, and the rows that read coordinates in their bases: two for each, the inverse of all bases, to about ten digits.
pub(super) struct Planes {
    pub planes: Vec<Plane>,
    pub inverse: DMatrix<f64>,
}

/// Ratio of the off-diagonal entries of a block above which its two motions are treated as equal.
const ALIKE: f64 = 64.0;

pub(super) fn product(left: &Wide, right: &Wide) -> Wide {
    std::array::from_fn(|i| std::array::from_fn(|j| left[i][0] * right[0][j] + left[i][1] * right[1][j]))
}

pub(super) fn inverse(matrix: &Wide) -> Wide {
    let [[a, b], [c, d]] = *matrix;
    let determinant = a * d - b * c;
    [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
}

impl Plane {
    /// Replaces the basis by basis·change; the rows that read coordinates change with it.
    fn change(&mut self, change: &Wide, rows: &mut [Vec<f64>; 2]) {
        let [u, w] = &self.basis;
        let combined = |column: usize| {
            let mut vector = u.clone();
            vector.scale(change[0][column]);
            vector.add_multiple(change[1][column], w);
            vector
        };
        self.basis = [combined(0), combined(1)];
        let back = inverse(change);
        self.motion = product(&product(&back, &self.motion), change);
        let [first, second] = &*rows;
        *rows = [0, 1].map(|i| first.iter().zip(second).map(|(f, s)| back[i][0].hi * f + back[i][1].hi * s).collect());
    }

    /// Makes the basis orthonormal.
    pub fn orthonormalise(&mut self, rows: &mut [Vec<f64>; 2]) {
        let [u, w] = &self.basis;
        let length = u.dot(u).sqrt();
        let along = u.dot(w) / (length * length);
        let mut rest = w.clone();
        rest.add_multiple(-along, u);
        let height = rest.dot(&rest).sqrt();
        let zero = Twofold::default();
        self.change(&[[Twofold::ONE / length, -along / height], [zero, Twofold::ONE / height]], rows);
    }

    /// Turns an orthonormal basis into the one in which the motion is a [`Block`].
    pub fn standardise(&mut self, rows: &mut [Vec<f64>; 2]) -> Block {
        let zero = Twofold::default();
        let half = Twofold::from(0.5);
        // The rotation that makes the diagonal entries equal (LAPACK's dlanv2).
        let [[a, b], [c, d]] = self.motion;
        let (difference, sum) = (a - d, b + c);
        if difference.hi != 0.0 {
            let size = (difference * difference + sum * sum).sqrt();
            let cosine = (half * (Twofold::ONE + sum.abs() / size)).sqrt();
            let sine = half * difference / (size * cosine);
            let sine = if sum.hi < 0.0 { sine } else { -sine };
            self.change(&[[cosine, -sine], [sine, cosine]], rows);
        }
        let sigma = half * (self.motion[0][0] + self.motion[1][1]);
        let [upper, lower] = [self.motion[0][1], self.motion[1][0]];
        let square = upper * lower;
        if square.hi < 0.0 {
            let omega = (-square).sqrt();
            let mut ratio = (-(upper / lower)).sqrt();
            if upper.hi < 0.0 {
                ratio = -ratio;
            }
            let mut signed = omega;
            if ratio.hi < 0.0 {
                (ratio, signed) = (-ratio, -omega);
            }
            if ratio.hi < ALIKE && ratio.hi > 1.0 / ALIKE {
                self.change(&[[Twofold::ONE, zero], [zero, Twofold::ONE / ratio]], rows);
                ratio = Twofold::ONE;
            }
            return Block::Elliptic { sigma, omega: signed, ratio: ratio.hi };
        }
        let root = square.sqrt();
        if upper.hi.abs() < ALIKE * lower.hi.abs() && lower.hi.abs() < ALIKE * upper.hi.abs() {
            // Eigenvectors (upper, ±root), and the eigenvalue that is not a difference gives the other.
            let large = if sigma.hi < 0.0 { sigma - root } else { sigma + root };
            let small = (sigma * sigma - square) / large;
            let norm = (upper * upper + square).sqrt();
            let (along, across) = (upper / norm, root / norm);
            let sign = |positive: bool| if positive { across } else { -across };
            let first_is_above = sigma.hi >= 0.0;
            self.change(&[[along, along], [sign(first_is_above), sign(!first_is_above)]], rows);
            return Block::Diagonal { lambda: [large, small] };
        }
        Block::Hyperbolic { sigma, root: root.hi, upper: upper.hi, lower: lower.hi }
    }
}
