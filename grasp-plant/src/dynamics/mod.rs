//! The linear plant ẋ = A x + B g in energy coordinates, and the rows that read signals from x.
//!
//! x = (a_1, a_2, z): both arms' moment coefficients, then z = H (b_1, b_2, √J_1 θ̇_1, √J_2 θ̇_2, √m ẏ_M), the velocities
//! in a rotated basis. Every entry is a square root of twice an energy, ½|x|² is the total energy, and with K the map
//! from velocities to moment rates
//!
//! ```text
//!     ⎡  0    K            ⎤       ⎡ 0 ⎤
//! A = ⎣ −Kᵀ  −(κKᵀ + U) K  ⎦,  B = ⎣ C ⎦,  g = (τ_1 + δf_1, τ_2 + δf_2, u + δF),
//! ```
//!
//! where U are the built-in uncertainties (of low rank). Without κ and U, A is skew-symmetric to the last bit.
//!
//! H is the Householder reflection that makes the rigid motion (θ̇_1 = θ̇_2 = ẏ_M/l, straight arms) the last velocity
//! coordinate. Its column of K, which is zero except for rounding, is set to exactly zero. So the free motion of the grasp
//! neither gains nor loses energy however many steps are taken, instead of drifting by an accumulated rounding error.

mod assembly;
mod reflection;

use crate::beam::{Beam, DEFLECTION_POINTS};
use crate::kernel::{LANES, Panels, multiply_columns};
use crate::parameters::Parameters;
use assembly::Assembly;
use nalgebra::{DMatrix, DVector};
use reflection::Reflection;

/// Number of effective force inputs: the torques on hubs 1 and 2, the force on the object.
pub(crate) const FORCES: usize = 3;

/// Signals read from x; the constants below index them. The first eight depend on the velocities only (one of them, the sixth, is
/// constantly zero), the last four on the moments only. They are written four at a time, and no two that are read together stand in
/// different fours: to read such a pair, a processor waits until both fours are in its cache.
pub(crate) type Signals = [f64; SIGNALS];

/// θ̇_1, θ̇_2, ẏ_M. These rows are also Bᵀ.
pub(crate) const VELOCITY: [usize; 3] = [0, 1, 4];
/// EI w''(0) of both arms.
pub(crate) const ROOT_MOMENT: [usize; 2] = [8, 9];
/// EI w'''(l) of both arms.
pub(crate) const TIP_SHEAR: [usize; 2] = [10, 11];
/// d/dt EI w'''(l) of both arms.
pub(crate) const TIP_SHEAR_RATE: [usize; 2] = [2, 3];
/// d/dt EI w''(0) of both arms. Steps in modal coordinates leave them out: they are read when they are asked for.
pub(crate) const ROOT_MOMENT_RATE: [usize; 2] = [6, 7];
const OF_VELOCITIES: usize = 8;
const OF_MOMENTS: usize = 4;
pub(crate) const SIGNALS: usize = OF_VELOCITIES + OF_MOMENTS;

/// The assembled linear system.
#[derive(Clone, Debug)]
pub(crate) struct Dynamics {
    /// Order k of the discretisation; x has 4k + 1 entries.
    order: usize,
    /// A.
    pub system: DMatrix<f64>,
    /// Rows of the signals.
    pub signal_rows: DMatrix<f64>,
    /// A in the kernel's form.
    pub system_panels: Panels,
    /// The non-zero columns of [`signal_rows`](Self::signal_rows): of the moments and of the velocities.
    signals_of_moments: Vec<[f64; OF_MOMENTS]>,
    signals_of_velocities: Vec<[f64; OF_VELOCITIES]>,
    /// Rows of w at the deflection points, by arm.
    pub deflection: [Panels; 2],
    /// √(l³/3EI) by arm: `w(l)` per unit of the arm's first coordinate.
    pub tip_compliance: [f64; 2],
    /// Fields of unit rotation, by arm.
    pub rotation: [DVector<f64>; 2],
    /// Fields of unit static tip deflection, by arm.
    pub static_shape: [DVector<f64>; 2],
    /// Whether A is skew: no uncertainties, no Kelvin–Voigt damping.
    pub conservative: bool,
    reflection: Reflection,
}

impl Dynamics {
    /// Assembles the plant of valid parameters.
    pub fn new(parameters: &Parameters) -> Self {
        let p = parameters;
        let beams = p.arms.each_ref().map(|arm| Beam::new(arm, p.length, p.order));
        let assembly = Assembly::new(p, &beams);
        let rates = assembly.moment_rates();
        let signal_rows = assembly.signal_rows(&rates);
        let system = assembly.system(&rates, &signal_rows);
        let reflection = assembly.reflection;
        let (moments, n) = (rates.nrows(), system.nrows());
        let [first, second] = beams;
        Self {
            order: p.order,
            system_panels: Panels::new(&system),
            system,
            signals_of_moments: columns(&signal_rows, OF_VELOCITIES, 0..moments),
            signals_of_velocities: columns(&signal_rows, 0, moments..n),
            signal_rows,
            deflection: [Panels::new(&first.deflection), Panels::new(&second.deflection)],
            tip_compliance: [first.tip_compliance, second.tip_compliance],
            rotation: [first.rotation, second.rotation],
            static_shape: [first.static_shape, second.static_shape],
            conservative: p.root_uncertainty == 0.0 && p.tip_uncertainty == 0.0 && p.kelvin_voigt == 0.0,
            reflection,
        }
    }

