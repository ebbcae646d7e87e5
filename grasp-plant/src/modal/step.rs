//! The loops of every step.
//!
//! Four blocks side by side form a group, so that the compiler uses whole registers. As in the kernel of the dense plant no
//! operation is fused, and every sum has one order, whatever registers the processor has.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::arrangement::{Aligned, sides};
use super::four::Four;
use super::readings::{Group, Readings, add, halves};
use super::table::{GROUP, Held, LANES, Lanes, Ramped, Table};
#[cfg(target_arch = "x86_64")]
use super::wide::Wide;
use crate::dynamics::FORCES;

/// Coordinates smaller than this \[√J\] become zero after a step: 2⁻⁵¹¹, some 10⁻¹⁵⁴. A decaying motion would otherwise end in subnormal
/// numbers, on which processors are a hundred times slower; the lost energy is below the smallest normal number.
pub(crate) const NEGLIGIBLE: f64 = f64::from_bits(NOT_NEGLIGIBLE);

/// The upper half of the exponents has a bit of its own, and this is the next one: a number that has it is not [`NEGLIGIBLE`], and what is neither
/// that nor at least 2 in size has it.
pub(super) const NOT_NEGLIGIBLE: u64 = 1 << 61;

/// The rigid motion: ζ̇ = gain·g, and the object moves with velocity·ζ + drift·g in addition to its motion by the blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rigid {
    pub gain: [f64; FORCES],
    pub velocity: f64,
    pub drift: [f64; FORCES],
}

/// The changes by a step besides the coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Travel {
    /// By how much θ_1, θ_2 \[rad\] and y_M \[m\] have grown, in whose directions the forces act.
    pub total: [f64; FORCES],
    /// The integral of that over the step \[rad s, m s\]; only of ramps.
    pub integral: [f64; FORCES],
}

impl Travel {
    /// From the same of w_1(l), w_2(l) and y_M: by (12), l Δθ_i = Δw_i(l) + Δy_M.
    fn of_tips(total: [f64; FORCES], integral: [f64; FORCES], length: f64) -> Self {
        let turned = |[first, second, rise]: [f64; FORCES]| [(first + rise) / length, (second + rise) / length, rise];
        Self { total: turned(total), integral: turned(integral) }
    }
}

/// A step with forces g + r t: the start, the functions of the step, the forces.
#[derive(Clone, Copy)]
pub(super) struct Motion<'a> {
    pub table: &'a Table,
    pub readings: &'a Readings,
    pub rigid: &'a Rigid,
    pub length: f64,
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
        self.make_narrow(next)
    }

    // Out of the way of processors with wide registers, and compiled with this crate, for size.
    #[inline(never)]
    fn make_narrow(self, next: &mut [f64]) -> Travel {
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
        let Self { table, readings, rigid, length, from, forces, rates } = self;
        let (from, rest) = from.as_chunks::<GROUP>();
        let (next, rest_next) = next.as_chunks_mut::<GROUP>();
        let (Some(before), Some(after)) = (rest.first(), rest_next.first_mut()) else { return Travel::default() };
        let no_rates = [0.0; FORCES];
        let rates = rates.unwrap_or(&no_rates);
        let mut ramps = Ramps { total: [V::splat(0.0); FORCES], integral: [V::splat(0.0); FORCES] };
        let Table { held, ramped, .. } = table;
        let rows = &readings.groups;
        let equal_arms = readings.arrangement.equal_arms;
        let mut drives = *forces;
        let [a, b, c] = if let (Some((from, from_odd)), Some((next, next_odd))) =
            (from.split_at_checked(held.even.len()), next.split_at_mut_checked(held.even.len()))
            && equal_arms
        {
            let ((even, odd), (even_rates, odd_rates)) = (sides(forces), sides(rates));
            drives = [even[0], even[1], odd[0]];
            let part = Part { held: &held.even, ramped: &ramped.even, rows: &rows.even, drives: (even, even_rates) };
            let [turn, rise] = part.make::<V, RAMPED>(from, next, &mut ramps);
            let part = Part { held: &held.odd, ramped: &ramped.odd, rows: &rows.odd, drives: (odd, odd_rates) };
            let [apart] = part.make::<V, RAMPED>(from_odd, next_odd, &mut ramps);
            [turn, rise, apart]
        } else {
            let part = Part { held: &held.any, ramped: &ramped.any, rows: &rows.any, drives: (*forces, *rates) };
            part.make::<V, RAMPED>(from, next, &mut ramps)
        };
        if RAMPED {
            let (mut total, mut integral) = (ramps.total.map(sum), ramps.integral.map(sum));
            *after = rigid.step(table.h, *before, forces, rates, &mut total[2], &mut integral[2]);
            Travel::of_tips(total, integral, length)
        } else {
            let sums = V::sums([a, b, c, V::splat(0.0)]);
            let [theta_1, theta_2, y, push] = table.travel(sums, *before, &splat(&drives), equal_arms).lanes();
            *after = kept(before + push);
            Travel { total: [theta_1, theta_2, y], ..Travel::default() }
        }
    }
}

