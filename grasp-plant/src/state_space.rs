//! The plant as a linear system.

use crate::dynamics::{Dynamics, FORCES, ROOT_MOMENT, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY};
use crate::exponential::{TAYLOR_NORM, doubled, exp_m1, one_norm};
use nalgebra::DMatrix;

/// The plant as a linear system, for analysis: ξ̇ = A ξ + B g, measured = C ξ with ξ = (x, θ_1, θ_2, `y_M`) and
/// g the torques on hubs 1 and 2 and the force on the object.
///
/// By (12), w_i(l), θ_i and `y_M` depend on each other; this alone makes two eigenvalues of A zero.
#[derive(Clone, Debug)]
pub struct StateSpace {
    /// A, shape (4k+4) × (4k+4).
    pub a: DMatrix<f64>,
    /// B, shape (4k+4) × 3.
    pub b: DMatrix<f64>,
    /// C, shape 12 × (4k+4): θ_1, θ_2, θ̇_1, θ̇_2, `y_M`, `ẏ_M`, EI w''(0) (2), EI w'''(l) (2), d/dt EI w'''(l) (2).
    pub c: DMatrix<f64>,
    /// Rows that give w_1(l) and w_2(l), shape 2 × (4k+4).
    pub tip_deflection: DMatrix<f64>,
}

impl StateSpace {
    pub(crate) fn new(dynamics: &Dynamics) -> Self {
        let n = dynamics.size();
        let size = n + 3;
        let rows = |indices: &[usize]| dynamics.signal_rows.select_rows(indices);
        let mut a = DMatrix::zeros(size, size);
        a.view_mut((0, 0), (n, n)).copy_from(&dynamics.system);
        a.view_mut((n, 0), (3, n)).copy_from(&rows(&VELOCITY));
        let mut b = DMatrix::zeros(size, FORCES);
        b.view_mut((0, 0), (n, FORCES)).copy_from(&dynamics.inputs());
        // Positions come after x: θ_1, θ_2, y_M.
        let mut c = DMatrix::zeros(12, size);
        for (row, position) in [(0, 0), (1, 1), (4, 2)] {
            c[(row, n + position)] = 1.0;
        }
        let [hub1, hub2, object] = VELOCITY;
        for (first, signals) in
            [(2, &[hub1, hub2][..]), (5, &[object]), (6, &ROOT_MOMENT), (8, &TIP_SHEAR), (10, &TIP_SHEAR_RATE)]
        {
            c.view_mut((first, 0), (signals.len(), n)).copy_from(&rows(signals));
        }
        let mut tip_deflection = DMatrix::zeros(2, size);
        for (arm, compliance) in dynamics.tip_compliance.into_iter().enumerate() {
            tip_deflection[(arm, dynamics.tip_coordinate(arm))] = compliance;
        }
        Self { a, b, c, tip_deflection }
    }
}

/// The exact step of ξ̇ = A ξ + B g with g held over `h` \[s\]: e^{Ah} and ∫₀ʰ e^{At} dt B, for any matrices of fitting shapes.
#[must_use]
pub fn held_step(a: &DMatrix<f64>, b: &DMatrix<f64>, h: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let (n, inputs) = (a.nrows(), b.ncols());
    let mut whole = DMatrix::zeros(n + inputs, n + inputs);
    whole.view_mut((0, 0), (n, n)).copy_from(&(a * h));
    whole.view_mut((0, n), (n, inputs)).copy_from(&(b * h));
    let mut doublings = 0;
    while one_norm(&whole) > TAYLOR_NORM {
        whole *= 0.5;
        doublings += 1;
    }
    let mut increment = exp_m1(&whole);
    for _ in 0..doublings {
        increment = doubled(&increment);
    }
    let mut step = increment.view((0, 0), (n, n)).into_owned();
    for i in 0..n {
        step[(i, i)] += 1.0;
    }
    (step, increment.view((0, n), (n, inputs)).into_owned())
}