    /// Number of energy coordinates, 4k + 1.
    pub fn size(&self) -> usize {
        4 * self.order + 1
    }

    /// Index of an arm's first moment coefficient, the one that holds its tip deflection.
    pub fn tip_coordinate(&self, arm: usize) -> usize {
        arm * self.order
    }

    /// The moment coefficients of an arm within x.
    pub fn moment_range(&self, arm: usize) -> std::ops::Range<usize> {
        arm * self.order..(arm + 1) * self.order
    }

    /// Converts physical velocities (b_1, b_2, √J_1 θ̇_1, √J_2 θ̇_2, √m ẏ_M) to the velocity coordinates of x.
    pub fn reflect(&self, velocities: &mut [f64]) {
        self.reflection.apply(velocities);
    }

    /// B_{row, force}.
    pub fn input(&self, row: usize, force: usize) -> f64 {
        self.signal_rows[(VELOCITY[force], row)]
    }

    /// B, shape n × 3.
    pub fn inputs(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.size(), FORCES, |row, force| self.input(row, force))
    }

    /// All signals of x.
    pub fn signals(&self, x: &[f64]) -> Signals {
        let (moments, velocities) = x.split_at(self.signals_of_moments.len());
        let mut signals = [0.0; SIGNALS];
        let (of_velocities, of_moments) = signals.split_at_mut(OF_VELOCITIES);
        of_velocities.copy_from_slice(&multiply_columns(&self.signals_of_velocities, velocities));
        of_moments.copy_from_slice(&multiply_columns(&self.signals_of_moments, moments));
        signals
    }

    /// w at the deflection points of an arm.
    pub fn deflection(&self, arm: usize, x: &[f64]) -> [f64; DEFLECTION_POINTS] {
        let mut rows = [[0.0; LANES]];
        self.deflection[arm].multiply(&x[self.moment_range(arm)], &mut rows);
        std::array::from_fn(|point| rows[0][point])
    }
}

/// Some columns of a matrix, from row `first` on.
fn columns<const ROWS: usize>(
    matrix: &DMatrix<f64>,
    first: usize,
    columns: std::ops::Range<usize>,
) -> Vec<[f64; ROWS]> {
    columns.map(|column| std::array::from_fn(|row| matrix[(first + row, column)])).collect()
}

/// The built-in uncertainties (Δf_1, Δf_2, ΔF) of Section IV, from the discrete signal rates.
#[inline]
pub(crate) fn builtin_forces(parameters: &Parameters, signals: &Signals) -> [f64; FORCES] {
    let p = parameters;
    let [ei_1, ei_2] = [p.arms[0].ei, p.arms[1].ei];
    let third_derivative_rates = signals[TIP_SHEAR_RATE[0]] / ei_1 + signals[TIP_SHEAR_RATE[1]] / ei_2;
    [
        -p.root_uncertainty * signals[ROOT_MOMENT_RATE[0]],
        -p.root_uncertainty * signals[ROOT_MOMENT_RATE[1]],
        -p.tip_uncertainty * (ei_1 + ei_2) * third_derivative_rates,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exponential::one_norm;

    #[test]
    fn without_damping_the_system_is_bitwise_skew() {
        for order in [4, 8, 15, 24] {
            let mut parameters = Parameters { order, ..Parameters::default() };
            parameters.root_uncertainty = 0.0;
            parameters.tip_uncertainty = 0.0;
            parameters.arms[1].ei = 0.3;
            let dynamics = Dynamics::new(&parameters);
            assert!(dynamics.conservative);
            for i in 0..dynamics.size() {
                for j in 0..=i {
                    assert!(dynamics.system[(i, j)] + dynamics.system[(j, i)] == 0.0);
                }
            }
        }
    }

    /// J_1 θ̈_1 is −M_1(0) + τ_1 + Δf_1 and m ÿ is −ΣM_i'(l) + u + ΔF, eqs. (10) and (11), for every coordinate of x.
    #[test]
    fn hubs_and_object_obey_newton() {
        let mut parameters = Parameters { kelvin_voigt: 1e-3, ..Parameters::default() };
        parameters.arms[1].ei = 0.2;
        parameters.arms[0].hub_inertia = 0.01;
        let d = Dynamics::new(&parameters);
        for column in 0..d.size() {
            let signals: Signals = std::array::from_fn(|s| if s < SIGNALS { d.signal_rows[(s, column)] } else { 0.0 });
            let accelerations = d.signals(d.system.column(column).as_slice());
            let forces = builtin_forces(&parameters, &signals);
            let kappa = parameters.kelvin_voigt;
            let moment = |i: usize| signals[ROOT_MOMENT[i]] + kappa * signals[ROOT_MOMENT_RATE[i]];
            let shear = |i: usize| signals[TIP_SHEAR[i]] + kappa * signals[TIP_SHEAR_RATE[i]];
            let expected = [
                (forces[0] - moment(0)) / parameters.arms[0].hub_inertia,
                (forces[1] - moment(1)) / parameters.arms[1].hub_inertia,
                (forces[2] - shear(0) - shear(1)) / parameters.moving_mass(),
            ];
            // Rounding of sums over all coordinates, relative to the largest entries.
            let tolerance = 1e-13 * one_norm(&d.system);
            for axis in 0..3 {
                assert!((accelerations[VELOCITY[axis]] - expected[axis]).abs() < tolerance, "{column} {axis}");
            }
        }
    }
}
