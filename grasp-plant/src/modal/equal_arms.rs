//! The even and the odd motion of two equal arms, each as large as one arm: see [`Parity`].
//!
//! What the matrices of the whole plant have lost to rounding differs from arm to arm; here both have the mean.

use super::arrangement::Parity;
use super::plane::{Plane, Planes};
use super::twofold::Long;
use super::vibration::Vibration;
use super::{damped, undamped};
use crate::dynamics::FORCES;
use nalgebra::DMatrix;

/// A coordinate of the first arm and the same of the second one.
type Pair = [usize; 2];

/// The pairs of moments, and of velocities, by their places among those of both arms: fields first, then hubs.
fn pairs(order: usize) -> (Vec<Pair>, Vec<Pair>) {
    let fields = (0..order - 1).map(|i| [i, order - 1 + i]);
    let hubs = [2 * (order - 1), 2 * order - 1];
    ((0..order).map(|i| [i, order + i]).collect(), fields.chain([hubs]).collect())
}

/// The planes of one kind of a vibration with equal arms; `system` is the plant's matrix in plain precision.
pub(super) fn planes(vibration: &Vibration, system: &DMatrix<f64>, parity: Parity) -> Option<Planes> {
    let (moments, velocities) = pairs(vibration.size / 2);
    let half = vibration.half(&moments, &velocities, parity);
    let n = vibration.size;
    let all: Vec<Pair> = moments.into_iter().chain(velocities.into_iter().map(|[i, j]| [n + i, n + j])).collect();
    let Planes { planes, inverse } = if half.certain {
        undamped::planes(&half)
    } else {
        damped::planes(&half, &of_half(system, &all, &all, parity))
    }?;
    Some(Planes {
        planes: planes
            .into_iter()
            .map(|plane| Plane { basis: plane.basis.map(|v| joined(&v, &all, parity)), ..plane })
            .collect(),
        inverse: {
            let mut both = DMatrix::zeros(inverse.nrows(), 2 * n);
            for (half, pair) in inverse.column_iter().zip(&all) {
                both.set_column(pair[0], &(0.5 * half));
                both.set_column(pair[1], &(0.5 * parity.sign() * half));
            }
            both
        },
    })
}

/// The half that moves both arms so, of a matrix that treats them alike.
#[inline(never)]
fn of_half(matrix: &DMatrix<f64>, rows: &[Pair], columns: &[Pair], parity: Parity) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
        let ([r, r_2], [c, c_2]) = (rows[i], columns[j]);
        let (own, other) = (matrix[(r, c)] + matrix[(r_2, c_2)], matrix[(r, c_2)] + matrix[(r_2, c)]);
        0.5 * (own + parity.sign() * other)
    })
}

/// A vector of both arms.
fn joined(half: &Long, pairs: &[Pair], parity: Parity) -> Long {
    let mut both = Long::zeros(2 * half.len());
    for (i, [first, second]) in pairs.iter().enumerate() {
        (both.hi[*first], both.lo[*first]) = (half.hi[i], half.lo[i]);
        (both.hi[*second], both.lo[*second]) = (parity.sign() * half.hi[i], parity.sign() * half.lo[i]);
    }
    both
}

impl Vibration {
    /// The first arm's motion while the second one does as the parity says.
    fn half(&self, moments: &[Pair], velocities: &[Pair], parity: Parity) -> Self {
        let sign = parity.sign();
        let rates = of_half(&self.rates, moments, velocities, parity);
        // The first arm's rows, in which each force is that of its own hub, that of the other one, and that on the object.
        let inputs = DMatrix::from_fn(velocities.len(), FORCES, |i, force| {
            let other = [1, 0, 2][force];
            let [first, second] = velocities[i];
            0.5 * (self.inputs[(first, force)] + self.inputs[(second, other)])
        });
        let per_moment =
            |force: usize, [first, second]: Pair| self.builtin[(force, first)] + sign * self.builtin[(force, second)];
        let builtin = DMatrix::from_fn(FORCES, moments.len(), |force, i| {
            let [first, second, object] = [0, 1, 2].map(|force| per_moment(force, moments[i]));
            match force {
                0 => 0.5 * (first + sign * second),
                1 => 0.5 * (sign * first + second),
                _ => 0.5 * (object + sign * object),
            }
        });
        Self {
            size: self.size / 2,
            transposed: rates.transpose(),
            rates,
            viscosity: self.viscosity,
            inputs,
            rigid_inputs: self.rigid_inputs,
            builtin,
            certain: self.certain,
        }
    }
}
