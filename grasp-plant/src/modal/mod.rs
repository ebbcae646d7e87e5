//! The plant in modal coordinates, where a step costs as much as there are coordinates.
//!
//! Without its rigid motion the plant falls into 2 × 2 blocks, each the motion in a plane that the others leave alone:
//!
//! ```text
//! (a, b) = V z,   ż = Λ z + Γ g,   ζ̇ = c·g,   y_M = p·z + Y,   Ẏ = velocity·ζ + drift·g.
//! ```
//!
//! ζ is the rigid velocity less what the built-in forces have done to it, which is a function of the moments; so it changes by
//! external forces alone, and a free plant keeps it to the bit. p = (row of ẏ_M) Λ⁻¹.
//!
//! Planes are found in [`undamped`] (no built-in uncertainties: they are orthonormal) or in [`damped`], in twice the precision,
//! and made [`Block`]s. Coordinates lose digits where planes lie close to each other. How many, says the [condition](Modal): from
//! [`WORST_CONDITION`] on the plant is stepped by its dense matrices instead.

mod block;
mod damped;
mod elementary;
mod plane;
mod step;
mod twofold;
mod undamped;
mod vibration;

pub(crate) use step::{NEGLIGIBLE, Table, Travel};

use crate::dynamics::{Dynamics, FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, Signals, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY};
use crate::kernel::{LANES as PANEL, Panels};
use crate::parameters::Parameters;
use block::Block;
use nalgebra::DMatrix;
use step::{GROUP, LANES, Motion, Readings, Rigid};
use twofold::{Long, Twofold};
use vibration::Vibration;

/// The largest condition of modal coordinates in which a plant is stepped: rounding of a coordinate, 1e-16 of it, may be so many
/// times as much of the whole motion.
const WORST_CONDITION: f64 = 1e7;

/// A plant in modal coordinates.
#[derive(Debug)]
pub(crate) struct Modal {
    blocks: Vec<Block>,
    /// Γ, by block.
    gains: Vec<[[f64; FORCES]; 2]>,
    readings: Readings,
    rigid: Rigid,
    /// Energy coordinates per modal coordinate.
    basis: DMatrix<f64>,
    basis_panels: Panels,
    /// Modal coordinates per energy coordinate, nearly.
    inverse: Panels,
    /// Length of the largest row of the inverse: by how much a coordinate can exceed the motion that it is part of.
    condition: f64,
}

