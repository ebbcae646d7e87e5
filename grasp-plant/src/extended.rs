//! The plant extended by the integrals of its velocities and by its inputs, and its motion over any duration.
//!
//! The plant is extended by the integrals of its three velocities (the position increments Θ), by their integrals
//! (Ψ = ∫Θ, for the work of a ramp), and by the forces g and their rates r:
//!
//! ```text
//! ẋ = A x + B g,   Θ̇ = Bᵀ x,   Ψ̇ = Θ,   ġ = r,   ṙ = 0.
//! ```
//!
//! Everything is computed as the *increment* D = exp(𝒜h) − I: a Taylor polynomial at h/2^s, then s doublings. If A is
//! skew-symmetric, Newton–Schulz steps remove the rounding error of I − ΦᵀΦ, which the doublings would otherwise amplify.

use crate::dynamics::{Dynamics, FORCES};
use crate::exponential::{TAYLOR_NORM, doubled, exp_m1, one_norm, orthogonalise};
use crate::kernel::{LANES, Panels};
use nalgebra::DMatrix;
use std::sync::OnceLock;

/// No step may be longer \[s\].
pub const LONGEST_STEP: f64 = 100.0;

/// No step may take more doublings: each costs a bit of the fastest motions' phase.
const MOST_DOUBLINGS: u32 = 40;

/// The most energy coordinates.
pub(crate) const MAX_COORDINATES: usize = 4 * *crate::parameters::ORDER_RANGE.end() + 1;

/// Panels of the largest extended vector.
pub(crate) const MAX_PANELS: usize = (MAX_COORDINATES + 4 * FORCES).div_ceil(LANES);

/// Where things are in the extended vector (x, Θ, Ψ, g, r) for n = |x|.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Number of energy coordinates.
    pub n: usize,
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

/// The extended system 𝒜 and everything that depends only on it.
#[derive(Clone, Debug)]
pub(crate) struct Extended {
    pub layout: Layout,
    pub matrix: DMatrix<f64>,
    panels: Panels,
    /// Longest admissible step \[s\].
    pub longest_step: f64,
    /// The largest power of two \[s\] whose product with ‖𝒜‖ is at most [`TAYLOR_NORM`].
    base: f64,
    /// Increments of the durations base·2^level, made when first needed: see [`Self::advance`].
    ladder: Vec<OnceLock<Panels>>,
    conservative: bool,
    /// Indices of both arms' tip coordinates, their compliance, and the arm length: the coefficients of (12).
    pub tip_coordinate: [usize; 2],
    pub tip_compliance: [f64; 2],
    pub length: f64,
}

impl Extended {
    pub fn new(dynamics: &Dynamics, length: f64) -> Self {
        let n = dynamics.size();
        let layout = Layout { n };
        let mut matrix = DMatrix::zeros(layout.size(), layout.size());
        matrix.view_mut((0, 0), (n, n)).copy_from(&dynamics.system);
        let inputs = dynamics.inputs();
        matrix.view_mut((0, layout.force()), (n, FORCES)).copy_from(&inputs);
        matrix.view_mut((layout.travel(), 0), (FORCES, n)).tr_copy_from(&inputs);
        matrix.view_mut((layout.travel_integral(), layout.travel()), (FORCES, FORCES)).fill_with_identity();
        matrix.view_mut((layout.force(), layout.force_rate()), (FORCES, FORCES)).fill_with_identity();
        let norm = one_norm(&matrix);
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
    pub fn increment(&self, h: f64) -> DMatrix<f64> {
        let (mut part, mut doublings) = (h, 0);
        while part > self.base {
            part *= 0.5;
            doublings += 1;
        }
        let mut increment = exp_m1(&(&self.matrix * part));
        for doubling in 1..=doublings {
            increment = doubled(&increment);
            // Newton–Schulz converges quadratically, doublings amplify by two: every eighth and the last suffice.
            if self.conservative && (doubling % 8 == 0 || doubling == doublings) {
                orthogonalise(&mut increment, self.layout.n);
            }
        }
        increment
    }

    /// Advances the extended vector z by any duration from 0 to [`Self::longest_step`] without computing a matrix for this
    /// duration. The binary digits of the duration select matrices for a sequence of doubled durations, and the Taylor
    /// series does the rest.
    ///
    /// The first use of one of these matrices computes it and so allocates.
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

fn add(z: &mut [f64], increment: &[[f64; LANES]]) {
    for (z, increment) in z.iter_mut().zip(increment.as_flattened()) {
        *z += increment;
    }
}
