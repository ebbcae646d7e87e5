//! Exact time stepping: the matrix exponential of the plant with held or ramped forces.
//!
//! The plant is extended by the integrals of its three velocities (the position increments Θ), by their integrals
//! (Ψ = ∫Θ, for the work of a ramp), and by the forces g and their rates r:
//!
//! ```text
//! ẋ = A x + B g,   Θ̇ = Bᵀ x,   Ψ̇ = Θ,   ġ = r,   ṙ = 0.
//! ```
//!
//! Everything is computed as the *increment* D = exp(𝒜h) − I: a Taylor polynomial of degree 16 at h/2^s, then s doublings
//! 2D + D². So slow motions, whose increments are small, keep their relative accuracy, which exp(𝒜h) itself would bury
//! under the 1 on its diagonal. Where A is skew, Newton–Schulz steps remove what rounding left of I − ΦᵀΦ, which the
//! doublings would otherwise amplify.

use crate::dense::{LANES, Matrix, Panels};
use crate::dynamics::{Dynamics, FORCES};
use std::sync::{Arc, OnceLock};

/// No step may be longer \[s\].
pub const LONGEST_STEP: f64 = 100.0;

/// No step may take more doublings: each costs a bit of the fastest motions' phase.
const MOST_DOUBLINGS: u32 = 40;

/// Norm at which the degree-16 Taylor polynomial of exp leaves a remainder below the rounding unit: 0.75¹⁷/17! = 2·10⁻¹⁷.
const TAYLOR_NORM: f64 = 0.75;

/// Where things are in the extended vector (x, Θ, Ψ, g, r) for n = |x|.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    n: usize,
}

impl Layout {
    pub fn travel(self) -> usize {
        self.n
    }

    pub fn travel_integral(self) -> usize {
        self.n + FORCES
    }

    pub fn force(self) -> usize {
        self.n + 2 * FORCES
    }

    pub fn force_rate(self) -> usize {
        self.n + 3 * FORCES
    }

    pub fn size(self) -> usize {
        self.n + 4 * FORCES
    }
}

/// The extended system 𝒜 and what depends on it alone.
#[derive(Clone, Debug)]
pub(crate) struct Extended {
    pub layout: Layout,
    matrix: Matrix,
    panels: Panels,
    /// Longest admissible step \[s\].
    pub longest_step: f64,
    /// The largest power of two \[s\] whose product with ‖𝒜‖ is at most [`TAYLOR_NORM`].
    base: f64,
    /// Increments of the durations base·2^level, made when first needed: see [`Self::advance`].
    ladder: Vec<OnceLock<Panels>>,
    conservative: bool,
    /// Indices of both arms' tip coordinates, their compliance, and the arm length: what (12) is made of.
    tip_coordinate: [usize; 2],
    tip_compliance: [f64; 2],
    length: f64,
}

impl Extended {
    pub fn new(dynamics: &Dynamics, length: f64) -> Self {
        let n = dynamics.size();
        let layout = Layout { n };
        let mut matrix = Matrix::zeros(layout.size(), layout.size());
        for j in 0..n {
            for i in 0..n {
                matrix[(i, j)] = dynamics.system[(i, j)];
            }
            for force in 0..FORCES {
                matrix[(layout.travel() + force, j)] = dynamics.input(j, force);
                matrix[(j, layout.force() + force)] = dynamics.input(j, force);
            }
        }
        for force in 0..FORCES {
            matrix[(layout.travel_integral() + force, layout.travel() + force)] = 1.0;
            matrix[(layout.force() + force, layout.force_rate() + force)] = 1.0;
        }
        let norm = matrix.one_norm();
        let mut base = 1.0;
        while base * norm > TAYLOR_NORM {
            base *= 0.5;
        }
        while 2.0 * base * norm <= TAYLOR_NORM && base < LONGEST_STEP {
            base *= 2.0;
        }
        let longest_step = (base * (1u64 << MOST_DOUBLINGS) as f64).min(LONGEST_STEP);
        Self {
            layout,
            base,
            ladder: vec![OnceLock::new(); MOST_DOUBLINGS as usize + 1],
            panels: Panels::new(&matrix),
            matrix,
            longest_step,
            conservative: dynamics.conservative,
            tip_coordinate: [dynamics.tip_coordinate(0), dynamics.tip_coordinate(1)],
            tip_compliance: dynamics.tip_compliance,
            length,
        }
    }