impl Modal {
    /// None if the planes are too close to each other.
    pub fn new(dynamics: &Dynamics, parameters: &Parameters) -> Option<Self> {
        let vibration = Vibration::new(dynamics, parameters);
        let n = 2 * vibration.size;
        let planes = if vibration.certain {
            undamped::planes(&vibration)
        } else {
            damped::planes(&vibration, &dynamics.system.view((0, 0), (n, n)).into_owned())
        }?;
        let count = planes.planes.len();
        let mut blocks = Vec::with_capacity(count);
        let mut columns: Vec<[Long; 2]> = Vec::with_capacity(count);
        let mut rows: Vec<[Vec<f64>; 2]> = Vec::with_capacity(count);
        for (j, mut plane) in planes.planes.into_iter().enumerate() {
            let mut both = [0, 1].map(|i| planes.inverse.row(2 * j + i).iter().copied().collect::<Vec<f64>>());
            if !vibration.certain {
                plane.orthonormalise(&mut both);
            }
            blocks.push(plane.standardise(&mut both));
            columns.push(plane.basis);
            rows.push(both);
        }
        let rigid_moments = vibration.rigid_moments();
        let groups = count.div_ceil(LANES);
        // Where a block's coordinates are.
        let place = |block: usize, i: usize| block / LANES * GROUP + i * LANES + block % LANES;
        let (length, whole) = (groups * GROUP + 1, n + 1);
        let mut basis = DMatrix::zeros(whole, length);
        let mut inverse = DMatrix::zeros(length, whole);
        for (j, (columns, rows)) in columns.iter().zip(&rows).enumerate() {
            for i in 0..2 {
                let mut column = basis.column_mut(place(j, i));
                column.rows_mut(0, n).copy_from_slice(&columns[i].hi);
                column[n] = columns[i].dot_plain(&rigid_moments).hi;
                for (m, entry) in rows[i].iter().enumerate() {
                    inverse[(place(j, i), m)] = *entry;
                }
            }
        }
        (basis[(n, length - 1)], inverse[(length - 1, n)]) = (1.0, 1.0);
        for (m, moment) in rigid_moments.iter().enumerate() {
            inverse[(length - 1, m)] = -moment;
        }

        let forces: Vec<Vec<f64>> = vibration
            .inputs
            .column_iter()
            .map(|column| [&vec![0.0; vibration.size][..], column.as_slice()].concat())
            .collect();
        let solved: Vec<Vec<f64>> = forces.iter().map(|force| solve(force, &columns, &rows)).collect();
        let gains: Vec<[[f64; FORCES]; 2]> =
            (0..count).map(|j| [0, 1].map(|i| std::array::from_fn(|force| solved[force][2 * j + i]))).collect();

        let row = |signal: usize| -> Vec<f64> { dynamics.signal_rows.row(signal).iter().take(n).copied().collect() };
        let velocity_rows = VELOCITY.map(row);
        let moment_rows = [ROOT_MOMENT, TIP_SHEAR].map(|both| both.map(row));
        let rigid_velocities = VELOCITY.map(|signal| dynamics.signal_rows[(signal, n)]);
        let mut signals = vec![[Signals::default(); GROUP]; groups];
        let mut rigid_signals = Signals::default();
        for (signal, velocity) in VELOCITY.into_iter().zip(rigid_velocities) {
            rigid_signals[signal] = velocity;
        }
        let mut positions = vec![[[[0.0; LANES]; 2]; FORCES]; groups];
        let mut drift = [Twofold::default(); FORCES];
        let mut condition = 0.0f64;
        let reach = dynamics.tip_compliance[0].max(dynamics.tip_compliance[1]);
        for (j, columns) in columns.iter().enumerate() {
            let (lane, motion) = (j % LANES, blocks[j].matrix());
            let signals = &mut signals[j / LANES];
            let mut object_rate = [0.0; 2];
            for (i, column) in columns.iter().enumerate() {
                let hidden = column.dot_plain(&rigid_moments);
                for (f, signal) in VELOCITY.into_iter().enumerate() {
                    let velocity = column.dot_plain(&velocity_rows[f]) + Twofold::from(rigid_velocities[f]) * hidden;
                    signals[i * LANES + lane][signal] = velocity.hi;
                }
                object_rate[i] = signals[i * LANES + lane][VELOCITY[2]];
            }
            let rates = [ROOT_MOMENT_RATE, TIP_SHEAR_RATE];
            for ((signal, rate), rows) in [ROOT_MOMENT, TIP_SHEAR].into_iter().zip(rates).zip(&moment_rows) {
                for arm in 0..2 {
                    let read = [0, 1].map(|i| columns[i].dot_plain(&rows[arm]).hi);
                    for i in 0..2 {
                        // The moments change by Λ alone, and Λ has lost nothing that K's rows lose by cancellation.
                        signals[i * LANES + lane][signal[arm]] = read[i];
                        signals[i * LANES + lane][rate[arm]] = read[0] * motion[0][i] + read[1] * motion[1][i];
                    }
                }
            }
            let place = &mut positions[j / LANES];
            let [[a, b], [c, d]] = blocks[j].inverse();
            let object = [object_rate[0] * a + object_rate[1] * c, object_rate[0] * b + object_rate[1] * d];
            for i in 0..2 {
                for arm in 0..2 {
                    place[arm][i][lane] = dynamics.tip_compliance[arm] * columns[i].hi[dynamics.tip_coordinate(arm)];
                }
                place[2][i][lane] = object[i];
                for (force, drift) in drift.iter_mut().enumerate() {
                    *drift = *drift - Twofold::product(object[i], gains[j][i][force]);
                }
                let row = rows[j][i].iter().map(|entry| entry * entry).sum::<f64>().sqrt();
                condition = condition.max(row * (object[i].abs() / reach).max(1.0));
            }
        }
        let modal = Self {
            blocks,
            gains,
            readings: Readings { signals, rigid: rigid_signals, positions },
            rigid: Rigid {
                gain: vibration.rigid_inputs,
                velocity: rigid_signals[VELOCITY[2]],
                drift: drift.map(|drift| drift.hi),
            },
            basis_panels: Panels::new(&basis),
            basis,
            inverse: Panels::new(&inverse),
            condition,
        };
        (modal.condition < WORST_CONDITION && modal.is_finite()).then_some(modal)
    }