/// What a step with ramps adds to the positions and their integrals, by lane.
struct Ramps<V> {
    total: [V; FORCES],
    integral: [V; FORCES],
}

/// The groups of one kind, and what drives them: held, and its slopes.
struct Part<'a, const READ: usize, const DRIVES: usize> {
    held: &'a [Aligned<Held<DRIVES>>],
    ramped: &'a [Aligned<Ramped<DRIVES>>],
    rows: &'a [Aligned<Group<READ>>],
    drives: ([f64; DRIVES], [f64; DRIVES]),
}

impl<const READ: usize, const DRIVES: usize> Part<'_, READ, DRIVES> {
    /// Computes the step of these groups into `next`; gives, of held forces, the sums of the travel's lanes.
    #[inline(always)]
    fn make<V: Four, const RAMPED: bool>(
        self,
        from: &[[f64; GROUP]],
        next: &mut [[f64; GROUP]],
        ramps: &mut Ramps<V>,
    ) -> [V; DRIVES] {
        let (forces, rates) = (splat::<V, DRIVES>(&self.drives.0), splat::<V, DRIVES>(&self.drives.1));
        let mut sums = [V::splat(0.0); DRIVES];
        let tables = self.held.iter().zip(self.ramped).zip(self.rows);
        for ((from, next), ((held, ramped), rows)) in from.iter().zip(next).zip(tables) {
            let coordinates = halves::<V>(from);
            if !RAMPED {
                add(&mut sums, &held.travel, &coordinates);
            }
            for (c, next) in next.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
                let mut change = moved(&coordinates, &held.increment[c], &held.gain[c], &forces);
                if RAMPED {
                    change = change.plus(driven(&ramped.gain[c], &rates));
                    let area = moved(&coordinates, &ramped.integral[c], &ramped.gain[c], &forces)
                        .plus(driven(&ramped.integral_gain[c], &rates));
                    for (integral, row) in ramps.integral.iter_mut().zip(&rows.positions) {
                        *integral = integral.plus(V::load(&row[c]).times(area));
                    }
                    // The change is computed directly and not as a difference of rounded coordinates, so that short steps
                    // move positions smoothly.
                    for (total, row) in ramps.total.iter_mut().zip(&rows.positions) {
                        *total = total.plus(V::load(&row[c]).times(change));
                    }
                }
                *next = coordinates[c].plus(change).kept().lanes();
            }
        }
        sums
    }
}

#[inline(always)]
pub(super) fn splat<V: Four, const DRIVES: usize>(forces: &[f64; DRIVES]) -> [V; DRIVES] {
    forces.map(V::splat)
}

/// Zero if it is [`NEGLIGIBLE`].
#[inline(always)]
pub(super) fn kept(number: f64) -> f64 {
    if number.abs() < NEGLIGIBLE { 0.0 } else { number }
}

/// The sum of lanes.
#[inline(always)]
pub(super) fn sum<V: Four>(four: V) -> f64 {
    let lanes = four.lanes();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// One coordinate of each block: a row of its matrix times the coordinates, and of its gain times forces.
#[inline(always)]
pub(super) fn moved<V: Four, const DRIVES: usize>(
    coordinates: &[V; 2],
    row: &[Lanes; 2],
    gain: &[Lanes; DRIVES],
    forces: &[V; DRIVES],
) -> V {
    let own = V::load(&row[0]).times(coordinates[0]).plus(V::load(&row[1]).times(coordinates[1]));
    own.plus(driven(gain, forces))
}

/// A row of each block's gain times forces.
#[inline(always)]
fn driven<V: Four, const DRIVES: usize>(gain: &[Lanes; DRIVES], forces: &[V; DRIVES]) -> V {
    let mut sum = V::load(&gain[0]).times(forces[0]);
    for i in 1..DRIVES {
        sum = sum.plus(V::load(&gain[i]).times(forces[i]));
    }
    sum
}

impl Rigid {
    /// The rigid part of a step with ramps: ζ after it. The object's rise and its integral are added.
    fn step(
        &self,
        h: f64,
        before: f64,
        forces: &[f64; FORCES],
        rates: &[f64; FORCES],
        total: &mut f64,
        integral: &mut f64,
    ) -> f64 {
        let with = |gain: &[f64; FORCES], by: &[f64; FORCES]| gain[0] * by[0] + gain[1] * by[1] + gain[2] * by[2];
        let (push, drift) = (with(&self.gain, forces), with(&self.drift, forces));
        let (push_rate, drift_rate) = (with(&self.gain, rates), with(&self.drift, rates));
        let (h_2, sixth) = (h * h, 1.0 / 6.0);
        let rise = h * (self.velocity * (before + 0.5 * (h * push)) + drift);
        *total += rise + h_2 * (self.velocity * (h * sixth) * push_rate + 0.5 * drift_rate);
        *integral += h_2
            * (self.velocity * (0.5 * before + h * (sixth * push + h * (1.0 / 24.0) * push_rate))
                + (0.5 * drift + h * sixth * drift_rate));
        kept(before + (h * push + 0.5 * h_2 * push_rate))
    }
}
