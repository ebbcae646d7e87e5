//! The modes of a plant, and their consequences: maps to and from energy coordinates, effects of forces, rows of signals.

use super::block::Block;
use super::readings::Readings;
use super::step::Rigid;
use super::table::{GROUP, LANES};
use super::twofold::{Long, Twofold};
use super::vibration::Vibration;
use super::{damped, undamped};
use crate::dynamics::{Dynamics, FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY};
use nalgebra::DMatrix;

/// The effects of the forces on the two coordinates of a block.
pub(super) type Gains = [[f64; FORCES]; 2];

pub(super) struct Modes {
    pub blocks: Vec<Block>,
    /// The basis of each block's plane.
    columns: Vec<[Long; 2]>,
    /// The rows that read the coordinates in it, nearly.
    rows: Vec<[Vec<f64>; 2]>,
    /// By how much the rigid velocity differs from ζ per moment.
    rigid_moments: Vec<f64>,
}

/// Where a block's coordinates are among all.
fn place(block: usize, coordinate: usize) -> usize {
    block / LANES * GROUP + coordinate * LANES + block % LANES
}

impl Modes {
    /// None if the planes are not found.
    pub fn find(vibration: &Vibration, dynamics: &Dynamics) -> Option<Self> {
        let n = 2 * vibration.size;
        let planes = if vibration.certain {
            undamped::planes(vibration)
        } else {
            damped::planes(vibration, &dynamics.system.view((0, 0), (n, n)).into_owned())
        }?;
        let (mut blocks, mut columns, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for (j, mut plane) in planes.planes.into_iter().enumerate() {
            let mut both = [0, 1].map(|i| planes.inverse.row(2 * j + i).iter().copied().collect::<Vec<f64>>());
            if !vibration.certain {
                plane.orthonormalise(&mut both);
            }
            blocks.push(plane.standardise(&mut both));
            columns.push(plane.basis);
            rows.push(both);
        }
        Some(Self { blocks, columns, rows, rigid_moments: vibration.rigid_moments() })
    }

    /// Energy coordinates per modal coordinate, and, nearly, the inverse.
    pub fn maps(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = 2 * self.blocks.len();
        let length = self.blocks.len().div_ceil(LANES) * GROUP + 1;
        let (mut basis, mut inverse) = (DMatrix::zeros(n + 1, length), DMatrix::zeros(length, n + 1));
        for (j, (columns, rows)) in self.columns.iter().zip(&self.rows).enumerate() {
            for i in 0..2 {
                let mut column = basis.column_mut(place(j, i));
                column.rows_mut(0, n).copy_from_slice(&columns[i].hi);
                column[n] = columns[i].dot_plain(&self.rigid_moments).hi;
                for (m, entry) in rows[i].iter().enumerate() {
                    inverse[(place(j, i), m)] = *entry;
                }
            }
        }
        (basis[(n, length - 1)], inverse[(length - 1, n)]) = (1.0, 1.0);
        for (m, moment) in self.rigid_moments.iter().enumerate() {
            inverse[(length - 1, m)] = -moment;
        }
        (basis, inverse)
    }

    /// Γ, by block.
    pub fn gains(&self, vibration: &Vibration) -> Vec<Gains> {
        let mut gains = vec![Gains::default(); self.blocks.len()];
        for (force, column) in vibration.inputs.column_iter().enumerate() {
            let mut right = vec![0.0; vibration.size];
            right.extend(column.iter());
            for (gain, solved) in gains.as_flattened_mut().iter_mut().zip(self.solve(&right)) {
                gain[force] = solved;
            }
        }
        gains
    }

    /// z with V z = `right`, V being all bases side by side.
    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let read = |rest: &[f64]| -> Vec<f64> {
            self.rows.as_flattened().iter().map(|row| row.iter().zip(rest).map(|(r, x)| r * x).sum()).collect()
        };
        let mut z = read(right);
        for _ in 0..2 {
            let mut rest = Long::of(right);
            for (z, column) in z.iter().zip(self.columns.as_flattened()) {
                rest.add_multiple(Twofold::from(-z), column);
            }
            for (z, change) in z.iter_mut().zip(read(&rest.hi)) {
                *z += change;
            }
        }
        z
    }

