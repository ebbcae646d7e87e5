//! The loops of every step.
//!
//! Four blocks side by side form a group, so that the compiler uses whole registers. As in the kernel of the dense plant no
//! operation is fused, and every sum has one order, whatever registers the processor has.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::Four;
use super::readings::Readings;
use super::table::{LANES, Lanes, Table};
#[cfg(target_arch = "x86_64")]
use super::wide::Wide;
use crate::dynamics::FORCES;

/// Coordinates smaller than this \[√J\] become zero after a step. A decaying motion would otherwise end in subnormal
/// numbers, on which processors are a hundred times slower; the lost energy is below the smallest normal number.
pub(crate) const NEGLIGIBLE: f64 = 1e-150;

/// The rigid motion: ζ̇ = gain·g, and the object moves with velocity·ζ + drift·g in addition to its motion by the blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rigid {
    pub gain: [f64; FORCES],
    pub velocity: f64,
    pub drift: [f64; FORCES],
    /// Gain and drift, in lanes, by force.
    pub columns: [Lanes; FORCES],
}

/// The changes by a step besides the coordinates.
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

/// A step with forces g + r t: the start, the functions of the step, the forces.
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
    /// Computes the step into `next`; returns its other changes.
    #[inline]
    pub fn make(self, next: &mut [f64]) -> Travel {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { if self.rates.is_some() { self.make_ramped(next) } else { self.make_held(next) } };
        }
        if self.rates.is_some() { self.make_here::<Lanes, true>(next) } else { self.make_here::<Lanes, false>(next) }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn make_held(self, next: &mut [f64]) -> Travel {
        self.make_here::<Wide, false>(next)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn make_ramped(self, next: &mut [f64]) -> Travel {
        self.make_here::<Wide, true>(next)
    }

    #[inline(always)]
    fn make_here<V: Four, const RAMPED: bool>(self, next: &mut [f64]) -> Travel {
        let Self { table, readings, rigid, from, forces, rates } = self;
        let (from, rest) = from.as_chunks::<LANES>();
        let (next, rest_next) = next.as_chunks_mut::<LANES>();
        let forces_4 = splat::<V>(forces);
        let no_rates = [0.0; FORCES];
        let rates = rates.unwrap_or(&no_rates);
        let rates_4 = splat::<V>(rates);
        let (mut total, mut integral) = ([V::splat(0.0); FORCES], [V::splat(0.0); FORCES]);
        let tables = table.held.iter().zip(&table.ramped).zip(&readings.groups);
        for ((from, next), ((held, ramped), readings)) in
            from.as_chunks::<2>().0.iter().zip(next.as_chunks_mut::<2>().0).zip(tables)
        {
            let coordinates = [V::load(&from[0]), V::load(&from[1])];
            for c in 0..2 {
                let mut change = moved(&coordinates, &held.increment[c], &held.gain[c], &forces_4);
                if RAMPED {
                    change = change.plus(driven(&ramped.gain[c], &rates_4));
                    let area = moved(&coordinates, &ramped.integral[c], &ramped.gain[c], &forces_4)
                        .plus(driven(&ramped.integral_gain[c], &rates_4));
                    for (integral, row) in integral.iter_mut().zip(&readings.positions) {
                        *integral = integral.plus(V::load(&row[c]).times(area));
                    }
                }
                next[c] = coordinates[c].plus(change).kept().lanes();
                // The change is computed directly and not as a difference of rounded coordinates, so that short steps move
                // positions smoothly.
                for (total, row) in total.iter_mut().zip(&readings.positions) {
                    *total = total.plus(V::load(&row[c]).times(change));
                }
            }
        }
        let mut travel = Travel::default();
        for f in 0..FORCES {
            travel.total[f] = sum(total[f]);
            travel.integral[f] = sum(integral[f]);
        }
        let (Some(before), Some(after)) = (rest.first(), rest_next.first_mut()) else { return travel };
        rigid.step(table.h, *before, forces, RAMPED.then_some(rates), after, &mut travel);
        travel
    }
}

#[inline(always)]
pub(super) fn splat<V: Four>(forces: &[f64; FORCES]) -> [V; FORCES] {
    [V::splat(forces[0]), V::splat(forces[1]), V::splat(forces[2])]
}

/// The sum of lanes.
#[inline(always)]
pub(super) fn sum<V: Four>(four: V) -> f64 {
    let lanes = four.lanes();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// One coordinate of each block: a row of its matrix times the coordinates, and of its gain times forces.
#[inline(always)]
pub(super) fn moved<V: Four>(
    coordinates: &[V; 2],
    row: &[Lanes; 2],
    gain: &[Lanes; FORCES],
    forces: &[V; FORCES],
) -> V {
    let own = V::load(&row[0]).times(coordinates[0]).plus(V::load(&row[1]).times(coordinates[1]));
    own.plus(driven(gain, forces))
}

/// A row of each block's gain times forces.
#[inline(always)]
fn driven<V: Four>(gain: &[Lanes; FORCES], forces: &[V; FORCES]) -> V {
    let first = V::load(&gain[0]).times(forces[0]).plus(V::load(&gain[1]).times(forces[1]));
    first.plus(V::load(&gain[2]).times(forces[2]))
}

impl Rigid {
    /// ζ after a step with held forces, and by how much the object has risen with it: the bits of [`Self::step`].
    #[inline(always)]
    pub fn held<V: Four>(&self, h: f64, before: f64, forces: &[V; FORCES]) -> (f64, f64) {
        let [push, drift, ..] = driven(&self.columns, forces).lanes();
        let change = h * push;
        let rise = h * (self.velocity * (before + 0.5 * change) + drift);
        let after = before + change;
        (if after.abs() < NEGLIGIBLE { 0.0 } else { after }, rise)
    }

    /// The rigid part of a step.
    #[inline(always)]
    pub fn step(
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
