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
//! U being the built-in uncertainties (low rank). Without κ and U, A is skew to the last bit.
//!
//! H is the Householder reflection that makes the rigid motion (θ̇_1 = θ̇_2 = ẏ_M/l, straight arms) the last velocity
//! coordinate. Its column of K is set to the zero that it is: so the free motion of the grasp neither gains nor loses
//! energy however many steps are taken, instead of drifting by an accumulated rounding error.

use crate::beam::{Beam, DEFLECTION_POINTS};
use crate::dense::{LANES, Matrix, Panels, multiply_columns};
use crate::parameters::Parameters;

/// Number of effective force inputs: the torques on hubs 1 and 2, the force on the object.
pub(crate) const FORCES: usize = 3;

/// Signals read from x; the constants below index them. The first eight depend on the velocities only (one of them is
/// no signal but zero), the last four on the moments only.
pub(crate) type Signals = [f64; SIGNALS];

/// θ̇_1, θ̇_2, ẏ_M. These rows are also Bᵀ.
pub(crate) const VELOCITY: [usize; 3] = [0, 1, 2];
/// EI w''(0) of both arms.
pub(crate) const ROOT_MOMENT: [usize; 2] = [8, 9];
/// EI w'''(l) of both arms.
pub(crate) const TIP_SHEAR: [usize; 2] = [10, 11];
/// d/dt EI w'''(l) of both arms.
pub(crate) const TIP_SHEAR_RATE: [usize; 2] = [3, 4];
/// d/dt EI w''(0) of both arms.
pub(crate) const ROOT_MOMENT_RATE: [usize; 2] = [5, 6];
const OF_VELOCITIES: usize = 8;
const OF_MOMENTS: usize = 4;
const SIGNALS: usize = OF_VELOCITIES + OF_MOMENTS;

/// The assembled linear system.
#[derive(Clone, Debug)]
pub(crate) struct Dynamics {
    /// Order k of the discretisation; x has 4k + 1 entries.
    order: usize,
    /// A.
    pub system: Matrix,
    /// Rows of the signals.
    pub signal_rows: Matrix,
    /// A in the kernel's form.
    pub system_panels: Panels,
    /// The columns of [`signal_rows`](Self::signal_rows) where they are not zero: of the moments and of the velocities.
    signals_of_moments: Vec<[f64; OF_MOMENTS]>,
    signals_of_velocities: Vec<[f64; OF_VELOCITIES]>,
    /// Rows of w at the deflection points, by arm.
    pub deflection: [Panels; 2],
    /// √(l³/3EI) by arm: `w(l)` per unit of the arm's first coordinate.
    pub tip_compliance: [f64; 2],
    /// Fields of unit rotation, by arm.
    pub rotation: [Vec<f64>; 2],
    /// Fields of unit static tip deflection, by arm.
    pub static_shape: [Vec<f64>; 2],
    /// Whether A is skew: no uncertainties, no Kelvin–Voigt damping.
    pub conservative: bool,
    reflection: Reflection,
}