    /// exp(𝒜 h) − I.
    fn increment(&self, h: f64) -> Matrix {
        let mut scaled = self.matrix.clone();
        let (mut part, mut doublings) = (h, 0);
        while part > self.base {
            part *= 0.5;
            doublings += 1;
        }
        scaled.scale(part);
        let mut increment = taylor(&scaled);
        for doubling in 1..=doublings {
            let mut doubled = increment.multiply(&increment);
            doubled.add_scaled(2.0, &increment);
            increment = doubled;
            // Newton–Schulz converges quadratically, doublings amplify by two: every eighth and the last suffice.
            if self.conservative && (doubling % 8 == 0 || doubling == doublings) {
                orthogonalise(&mut increment, self.layout.n);
            }
        }
        increment
    }

    /// Advances the extended vector z by any duration from 0 to [`Self::longest_step`] without a matrix of its own: the
    /// binary digits of the duration choose matrices of a ladder of doubled durations, and the Taylor series does the rest.
    ///
    /// The first use of a rung makes it and so allocates.
    pub fn advance(&self, duration: f64, z: &mut [f64], scratch: &mut [[f64; LANES]]) {
        // Exact: the base is a power of two.
        let multiple = (duration / self.base).floor();
        let rest = duration - multiple * self.base;
        let mut remaining = multiple;
        for (level, rung) in self.ladder.iter().enumerate().rev() {
            let rung_multiple = (1u64 << level) as f64;
            if remaining >= rung_multiple {
                remaining -= rung_multiple;
                let matrix = rung.get_or_init(|| Panels::new(&self.increment(self.base * rung_multiple)));
                matrix.multiply(z, scratch);
                add(z, scratch);
            }
        }
        // ‖𝒜‖·rest ≤ TAYLOR_NORM, so term m is below 0.75^m/m!.
        let mut term = [[0.0; LANES]; MAX_PANELS];
        term.as_flattened_mut()[..z.len()].copy_from_slice(z);
        for m in 1..=17 {
            self.panels.multiply(&term.as_flattened()[..z.len()], scratch);
            let factor = rest / f64::from(m);
            for (term, product) in term.as_flattened_mut().iter_mut().zip(scratch.as_flattened()) {
                *term = factor * product;
            }
            add(z, &term);
        }
    }
}

/// exp(X) − I for ‖X‖ ≤ [`TAYLOR_NORM`]: the Taylor polynomial of degree 16 by Paterson and Stockmeyer, six products.
fn taylor(x: &Matrix) -> Matrix {
    let coefficient: [f64; 17] = {
        let mut c = [1.0; 17];
        for m in 1..17 {
            c[m] = c[m - 1] / m as f64;
        }
        c
    };
    let squared = x.multiply(x);
    let cubed = squared.multiply(x);
    let fourth = squared.multiply(&squared);
    let cubic_part = |first: usize| {
        let mut part = x.clone();
        part.scale(coefficient[first + 1]);
        part.add_scaled(coefficient[first + 2], &squared);
        part.add_scaled(coefficient[first + 3], &cubed);
        part
    };
    let identity = Matrix::from_fn(x.rows(), x.rows(), |i, j| f64::from(u8::from(i == j)));
    let mut sum = cubic_part(12);
    sum.add_scaled(coefficient[16], &fourth);
    for first in [8, 4, 0] {
        // sum ← x⁴ (c_{first+4} + sum) + c_{first+1} x + c_{first+2} x² + c_{first+3} x³
        sum.add_scaled(coefficient[first + 4], &identity);
        let mut next = fourth.multiply(&sum);
        next.add_scaled(1.0, &cubic_part(first));
        sum = next;
    }
    sum
}

