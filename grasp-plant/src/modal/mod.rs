//! The plant in modal coordinates, in which the cost of a step is proportional to the number of coordinates.
//!
//! Without its rigid motion the plant decomposes into 2 × 2 blocks, each the motion in an invariant plane:
//!
//! ```text
//! (a, b) = V z,   ż = Λ z + Γ g,   ζ̇ = c·g,   y_M = p·z + Y,   Ẏ = velocity·ζ + drift·g.
//! ```
//!
//! ζ is the rigid velocity minus the effect of the built-in forces on it, which is a function of the moments. So ζ changes
//! by external forces alone, and a free plant conserves it to the bit. p = (row of ẏ_M) Λ⁻¹.
//!
//! Planes are computed in [`undamped`] (no built-in uncertainties: they are orthonormal) or in [`damped`], in twice the
//! precision, and become [`Block`]s. Coordinates lose digits if planes are close to each other; the [condition](Modal)
//! measures how many. From [`WORST_CONDITION`] on the plant is stepped by its dense matrices instead.

mod arrangement;
mod block;
mod calm;
mod damped;
mod elementary;
mod equal_arms;
mod four;
mod held;
mod modes;
mod plane;
mod readings;
mod step;
mod table;
mod twofold;
mod undamped;
mod vibration;
#[cfg(target_arch = "x86_64")]
mod wide;

pub(crate) use calm::{BUDGET, CALM};
pub(crate) use four::{DeadZones, Four};
pub(crate) use step::{NEGLIGIBLE, Travel};
pub(crate) use table::{Lanes, Table};
#[cfg(target_arch = "x86_64")]
pub(crate) use wide::Wide;

use crate::dynamics::{Dynamics, FORCES, Signals};
use crate::kernel::{LANES as PANEL, Panels};
use crate::parameters::Parameters;
use crate::state::{Basis, State};
use block::Block;
use modes::Modes;
use nalgebra::DMatrix;
use readings::Readings;
use step::{Motion, Rigid};
use twofold::{Long, Twofold};
use vibration::Vibration;

/// The largest condition of modal coordinates with which a plant is stepped. The rounding error of a coordinate, 1e-16 of
/// it, may be this many times as large relative to the whole motion.
const WORST_CONDITION: f64 = 1e6;

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
    /// By how much a coordinate can exceed the motion that it is part of.
    condition: f64,
    /// By how much forces can exceed the inputs, and the arms' length: see [`calm`].
    gain: f64,
    length: f64,
}

impl Modal {
    /// None if the planes are too close to each other.
    pub fn new(dynamics: &Dynamics, parameters: &Parameters) -> Option<Self> {
        let equal_arms = parameters.arms[0] == parameters.arms[1];
        let mut vibration = Vibration::new(dynamics, parameters);
        if vibration.certain && vibration.viscosity > 0.0 {
            // The dense matrices keep the balance of energy exactly; in overdamped modes short modal steps would lose it by
            // cancellation.
            return None;
        }
        if equal_arms {
            // What both have lost to rounding may differ.
            let [first, second, object] = vibration.rigid_inputs;
            vibration.rigid_inputs = [f64::midpoint(first, second), f64::midpoint(first, second), object];
        }
        let modes = Modes::find(&vibration, dynamics, equal_arms)?;
        let (basis, inverse) = modes.maps();
        let gains = modes.gains(&vibration);
        let readings = modes.readings(&vibration, dynamics);
        let rigid = modes::rigid(&vibration, &readings, &gains);
        let modal = Self {
            condition: modes.condition(&readings, dynamics),
            blocks: modes.blocks,
            gains,
            readings,
            rigid,
            basis_panels: Panels::new(&basis),
            basis,
            inverse: Panels::new(&inverse),
            gain: calm::gain(parameters),
            length: parameters.length,
        };
        (modal.condition < WORST_CONDITION && modal.is_finite()).then_some(modal)
    }

    fn is_finite(&self) -> bool {
        let positions = self.readings.positions().flatten().flatten().flatten();
        let gains = self.gains.as_flattened().as_flattened();
        self.basis.iter().chain(positions).chain(gains).chain(&self.rigid.drift).all(|number| number.is_finite())
    }

    /// What a state in these coordinates says that they are.
    pub fn state_basis(&self) -> Basis {
        if self.readings.arrangement.equal_arms { Basis::EvenAndOdd } else { Basis::Modal }
    }

    /// Number of modal coordinates, those included that only fill up a group, and ζ.
    pub fn size(&self) -> usize {
        self.basis.ncols()
    }

    /// Room for the step of a size.
    pub fn table(&self) -> Table {
        Table::new(self.readings.arrangement)
    }

    /// The step of size h, to be kept.
    pub fn table_of(&self, h: f64) -> Table {
        let mut table = self.table();
        self.fill(&mut table, h);
        table.calm_cost = calm::cost(&table, &self.readings, &self.rigid, self.gain, self.length);
        table
    }

    /// Makes a table that of step size h.
    pub fn fill(&self, table: &mut Table, h: f64) {
        table.fill(h, &self.blocks, &self.gains, &self.readings, &self.rigid, self.length);
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
        let Self { readings, rigid, length, .. } = self;
        Motion { table, readings, rigid, length: *length, from, forces, rates }.make(next)
    }

    /// Moves a state of modal coordinates by a step of the table's size with held forces, and reads the signals that every step reads; gives
    /// the shears' rates and the shears, or none if the coordinates are not as many. All must be [calm](CALM).
    #[allow(clippy::inline_always)] // Into a function for wide registers, or the compiler does not use these registers.
    #[inline(always)]
    pub fn hold<V: Four>(&self, table: &Table, forces: V, state: &mut State, signals: &mut Signals) -> Option<V> {
        held::Held { table, readings: &self.readings, forces }.make(state, signals)
    }

    /// All signals of modal coordinates but the rates of the root moments.
    #[inline]
    pub fn signals(&self, coordinates: &[f64]) -> Signals {
        self.readings.signals(coordinates)
    }

    /// Rates of the root moments \[N·m/s\].
    pub fn root_moment_rates(&self, coordinates: &[f64]) -> [f64; 2] {
        self.readings.root_moment_rates(coordinates)
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

    /// Modal coordinates of energy coordinates: the product with the inverse, and a correction by the residual in twice the
    /// precision.
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
        let basis = self.basis.iter().copied();
        blocks.chain(gains).chain(self.readings.numbers()).chain(basis).chain(self.rigid.drift).collect()
    }

    #[cfg(test)]
    pub fn condition(&self) -> f64 {
        self.condition
    }
}

#[cfg(test)]
mod tests;
