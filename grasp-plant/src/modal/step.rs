//! The loops that every step comes down to.
//!
//! Four blocks side by side make a group, so that the compiler uses whole registers. As in the kernel of the dense plant nothing
//! is fused, and every sum has one order, whatever registers the processor has.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::readings::Readings;
use super::table::{GROUP, Gain, LANES, Lanes, Table};
use crate::dynamics::FORCES;

/// Coordinates smaller than this \[√J\] become zero after a step. A decaying motion would otherwise end in subnormal
/// numbers, on which processors are a hundred times slower; the energy given up is below the smallest normal number.
pub(crate) const NEGLIGIBLE: f64 = 1e-150;

/// The rigid motion: ζ̇ = gain·g, and the object rises as velocity·ζ + drift·g besides what the blocks make it rise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rigid {
    pub gain: [f64; FORCES],
    pub velocity: f64,
    pub drift: [f64; FORCES],
}

/// What a step changes besides the coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Travel {
    /// By how much w_1(l), w_2(l) and y_M have risen \[m\].
    pub total: [f64; FORCES],
    /// The integral of that over the step \[m s\]; only of ramps.
    pub integral: [f64; FORCES],
}

impl Travel {
    /// The same as the forces see it: of θ_1, θ_2 and y_M. By (12), l Δθ_i = Δw_i(l) + Δy_M.
    #[inline]
    pub fn of_forces(&self, length: f64) -> ([f64; FORCES], [f64; FORCES]) {
        let turned =
            |values: [f64; FORCES]| [(values[0] + values[2]) / length, (values[1] + values[2]) / length, values[2]];
        (turned(self.total), turned(self.integral))
    }
}

/// A step with forces g + r t: where to begin, and what happens.
#[derive(Clone, Copy)]
pub(super) struct Motion<'a> {
    pub table: &'a Table,
    pub readings: &'a Readings,
    pub rigid: &'a Rigid,
    pub from: &'a [f64],
    pub forces: &'a [f64; FORCES],
    pub rates: Option<&'a [f64; FORCES]>,
}

impl Motion<'_> {
    /// Makes the step, into `next`; gives what it changes besides.
    #[inline]
    pub fn make(self, next: &mut [f64]) -> Travel {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.make_wide(next) };
        }
        self.make_here(next)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn make_wide(self, next: &mut [f64]) -> Travel {
        self.make_here(next)
    }

    #[inline(always)]
    fn make_here(self, next: &mut [f64]) -> Travel {
        let Self { table, readings, rigid, from, forces, rates } = self;
        let (from, rest) = from.as_chunks::<GROUP>();
        let (next, rest_next) = next.as_chunks_mut::<GROUP>();
        let (mut total, mut integral) = ([[0.0; LANES]; FORCES], [[0.0; LANES]; FORCES]);
        for (i, ((from, next), (held, positions))) in
            from.iter().zip(next).zip(table.held.iter().zip(&readings.positions)).enumerate()
        {
            let mut change = moved(from, &held.increment, &held.gain, forces);
            if let Some(rates) = rates {
                let ramped = &table.ramped[i];
                let more = driven(&ramped.gain, rates);
                let area = moved(from, &ramped.integral, &ramped.gain, forces);
                let area_more = driven(&ramped.integral_gain, rates);
                for c in 0..2 {
                    for lane in 0..LANES {
                        change[c][lane] += more[c][lane];
                    }
                }
                for (integral, position) in integral.iter_mut().zip(positions) {
                    for lane in 0..LANES {
                        integral[lane] += position[0][lane] * (area[0][lane] + area_more[0][lane])
                            + position[1][lane] * (area[1][lane] + area_more[1][lane]);
                    }
                }
            }
            // What the coordinates really change by, rounding included, so that positions and coordinates stay together.
            let mut real = [[0.0; LANES]; 2];
            for c in 0..2 {
                for lane in 0..LANES {
                    let before = from[c * LANES + lane];
                    let after = before + change[c][lane];
                    let after = if after.abs() < NEGLIGIBLE { 0.0 } else { after };
                    next[c * LANES + lane] = after;
                    real[c][lane] = after - before;
                }
            }
            for (total, position) in total.iter_mut().zip(positions) {
                for lane in 0..LANES {
                    total[lane] += position[0][lane] * real[0][lane] + position[1][lane] * real[1][lane];
                }
            }
        }
        let sum = |lanes: [Lanes; FORCES]| lanes.map(|l| (l[0] + l[1]) + (l[2] + l[3]));
        let mut travel = Travel { total: sum(total), integral: sum(integral) };
        let (Some(before), Some(after)) = (rest.first(), rest_next.first_mut()) else { return travel };
        rigid.step(table.h, *before, forces, rates, after, &mut travel);
        travel
    }
}

/// Matrix times coordinates, and gain times forces, of a group.
#[inline(always)]
fn moved(from: &[f64; GROUP], matrix: &[[Lanes; 2]; 2], gain: &Gain, forces: &[f64; FORCES]) -> [Lanes; 2] {
    let mut change = driven(gain, forces);
    for c in 0..2 {
        for lane in 0..LANES {
            change[c][lane] += matrix[c][0][lane] * from[lane] + matrix[c][1][lane] * from[LANES + lane];
        }
    }
    change
}

/// Gain times forces, of a group.
#[inline(always)]
fn driven(gain: &Gain, forces: &[f64; FORCES]) -> [Lanes; 2] {
    let mut change = [[0.0; LANES]; 2];
    for c in 0..2 {
        for lane in 0..LANES {
            change[c][lane] =
                gain[c][0][lane] * forces[0] + gain[c][1][lane] * forces[1] + gain[c][2][lane] * forces[2];
        }
    }
    change
}

impl Rigid {
    /// The rigid part of a step.
    #[inline(always)]
    fn step(
        &self,
        h: f64,
        before: f64,
        forces: &[f64; FORCES],
        rates: Option<&[f64; FORCES]>,
        after: &mut f64,
        travel: &mut Travel,
    ) {
        let with = |gain: &[f64; FORCES], by: &[f64; FORCES]| gain[0] * by[0] + gain[1] * by[1] + gain[2] * by[2];
        let (push, drift) = (with(&self.gain, forces), with(&self.drift, forces));
        let mut change = h * push;
        let mut rise = h * (self.velocity * (before + 0.5 * change) + drift);
        if let Some(rates) = rates {
            let (push_rate, drift_rate) = (with(&self.gain, rates), with(&self.drift, rates));
            let (h_2, sixth) = (h * h, 1.0 / 6.0);
            rise += h_2 * (self.velocity * (h * sixth) * push_rate + 0.5 * drift_rate);
            travel.integral[2] += h_2
                * (self.velocity * (0.5 * before + h * (sixth * push + h * (1.0 / 24.0) * push_rate))
                    + (0.5 * drift + h * sixth * drift_rate));
            change += 0.5 * h_2 * push_rate;
        }
        *after = before + change;
        if after.abs() < NEGLIGIBLE {
            *after = 0.0;
        }
        travel.total[2] += rise;
    }
}