/// One Newton–Schulz step towards the nearest orthogonal Φ = I + D, on the leading n × n block of D:
/// with E = D + Dᵀ + DᵀD = ΦᵀΦ − I, Φ ← Φ (I − E/2).
fn orthogonalise(increment: &mut Matrix, n: usize) {
    let block = Matrix::from_fn(n, n, |i, j| increment[(i, j)]);
    let transposed = block.transpose();
    let mut defect = transposed.multiply(&block);
    defect.add_scaled(1.0, &Matrix::from_fn(n, n, |i, j| block[(i, j)] + transposed[(i, j)]));
    let product = block.multiply(&defect);
    for j in 0..n {
        for i in 0..n {
            increment[(i, j)] -= 0.5 * (defect[(i, j)] + product[(i, j)]);
        }
    }
}

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
        let step = Matrix::from_fn(layout.n + FORCES, columns, |row, column| {
            // (12) ties the increments together: l Δθ_i = Δw_i(l) + Δy_M. Deriving the rows of Δθ_i from the others makes
            // it hold to the last bit of each row, so the constraint does not drift.
            match row.checked_sub(layout.travel()) {
                Some(i) if i < 2 => {
                    let tip = extended.tip_compliance[i] * entry(extended.tip_coordinate[i], column);
                    (tip + entry(layout.travel() + 2, column)) / extended.length
                }
                _ => entry(row, column),
            }
        });
        let travel_integral =
            Matrix::from_fn(FORCES, columns, |row, column| entry(layout.travel_integral() + row, column));
        Self { h, step: Panels::new(&step), travel_integral: Panels::new(&travel_integral) }
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

/// Panels of the largest extended vector.
pub(crate) const MAX_PANELS: usize = (4 * *crate::parameters::ORDER_RANGE.end() + 1 + 4 * FORCES).div_ceil(LANES);

fn add(z: &mut [f64], increment: &[[f64; LANES]]) {
    for (z, increment) in z.iter_mut().zip(increment.as_flattened()) {
        *z += increment;
    }
}

/// The propagators of recently used step sizes, most recent first. Clones share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cache {
    entries: Vec<Arc<Propagator>>,
}

impl Cache {
    /// Step sizes kept. Masters that compute their step as a difference of times use a few sizes that differ by rounding.
    pub const CAPACITY: usize = 8;

    /// The propagator of step size h, made now if it is not among the [`CAPACITY`](Self::CAPACITY) last used.
    pub fn get(&mut self, extended: &Extended, h: f64) -> &Propagator {
        match self.entries.iter().position(|entry| entry.h.to_bits() == h.to_bits()) {
            Some(0) => (),
            Some(index) => self.entries[..=index].rotate_right(1),
            None => {
                self.entries.truncate(Self::CAPACITY - 1);
                self.entries.insert(0, Arc::new(Propagator::new(extended, h)));
            }
        }
        &self.entries[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
                let phi = Matrix::from_fn(n, n, |i, j| increment[(i, j)] + f64::from(u8::from(i == j)));
                let mut defect = phi.transpose().multiply(&phi);
                defect.add_scaled(-1.0, &Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j))));
                assert!(defect.one_norm() < 1e-15 * n as f64, "order {order} h {h}: {:e}", defect.one_norm());
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
            let tolerance = 4e-15 * h * extended.matrix.one_norm() + 1e-13;
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

    #[test]
    fn the_cache_is_bounded_and_keeps_what_was_used_last() {
        let extended = extended(&conservative(4));
        let mut cache = Cache::default();
        let first = 1e-3;
        cache.get(&extended, first);
        for i in 1..20 {
            cache.get(&extended, first * f64::from(i + 1));
            cache.get(&extended, first);
        }
        assert_eq!(cache.entries.len(), Cache::CAPACITY);
        assert_eq!(cache.entries[0].h.to_bits(), first.to_bits());
    }
}