    /// Signals and positions per coordinate.
    pub fn readings(&self, vibration: &Vibration, dynamics: &Dynamics) -> Readings {
        let n = 2 * vibration.size;
        let row = |signal: usize| -> Vec<f64> { dynamics.signal_rows.row(signal).iter().take(n).copied().collect() };
        let (velocities, root, tip) = (VELOCITY.map(row), ROOT_MOMENT.map(row), TIP_SHEAR.map(row));
        let mut readings = Readings::new(self.blocks.len(), &vibration.rigid_inputs);
        for (j, columns) in self.columns.iter().enumerate() {
            let motion = self.blocks[j].matrix();
            for (i, column) in columns.iter().enumerate() {
                let hidden = column.dot_plain(&self.rigid_moments);
                for ((signal, row), rigid) in VELOCITY.into_iter().zip(&velocities).zip(vibration.rigid_inputs) {
                    let velocity = column.dot_plain(row) + Twofold::from(rigid) * hidden;
                    *readings.entry(signal, j, i) = velocity.hi;
                }
            }
            for (signal, rate, rows) in [(ROOT_MOMENT, ROOT_MOMENT_RATE, &root), (TIP_SHEAR, TIP_SHEAR_RATE, &tip)] {
                for arm in 0..2 {
                    let read = [0, 1].map(|i| columns[i].dot_plain(&rows[arm]).hi);
                    for i in 0..2 {
                        // The moments change by Λ alone, and Λ has lost nothing that K's rows lose by cancellation.
                        *readings.entry(signal[arm], j, i) = read[i];
                        *readings.entry(rate[arm], j, i) = read[0] * motion[0][i] + read[1] * motion[1][i];
                    }
                }
            }
            let rate = [0, 1].map(|i| *readings.entry(VELOCITY[2], j, i));
            let inverse = self.blocks[j].inverse();
            let (lane, positions) = (j % LANES, &mut readings.groups[j / LANES].positions);
            for i in 0..2 {
                for (arm, tip) in positions.iter_mut().take(2).enumerate() {
                    tip[i][lane] = dynamics.tip_compliance[arm] * columns[i].hi[dynamics.tip_coordinate(arm)];
                }
                positions[2][i][lane] = rate[0] * inverse[0][i] + rate[1] * inverse[1][i];
            }
        }
        readings
    }

    /// The factor by which a coordinate, or the position that is read from it, can exceed the motion that it is part of.
    pub fn condition(&self, readings: &Readings, dynamics: &Dynamics) -> f64 {
        let reach = dynamics.tip_compliance[0].max(dynamics.tip_compliance[1]);
        let mut condition = 0.0f64;
        for (j, (columns, rows)) in self.columns.iter().zip(&self.rows).enumerate() {
            for i in 0..2 {
                let row = rows[i].iter().map(|entry| entry * entry).sum::<f64>().sqrt();
                let column = columns[i].hi.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
                let position = readings.groups[j / LANES].positions[2][i][j % LANES];
                condition = condition.max(row * column.max(position.abs() / reach));
            }
        }
        condition
    }
}

/// The rigid motion; drift = −p Γ.
pub(super) fn rigid(vibration: &Vibration, readings: &Readings, gains: &[Gains]) -> Rigid {
    let mut drift = [Twofold::default(); FORCES];
    for (j, gains) in gains.iter().enumerate() {
        for (i, gain) in gains.iter().enumerate() {
            let position = readings.groups[j / LANES].positions[2][i][j % LANES];
            for (drift, gain) in drift.iter_mut().zip(gain) {
                *drift = *drift - Twofold::product(position, *gain);
            }
        }
    }
    let (gain, drift) = (vibration.rigid_inputs, drift.map(|drift| drift.hi));
    let columns = [0, 1, 2].map(|force| [gain[force], drift[force], 0.0, 0.0]);
    Rigid { gain, velocity: gain[2], drift, columns }
}
