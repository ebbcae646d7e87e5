//! Puts hubs, object and the two beams together.

use super::reflection::Reflection;
use super::{FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, SIGNALS, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY, builtin_forces};
use crate::beam::Beam;
use crate::kernel::product;
use crate::parameters::Parameters;
use nalgebra::{DMatrix, DVector};

/// Positions of the velocities among their coordinates, before the reflection: (b_1, b_2, √J_1 θ̇_1, √J_2 θ̇_2, √m ẏ_M).
#[derive(Clone, Copy)]
struct Places {
    order: usize,
}

impl Places {
    /// First coefficient of an arm's velocity field.
    fn field(self, arm: usize) -> usize {
        arm * (self.order - 1)
    }

    fn hub(self, arm: usize) -> usize {
        self.field(2) + arm
    }

    fn object(self) -> usize {
        2 * self.order
    }
}

/// The parts of a plant.
pub(super) struct Assembly<'a> {
    parameters: &'a Parameters,
    beams: &'a [Beam; 2],
    places: Places,
    /// √ of the inertias that the three forces move: J_1, J_2, m.
    roots_of_inertia: [f64; FORCES],
    /// H, which makes the rigid motion the last velocity coordinate.
    pub reflection: Reflection,
}

impl<'a> Assembly<'a> {
    pub fn new(parameters: &'a Parameters, beams: &'a [Beam; 2]) -> Self {
        let p = parameters;
        let places = Places { order: p.order };
        let roots_of_inertia = [p.arms[0].hub_inertia, p.arms[1].hub_inertia, p.moving_mass()].map(f64::sqrt);
        // θ̇_1 = θ̇_2 = 1, ẏ_M = l, straight arms.
        let mut rigid = DVector::zeros(2 * p.order + 1);
        for (arm, beam) in beams.iter().enumerate() {
            rigid.rows_mut(places.field(arm), p.order - 1).copy_from(&beam.rotation);
            rigid[places.hub(arm)] = roots_of_inertia[arm];
        }
        rigid[places.object()] = roots_of_inertia[2] * p.length;
        Self { parameters, beams, places, roots_of_inertia, reflection: Reflection::onto_last(rigid) }
    }

    /// Number of moment coordinates.
    fn moments(&self) -> usize {
        2 * self.parameters.order
    }

    /// Number of velocity coordinates.
    fn velocities(&self) -> usize {
        self.moments() + 1
    }

    /// K, from velocities to moment rates: ȧ = η(0) θ̇ + η'(l) ẏ_M − Gᵀ b for both arms.
    pub fn moment_rates(&self) -> DMatrix<f64> {
        let order = self.parameters.order;
        // Kᵀ, so that H reflects columns.
        let mut transposed = DMatrix::zeros(self.velocities(), self.moments());
        for (arm, beam) in self.beams.iter().enumerate() {
            let mut columns = transposed.columns_mut(arm * order, order);
            columns.rows_mut(self.places.field(arm), order - 1).copy_from(&-&beam.stiffness);
            columns.row_mut(self.places.hub(arm)).copy_from(&(&beam.root / self.roots_of_inertia[arm]));
            columns.row_mut(self.places.object()).copy_from(&(&beam.tip / self.roots_of_inertia[2]));
        }
        for mut column in transposed.column_iter_mut() {
            self.reflection.apply(column.as_mut_slice());
        }
        // The rigid motion bends nothing.
        transposed.row_mut(self.places.object()).fill(0.0);
        transposed.transpose()
    }

    /// The rows that read signals from x; `rates` is K.
    pub fn signal_rows(&self, rates: &DMatrix<f64>) -> DMatrix<f64> {
        let (moments, velocities) = (self.moments(), self.velocities());
        let mut rows = DMatrix::zeros(SIGNALS, moments + velocities);
        let places = [self.places.hub(0), self.places.hub(1), self.places.object()];
        for ((row, place), root) in VELOCITY.into_iter().zip(places).zip(self.roots_of_inertia) {
            let mut axis = DVector::zeros(velocities);
            axis[place] = 1.0 / root;
            self.reflection.apply(axis.as_mut_slice());
            rows.view_mut((row, moments), (1, velocities)).tr_copy_from(&axis);
        }
        for (arm, beam) in self.beams.iter().enumerate() {
            let order = self.parameters.order;
            rows.view_mut((ROOT_MOMENT[arm], arm * order), (1, order)).copy_from(&beam.root);
            rows.view_mut((TIP_SHEAR[arm], arm * order), (1, order)).copy_from(&beam.tip);
        }
        // A row that reads a moment, times K, reads its rate.
        let of_rates = product(&rows.view((0, 0), (SIGNALS, moments)).into_owned(), rates);
        for (signal, rate) in [(ROOT_MOMENT, ROOT_MOMENT_RATE), (TIP_SHEAR, TIP_SHEAR_RATE)] {
            for arm in 0..2 {
                rows.view_mut((rate[arm], moments), (1, velocities)).copy_from(&of_rates.row(signal[arm]));
            }
        }
        rows
    }

    /// A, from K and the rows of the signals.
    pub fn system(&self, rates: &DMatrix<f64>, signal_rows: &DMatrix<f64>) -> DMatrix<f64> {
        let (moments, velocities) = (self.moments(), self.velocities());
        // Rows of the hubs and of the object: Cᵀ, and the built-in forces per unit of each velocity coordinate.
        let inputs = DMatrix::from_fn(velocities, FORCES, |row, force| signal_rows[(VELOCITY[force], moments + row)]);
        let mut forces = DMatrix::zeros(FORCES, velocities);
        for (mut force, signals) in forces.column_iter_mut().zip(signal_rows.columns(moments, velocities).column_iter())
        {
            force.copy_from_slice(&builtin_forces(self.parameters, &std::array::from_fn(|i| signals[i])));
        }
        let viscous = product(&rates.transpose(), rates) * self.parameters.kelvin_voigt;
        let mut system = DMatrix::zeros(moments + velocities, moments + velocities);
        system.view_mut((0, moments), (moments, velocities)).copy_from(rates);
        system.view_mut((moments, 0), (velocities, moments)).copy_from(&-rates.transpose());
        system.view_mut((moments, moments), (velocities, velocities)).copy_from(&(product(&inputs, &forces) - viscous));
        system
    }
}
