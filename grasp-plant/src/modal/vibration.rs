//! The plant without its rigid motion, exactly as its matrices in plain precision define it.
//!
//! The rigid motion influences no other motion. The rest are the moments a and the other velocity coordinates b,
//!
//! ```text
//! ȧ = K b,   ḃ = −Kᵀ (a + κ ȧ) + C (F ȧ + g),
//! ```
//!
//! with F the built-in forces per rate of the moments.

use super::twofold::{Long, Twofold};
use crate::dynamics::{
    Dynamics, FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, Signals, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY, builtin_forces,
};
use crate::parameters::Parameters;
use nalgebra::DMatrix;

pub(super) struct Vibration {
    /// Number of moments, and of velocities: 2k.
    pub size: usize,
    /// K.
    pub rates: DMatrix<f64>,
    /// Kᵀ.
    pub transposed: DMatrix<f64>,
    /// κ.
    pub viscosity: f64,
    /// C, shape 2k × 3.
    pub inputs: DMatrix<f64>,
    /// The effect of the forces on the rigid velocity.
    pub rigid_inputs: [f64; FORCES],
    /// F, shape 3 × 2k.
    pub builtin: DMatrix<f64>,
    /// Whether F is zero.
    pub certain: bool,
}

impl Vibration {
    pub fn new(dynamics: &Dynamics, parameters: &Parameters) -> Self {
        let size = (dynamics.size() - 1) / 2;
        let rates = dynamics.system.view((0, size), (size, size)).into_owned();
        let inputs = DMatrix::from_fn(size, FORCES, |row, force| dynamics.input(size + row, force));
        let mut builtin = DMatrix::zeros(FORCES, size);
        for (moment, mut column) in builtin.column_iter_mut().enumerate() {
            let mut signals = Signals::default();
            for arm in 0..2 {
                signals[ROOT_MOMENT_RATE[arm]] = dynamics.signal_rows[(ROOT_MOMENT[arm], moment)];
                signals[TIP_SHEAR_RATE[arm]] = dynamics.signal_rows[(TIP_SHEAR[arm], moment)];
            }
            column.copy_from_slice(&builtin_forces(parameters, &signals));
        }
        Self {
            size,
            transposed: rates.transpose(),
            rates,
            viscosity: parameters.kelvin_voigt,
            inputs,
            rigid_inputs: VELOCITY.map(|velocity| dynamics.signal_rows[(velocity, 2 * size)]),
            builtin,
            certain: parameters.root_uncertainty == 0.0 && parameters.tip_uncertainty == 0.0,
        }
    }

    /// The time derivative of (a, b) without g.
    pub fn derivative(&self, state: &Long) -> Long {
        let n = self.size;
        let (moments, velocities) = (state.part(0..n), state.part(n..2 * n));
        let mut rates = Long::zeros(n);
        for (j, column) in self.rates.column_iter().enumerate() {
            rates.add_scaled(velocities.get(j), column.as_slice());
        }
        let mut transmitted = moments;
        transmitted.add_multiple(Twofold::from(self.viscosity), &rates);
        let mut accelerations = Long::zeros(n);
        for (i, row) in self.transposed.column_iter().enumerate() {
            accelerations.add_scaled(-transmitted.get(i), row.as_slice());
        }
        if !self.certain {
            for (force, column) in self.inputs.column_iter().enumerate() {
                let row: Vec<f64> = self.builtin.row(force).iter().copied().collect();
                accelerations.add_scaled(rates.dot_plain(&row), column.as_slice());
            }
        }
        rates.hi.append(&mut accelerations.hi);
        rates.lo.append(&mut accelerations.lo);
        rates
    }

    /// The effect of the built-in forces on the rigid velocity per moment: its row of C times F. With ζ the rigid velocity
    /// minus this effect, ζ̇ depends on g alone.
    pub fn rigid_moments(&self) -> Vec<f64> {
        let gain =
            |column: usize| (0..FORCES).map(|force| self.rigid_inputs[force] * self.builtin[(force, column)]).sum();
        (0..self.size).map(gain).collect()
    }
}