impl Dynamics {
    /// Assembles the plant of valid parameters.
    pub fn new(parameters: &Parameters) -> Self {
        let p = parameters;
        let k = p.order;
        let beams: [Beam; 2] = std::array::from_fn(|i| Beam::new(&p.arms[i], p.length, k));
        let mass = p.moving_mass();
        let (moments, velocities) = (2 * k, 2 * k + 1);
        let hub = |i: usize| 2 * (k - 1) + i;
        let object = 2 * k;

        let mut rigid = vec![0.0; velocities];
        for (i, beam) in beams.iter().enumerate() {
            rigid[i * (k - 1)..(i + 1) * (k - 1)].copy_from_slice(&beam.rotation);
            rigid[hub(i)] = p.arms[i].hub_inertia.sqrt();
        }
        rigid[object] = mass.sqrt() * p.length;
        let reflection = Reflection::onto_last(rigid);

        // K, row by row: ȧ = η(0) θ̇ + η'(l) ẏ − Gᵀ b.
        let mut rate = Matrix::zeros(moments, velocities);
        let mut row = vec![0.0; velocities];
        for (i, beam) in beams.iter().enumerate() {
            for j in 0..k {
                row.fill(0.0);
                for r in 0..k - 1 {
                    row[i * (k - 1) + r] = -beam.stiffness[(r, j)];
                }
                row[hub(i)] = beam.root[j] / p.arms[i].hub_inertia.sqrt();
                row[object] = beam.tip[j] / mass.sqrt();
                reflection.apply(&mut row);
                row[object] = 0.0; // The rigid motion bends nothing.
                for (column, entry) in row.iter().enumerate() {
                    rate[(i * k + j, column)] = *entry;
                }
            }
        }

        let n = moments + velocities;
        let mut signal_rows = Matrix::zeros(SIGNALS, n);
        let masses = [p.arms[0].hub_inertia, p.arms[1].hub_inertia, mass];
        for (signal, (coordinate, inertia)) in [hub(0), hub(1), object].into_iter().zip(masses).enumerate() {
            row.fill(0.0);
            row[coordinate] = 1.0 / inertia.sqrt();
            reflection.apply(&mut row);
            for (column, entry) in row.iter().enumerate() {
                signal_rows[(VELOCITY[signal], moments + column)] = *entry;
            }
        }
        for (i, beam) in beams.iter().enumerate() {
            for j in 0..k {
                signal_rows[(ROOT_MOMENT[i], i * k + j)] = beam.root[j];
                signal_rows[(TIP_SHEAR[i], i * k + j)] = beam.tip[j];
            }
            for column in 0..velocities {
                let rates = &rate.column(column)[i * k..(i + 1) * k];
                signal_rows[(ROOT_MOMENT_RATE[i], moments + column)] = dot(&beam.root, rates);
                signal_rows[(TIP_SHEAR_RATE[i], moments + column)] = dot(&beam.tip, rates);
            }
        }

        // The three built-in forces per unit of each velocity coordinate, and the Kelvin–Voigt block.
        let uncertainty = Matrix::from_fn(FORCES, velocities, |force, column| {
            let mut signals = [0.0; SIGNALS];
            for (signal, value) in signals.iter_mut().enumerate().take(SIGNALS) {
                *value = signal_rows[(signal, moments + column)];
            }
            builtin_forces(p, &signals)[force]
        });
        let system = Matrix::from_fn(n, n, |row, column| match (row < moments, column < moments) {
            (true, true) => 0.0,
            (true, false) => rate[(row, column - moments)],
            (false, true) => -rate[(column, row - moments)],
            (false, false) => {
                let (r, c) = (row - moments, column - moments);
                let collocated: f64 =
                    (0..FORCES).map(|force| signal_rows[(VELOCITY[force], row)] * uncertainty[(force, c)]).sum();
                collocated - p.kelvin_voigt * dot(rate.column(r), rate.column(c))
            }
        });

        let [first, second] = beams;
        Self {
            order: k,
            system_panels: Panels::new(&system),
            system,
            signals_of_moments: (0..moments)
                .map(|column| std::array::from_fn(|row| signal_rows[(OF_VELOCITIES + row, column)]))
                .collect(),
            signals_of_velocities: (moments..n)
                .map(|column| std::array::from_fn(|row| signal_rows[(row, column)]))
                .collect(),
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

    /// Turns physical velocities (b_1, b_2, √J_1 θ̇_1, √J_2 θ̇_2, √m ẏ_M) into the velocity coordinates of x.
    pub fn reflect(&self, velocities: &mut [f64]) {
        self.reflection.apply(velocities);
    }

    /// B_{row, force}.
    pub fn input(&self, row: usize, force: usize) -> f64 {
        self.signal_rows[(VELOCITY[force], row)]
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

/// The built-in uncertainties (Δf_1, Δf_2, ΔF) of Section IV, from the discrete signal rates.
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

/// A Householder reflection v ↦ v − 2 u (u·v)/(u·u): symmetric, orthogonal, its own inverse.
#[derive(Clone, Debug)]
struct Reflection {
    axis: Vec<f64>,
    factor: f64,
}

impl Reflection {
    /// The reflection that takes `direction` (its last entry positive) to the negative last axis.
    fn onto_last(mut direction: Vec<f64>) -> Self {
        let norm = dot(&direction, &direction).sqrt();
        if let Some(last) = direction.last_mut() {
            *last += norm;
        }
        let factor = 2.0 / dot(&direction, &direction);
        Self { axis: direction, factor }
    }

    fn apply(&self, vector: &mut [f64]) {
        let amount = self.factor * dot(&self.axis, vector);
        for (entry, axis) in vector.iter_mut().zip(&self.axis) {
            *entry -= amount * axis;
        }
    }
}

pub(crate) fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(l, r)| l * r).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// J_1 θ̈_1 is −M_1(0) + τ_1 + Δf_1 and m ÿ is −ΣM_i'(l) + u + ΔF, eqs. (10) and (11), on every coordinate of x.
    #[test]
    fn hubs_and_object_obey_newton() {
        let mut parameters = Parameters { kelvin_voigt: 1e-3, ..Parameters::default() };
        parameters.arms[1].ei = 0.2;
        parameters.arms[0].hub_inertia = 0.01;
        let d = Dynamics::new(&parameters);
        for column in 0..d.size() {
            let signals: Signals = std::array::from_fn(|s| if s < SIGNALS { d.signal_rows[(s, column)] } else { 0.0 });
            let accelerations = d.signals(d.system.column(column));
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
            let tolerance = 1e-13 * d.system.one_norm();
            for axis in 0..3 {
                assert!((accelerations[VELOCITY[axis]] - expected[axis]).abs() < tolerance, "{column} {axis}");
            }
        }
    }
}
