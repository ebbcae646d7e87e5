//! One arm's discrete operators: the mixed moment–velocity form of (8) and (9) on one element.
//!
//! The moment M = EI w'' is Σ a_j η_j with η_j of degree j+1 ≤ k and η_j(l) = 0, orthonormal in ∫·/EI; the velocity
//! v = xθ̇ − ẇ is Σ b_r L_r of degree ≤ k−2, orthonormal in ρ∫·. So ½|a|² is the strain energy and ½|b|² the beam's
//! kinetic energy, and with G_{rj} = ∫ L_r η_j'' the beam is
//!
//! ```text
//! ḃ = G a,    ȧ = η(0) θ̇ + η'(l) ẏ_M − Gᵀ b.
//! ```

use crate::basis::{gauss, legendre, moment_shape, moment_shape_curvature};
use crate::parameters::Arm;
use nalgebra::{DMatrix, DVector, RowDVector};

/// Number of equally spaced points, x = 0 … l, at which the deflection is reported.
pub const DEFLECTION_POINTS: usize = 11;

/// The operators of one arm of order k.
#[derive(Clone, Debug)]
pub(crate) struct Beam {
    /// G_{rj} = ∫ L_r η_j'', shape (k−1) × k, strictly upper triangular.
    pub stiffness: DMatrix<f64>,
    /// η_j(0): the row that gives EI w''(0) from a.
    pub root: RowDVector<f64>,
    /// η_j'(l): the row that gives EI w'''(l) from a.
    pub tip: RowDVector<f64>,
    /// Rows that give w(x) at [`DEFLECTION_POINTS`] points, one row per point.
    pub deflection: DMatrix<f64>,
    /// √(l³/3EI): the tip deflection per unit of `a_0`. All other a_j leave the tip where it is.
    pub tip_compliance: f64,
    /// Coefficients b of the field v = x (unit rotation about the hub).
    pub rotation: DVector<f64>,
    /// Coefficients b of the field v = (3ξ² − ξ³)/2, the static cubic of unit tip deflection, projected to degree k−2.
    pub static_shape: DVector<f64>,
}

impl Beam {
    /// Evaluates all integrals by Gauss quadrature of sufficient degree.
    pub fn new(arm: &Arm, length: f64, order: usize) -> Self {
        let (moments, velocities) = (order, order - 1);
        let moment_scale = |j: usize| (arm.ei * (2 * j + 3) as f64 / length).sqrt();
        let velocity_scale = |r: usize| ((2 * r + 1) as f64 / (arm.rho * length)).sqrt();
        let velocity_shape = |r: usize, xi: f64| velocity_scale(r) * legendre(r, 2.0 * xi - 1.0);
        // Degree 2k−1 covers L_r η_j'' (2k−4), L_r times a cubic (k+1) and (x−s) M(s) (k+1).
        let rule = gauss(order);
        let integral = |f: &dyn Fn(f64) -> f64| rule.iter().map(|(xi, weight)| weight * f(*xi)).sum::<f64>();

        let stiffness = DMatrix::from_fn(velocities, moments, |r, j| {
            // η_j'' has degree j−1: the rest vanishes by orthogonality.
            if r >= j {
                return 0.0;
            }
            moment_scale(j) / length * integral(&|xi| velocity_shape(r, xi) * moment_shape_curvature(j, xi))
        });
        let root = RowDVector::from_fn(moments, |_, j| if j % 2 == 0 { moment_scale(j) } else { -moment_scale(j) });
        let tip = RowDVector::from_fn(moments, |_, j| -moment_scale(j) / length * ((j + 1) * (j + 2)) as f64 / 2.0);

        let tip_compliance = (length.powi(3) / (3.0 * arm.ei)).sqrt();
        let deflection = DMatrix::from_fn(DEFLECTION_POINTS, moments, |point, j| {
            if point == DEFLECTION_POINTS - 1 {
                // ∫(l−x)M/EI: l−x is a multiple of η_0.
                return if j == 0 { tip_compliance } else { 0.0 };
            }
            let x = point as f64 / (DEFLECTION_POINTS - 1) as f64;
            // w(x) = ∫₀ˣ (x−s) M(s)/EI ds with s = xσ.
            let scale = moment_scale(j) / arm.ei * (x * length).powi(2);
            scale * integral(&|sigma| (1.0 - sigma) * moment_shape(j, x * sigma))
        });

        let project = |f: &dyn Fn(f64) -> f64| {
            DVector::from_fn(velocities, |r, _| arm.rho * length * integral(&|xi| velocity_shape(r, xi) * f(xi)))
        };
        let mut rotation = project(&|xi| length * xi);
        rotation.rows_range_mut(2..).fill(0.0);
        let static_shape = project(&|xi| (3.0 - xi) * xi * xi / 2.0);
        Self { stiffness, root, tip, deflection, tip_compliance, rotation, static_shape }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rigid rotation stores no strain: η(0) + l η'(l) − Gᵀ b_rotation = 0 for every moment function.
    #[test]
    fn a_rigid_rotation_bends_nothing() {
        let (arm, length) = (Arm::default(), 0.2);
        for order in 4..=24 {
            let beam = Beam::new(&arm, length, order);
            for j in 0..order {
                let bending: f64 = (0..order - 1).map(|r| beam.stiffness[(r, j)] * beam.rotation[r]).sum();
                let rate = beam.root[j] + length * beam.tip[j] - bending;
                assert!(rate.abs() < 1e-12 * beam.tip[j].abs(), "order {order} moment {j}: {rate}");
            }
        }
    }

    /// Moving with the static cubic changes `a_0` only, also at order 4 where the cubic is projected on quadratics.
    #[test]
    fn the_static_cubic_moves_only_the_first_moment() {
        let (arm, length) = (Arm::default(), 0.2);
        for order in 4..=24 {
            let beam = Beam::new(&arm, length, order);
            // Hub and object at rest except ẇ(l) = 1, so ẏ = −1 and v = −ẇ.
            for j in 0..order {
                let bending: f64 = (0..order - 1).map(|r| beam.stiffness[(r, j)] * beam.static_shape[r]).sum();
                let rate = -beam.tip[j] + bending;
                let expected = if j == 0 { 1.0 / beam.tip_compliance } else { 0.0 };
                assert!((rate - expected).abs() < 1e-12 * beam.tip[j].abs(), "order {order} moment {j}: {rate}");
            }
        }
    }

    /// M = λ(x−l) is `a_0` = −λ l/√(3EI/l) and must give the static deflection of (16).
    #[test]
    fn a_linear_moment_gives_the_deflection_of_eq_16() {
        let (arm, length, lambda) = (Arm::default(), 0.2, -0.5);
        let beam = Beam::new(&arm, length, 8);
        let a0 = -lambda * length / (3.0 * arm.ei / length).sqrt();
        for point in 0..DEFLECTION_POINTS {
            let x = length * point as f64 / 10.0;
            let exact = lambda * x * x / (2.0 * arm.ei) * (x / 3.0 - length);
            assert!((beam.deflection[(point, 0)] * a0 - exact).abs() < 1e-16);
        }
        assert!((beam.root[0] * a0 + lambda * length).abs() < 1e-15);
        assert!((beam.tip[0] * a0 - lambda).abs() < 1e-15);
    }
}
