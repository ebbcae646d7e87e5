//! The exact step of one size: the increment of the extended plant, in the kernel's form.

use crate::cache::OfOneSize;
use crate::dynamics::FORCES;
use crate::extended::Extended;
use crate::kernel::{LANES, Panels};
use nalgebra::DMatrix;

/// The exact step of one size.
#[derive(Debug)]
pub(crate) struct Propagator {
    h: f64,
    /// Increments of x and Θ from (x, g, r): n + 3 rows, n + 6 columns.
    step: Panels,
    /// Ψ from (x, g, r).
    travel_integral: Panels,
}

impl Propagator {
    pub fn new(extended: &Extended, h: f64) -> Self {
        let layout = extended.layout;
        let increment = extended.increment(h);
        // The extended vector without Θ and Ψ, which start from zero in every step.
        let entry =
            |row: usize, column: usize| increment[(row, if column < layout.n { column } else { column + 2 * FORCES })];
        let columns = layout.n + 2 * FORCES;
        let step = DMatrix::from_fn(layout.n + FORCES, columns, |row, column| {
            // (12) couples the increments: l Δθ_i = Δw_i(l) + Δy_M. Computing the rows of Δθ_i from the others makes it
            // hold to the last bit of each row, so the constraint does not drift.
            match row.checked_sub(layout.travel()) {
                Some(i) if i < 2 => {
                    let tip = extended.tip_compliance[i] * entry(extended.tip_coordinate[i], column);
                    (tip + entry(layout.travel() + 2, column)) / extended.length
                }
                _ => entry(row, column),
            }
        });
        let travel_integral =
            DMatrix::from_fn(FORCES, columns, |row, column| entry(layout.travel_integral() + row, column));
        Self { h, step: Panels::new(&step), travel_integral: Panels::new(&travel_integral) }
    }

    /// Every number of both matrices, padding included.
    #[cfg(test)]
    pub fn entries(&self) -> impl Iterator<Item = &f64> {
        self.step.entries().chain(self.travel_integral.entries())
    }

    /// Increments (x, Θ) over a whole step into `increment` (padded), from `drive` = (x, g) or (x, g, r).
    pub fn step(&self, drive: &[f64], increment: &mut [[f64; LANES]]) {
        self.step.multiply(drive, increment);
    }

    /// Ψ over a whole step, from `drive` = (x, g, r).
    pub fn travel_integral(&self, drive: &[f64]) -> [f64; FORCES] {
        let mut rows = [[0.0; LANES]];
        self.travel_integral.multiply(drive, &mut rows);
        [rows[0][0], rows[0][1], rows[0][2]]
    }
}

impl OfOneSize for Propagator {
    fn step_size(&self) -> f64 {
        self.h
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Dynamics;
    use crate::exponential::one_norm;
    use crate::extended::{LONGEST_STEP, MAX_PANELS};
    use crate::kernel::product;
    use crate::parameters::Parameters;

    fn extended(parameters: &Parameters) -> Extended {
        Extended::new(&Dynamics::new(parameters), parameters.length)
    }

    fn conservative(order: usize) -> Parameters {
        Parameters { order, root_uncertainty: 0.0, tip_uncertainty: 0.0, ..Parameters::default() }
    }

    /// exp of a skew matrix is orthogonal: ‖ΦᵀΦ − I‖ stays at rounding level for every step size.
    #[test]
    fn the_conservative_propagator_is_orthogonal() {
        for order in [4, 8, 24] {
            let extended = extended(&conservative(order));
            let n = extended.layout.n;
            for h in [1e-9, 1e-4, 1e-2, 1.0, LONGEST_STEP] {
                let increment = extended.increment(h);
                let phi = DMatrix::identity(n, n) + increment.view((0, 0), (n, n));
                let defect = product(&phi.transpose(), &phi) - DMatrix::identity(n, n);
                assert!(one_norm(&defect) < 1e-15 * n as f64, "order {order} h {h}: {:e}", one_norm(&defect));
            }
        }
    }

    #[test]
    fn parts_of_a_step_compose_to_the_step() {
        for parameters in [Parameters::default(), conservative(8)] {
            let extended = extended(&parameters);
            let h = 1e-3;
            let whole = extended.increment(h);
            // Rounding of exp(𝒜h) applied to a vector of ones, fast motions included.
            let tolerance = 4e-15 * h * one_norm(&extended.matrix) + 1e-13;
            let start: Vec<f64> = (0..extended.layout.size()).map(|i| (i as f64).sin()).collect();
            let mut scratch = [[0.0; LANES]; MAX_PANELS];
            for cut in [0.0, 1e-7, 0.3, 0.5, 0.9375, 1.0] {
                let mut z = start.clone();
                extended.advance(cut * h, &mut z, &mut scratch);
                extended.advance(h - cut * h, &mut z, &mut scratch);
                Panels::new(&whole).multiply(&start, &mut scratch);
                for (i, z) in z.iter().enumerate() {
                    let exact = start[i] + scratch.as_flattened()[i];
                    assert!((z - exact).abs() < tolerance, "cut {cut} entry {i}: {:e}", z - exact);
                }
            }
        }
    }
}
