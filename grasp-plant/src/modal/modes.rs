//! The modes of a plant, and their consequences: maps to and from energy coordinates, effects of forces, rows of signals.

use super::arrangement::{Arrangement, Parity};
use super::block::Block;
use super::plane::Planes;
use super::readings::Readings;
use super::step::Rigid;
use super::table::{GROUP, LANES};
use super::twofold::{Long, Twofold};
use super::vibration::Vibration;
use super::{damped, equal_arms, undamped};
use crate::dynamics::{Dynamics, FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, Signals, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY};
use nalgebra::DMatrix;

/// The effects of the forces on the two coordinates of a block.
pub(super) type Gains = [[f64; FORCES]; 2];

pub(super) struct Modes {
    pub blocks: Vec<Block>,
    arrangement: Arrangement,
    /// The basis of each block's plane.
    columns: Vec<[Long; 2]>,
    /// The rows that read the coordinates in it, nearly.
    rows: Vec<[Vec<f64>; 2]>,
    /// By how much the rigid velocity differs from ζ per moment.
    rigid_moments: Vec<f64>,
}

impl Modes {
    /// None if the planes are not found. Of equal arms the even ones come first.
    pub fn find(vibration: &Vibration, dynamics: &Dynamics, equal_arms: bool) -> Option<Self> {
        let parts = if equal_arms {
            let part = |parity| equal_arms::planes(vibration, &dynamics.system, parity);
            vec![part(Parity::Even)?, part(Parity::Odd)?]
        } else if vibration.certain {
            vec![undamped::planes(vibration)?]
        } else {
            let n = 2 * vibration.size;
            vec![damped::planes(vibration, &dynamics.system.view((0, 0), (n, n)).into_owned())?]
        };
        let (mut blocks, mut columns, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for Planes { planes, inverse } in parts {
            for (j, mut plane) in planes.into_iter().enumerate() {
                let mut both = [0, 1].map(|i| inverse.row(2 * j + i).iter().copied().collect::<Vec<f64>>());
                if !vibration.certain {
                    plane.orthonormalise(&mut both);
                }
                blocks.push(plane.standardise(&mut both));
                columns.push(plane.basis);
                rows.push(both);
            }
        }
        let arrangement = Arrangement { blocks: blocks.len(), equal_arms };
        Some(Self { blocks, arrangement, columns, rows, rigid_moments: vibration.rigid_moments() })
    }

    /// Where a block's coordinate is among all.
    fn place(&self, block: usize, coordinate: usize) -> usize {
        let (group, lane) = self.arrangement.place_among_all(block);
        group * GROUP + coordinate * LANES + lane
    }

    /// By how much the rigid velocity exceeds ζ per coordinate of a block. Odd ones do not move it.
    fn hidden(&self, block: usize, column: &Long) -> Twofold {
        match self.arrangement.parity(block) {
            Some(Parity::Odd) => Twofold::default(),
            _ => column.dot_plain(&self.rigid_moments),
        }
    }

    /// Energy coordinates per modal coordinate, and, nearly, the inverse.
    pub fn maps(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = 2 * self.blocks.len();
        let length = self.arrangement.groups() * GROUP + 1;
        let (mut basis, mut inverse) = (DMatrix::zeros(n + 1, length), DMatrix::zeros(length, n + 1));
        for (j, (columns, rows)) in self.columns.iter().zip(&self.rows).enumerate() {
            for i in 0..2 {
                let mut column = basis.column_mut(self.place(j, i));
                column.rows_mut(0, n).copy_from_slice(&columns[i].hi);
                column[n] = self.hidden(j, &columns[i]).hi;
                for (m, entry) in rows[i].iter().enumerate() {
                    inverse[(self.place(j, i), m)] = *entry;
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
        for (block, gains) in gains.iter_mut().enumerate() {
            let Some(parity) = self.arrangement.parity(block) else { break };
            for gain in gains {
                gain[1] = parity.sign() * gain[0];
                gain[2] = if parity == Parity::Odd { 0.0 } else { gain[2] };
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
        let mut readings = Readings::new(self.arrangement, &vibration.rigid_inputs);
        for (j, columns) in self.columns.iter().enumerate() {
            let motion = self.blocks[j].matrix();
            let mut signals = [Signals::default(); 2];
            for (signals, column) in signals.iter_mut().zip(columns) {
                let hidden = self.hidden(j, column);
                for ((signal, row), rigid) in VELOCITY.into_iter().zip(&velocities).zip(vibration.rigid_inputs) {
                    signals[signal] = (column.dot_plain(row) + Twofold::from(rigid) * hidden).hi;
                }
            }
            for (signal, rate, rows) in [(ROOT_MOMENT, ROOT_MOMENT_RATE, &root), (TIP_SHEAR, TIP_SHEAR_RATE, &tip)] {
                for arm in 0..2 {
                    let read = [0, 1].map(|i| columns[i].dot_plain(&rows[arm]).hi);
                    for i in 0..2 {
                        // The moments change by Λ alone, and Λ has lost nothing that K's rows lose by cancellation.
                        signals[i][signal[arm]] = read[i];
                        signals[i][rate[arm]] = read[0] * motion[0][i] + read[1] * motion[1][i];
                    }
                }
            }
            let tip =
                |arm: usize| [0, 1].map(|i| dynamics.tip_compliance[arm] * columns[i].hi[dynamics.tip_coordinate(arm)]);
            let (first, mut second) = (tip(0), tip(1));
            if let Some(parity) = self.arrangement.parity(j) {
                // The second arm's entries are those of the first one, and odd blocks do not move the object.
                let sign = parity.sign();
                for signals in &mut signals {
                    for [first, second] in
                        [[VELOCITY[0], VELOCITY[1]], TIP_SHEAR_RATE, ROOT_MOMENT_RATE, ROOT_MOMENT, TIP_SHEAR]
                    {
                        signals[second] = sign * signals[first];
                    }
                    signals[VELOCITY[2]] = if parity == Parity::Odd { 0.0 } else { signals[VELOCITY[2]] };
                }
                second = first.map(|entry| sign * entry);
            }
            let inverse = self.blocks[j].inverse();
            let [rate, rate_2] = signals.map(|signals| signals[VELOCITY[2]]);
            let object = [0, 1].map(|i| rate * inverse[0][i] + rate_2 * inverse[1][i]);
            readings.put(j, &signals, &[first, second, object]);
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
                let position = readings.object_position(j, i);
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
            let position = readings.object_position(j, i);
            for (drift, gain) in drift.iter_mut().zip(gain) {
                *drift = *drift - Twofold::product(position, *gain);
            }
        }
    }
    let (gain, drift) = (vibration.rigid_inputs, drift.map(|drift| drift.hi));
    Rigid { gain, velocity: gain[2], drift }
}