    fn is_finite(&self) -> bool {
        let positions = self.readings.positions.as_flattened().as_flattened().as_flattened();
        let gains = self.gains.as_flattened().as_flattened();
        self.basis.iter().chain(positions).chain(gains).chain(&self.rigid.drift).all(|number| number.is_finite())
    }

    /// Number of modal coordinates, those included that only fill up a group, and ζ.
    pub fn size(&self) -> usize {
        self.basis.ncols()
    }

    /// Room for the step of a size.
    pub fn table(&self) -> Table {
        Table::new(self.blocks.len())
    }

    /// Makes a table that of step size h.
    pub fn fill(&self, table: &mut Table, h: f64) {
        table.fill(h, &self.blocks, &self.gains);
    }

    /// One step of the table's size with forces g + r t, into `next`.
    #[inline]
    pub fn step(
        &self,
        table: &Table,
        from: &[f64],
        forces: &[f64; FORCES],
        rates: Option<&[f64; FORCES]>,
        next: &mut [f64],
    ) -> Travel {
        Motion { table, readings: &self.readings, rigid: &self.rigid, from, forces, rates }.make(next)
    }

    /// All signals of modal coordinates.
    #[inline]
    pub fn signals(&self, coordinates: &[f64]) -> Signals {
        self.readings.signals(coordinates)
    }

    /// Tip deflections w_i(l) \[m\] of modal coordinates.
    pub fn tip_deflection(&self, coordinates: &[f64]) -> [f64; 2] {
        self.readings.tip_deflection(coordinates)
    }

    /// Energy coordinates of modal ones.
    pub fn energy_coordinates(&self, coordinates: &[f64], energy: &mut [f64]) {
        let mut padded = [[0.0; PANEL]; crate::extended::MAX_PANELS];
        self.basis_panels.multiply(coordinates, &mut padded);
        energy.copy_from_slice(&padded.as_flattened()[..energy.len()]);
    }

    /// Modal coordinates of energy coordinates: the product with the inverse, and what that leaves over in twice the precision.
    pub fn modal_coordinates(&self, energy: &[f64], coordinates: &mut [f64]) {
        let mut padded = [[0.0; PANEL]; crate::extended::MAX_PANELS];
        self.inverse.multiply(energy, &mut padded);
        coordinates.copy_from_slice(&padded.as_flattened()[..coordinates.len()]);
        for _ in 0..2 {
            let mut rest = Long::of(energy);
            for (column, z) in self.basis.column_iter().zip(&*coordinates) {
                rest.add_scaled(Twofold::from(-z), column.as_slice());
            }
            self.inverse.multiply(&rest.hi, &mut padded);
            for (z, change) in coordinates.iter_mut().zip(padded.as_flattened()) {
                *z += change;
            }
        }
    }

    /// Every number of the set-up.
    #[cfg(test)]
    pub fn numbers(&self) -> Vec<f64> {
        let blocks = self.blocks.iter().flat_map(|block| block.matrix().as_flattened().to_vec());
        let gains = self.gains.as_flattened().as_flattened().iter().copied();
        let positions = self.readings.positions.as_flattened().as_flattened().as_flattened().iter().copied();
        let signals = self.readings.signals.as_flattened().as_flattened().iter().copied();
        let basis = self.basis.iter().copied();
        blocks.chain(gains).chain(positions).chain(signals).chain(basis).chain(self.rigid.drift).collect()
    }

    #[cfg(test)]
    pub fn condition(&self) -> f64 {
        self.condition
    }
}

/// z with V z = `right`, V being all bases side by side.
fn solve(right: &[f64], columns: &[[Long; 2]], rows: &[[Vec<f64>; 2]]) -> Vec<f64> {
    let read = |rest: &[f64]| -> Vec<f64> {
        rows.as_flattened().iter().map(|row| row.iter().zip(rest).map(|(r, x)| r * x).sum()).collect()
    };
    let mut z = read(right);
    for _ in 0..2 {
        let mut rest = Long::of(right);
        for (z, column) in z.iter().zip(columns.as_flattened()) {
            rest.add_multiple(Twofold::from(-z), column);
        }
        for (z, change) in z.iter_mut().zip(read(&rest.hi)) {
            *z += change;
        }
    }
    z
}

#[cfg(test)]
mod tests;
