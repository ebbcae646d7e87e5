//! The step that most steps are: with held forces, where the coordinates are.
//!
//! The bits are those of [`Motion`](super::step::Motion) and of the signals read after it. The old coordinates stay until the new ones are
//! known to be usable; meanwhile these are on the stack and not in memory of the plant, which may be far away.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::Four;
#[cfg(target_arch = "x86_64")]
use super::four::Wide;
use super::readings::{Readings, Sums, lanes};
use super::step::{Rigid, Travel, moved, splat, sum};
use super::table::{Aligned, GROUP, LANES, Lanes, Table};
use crate::dynamics::{FORCES, Signals};
use crate::extended::MAX_COORDINATES;
use crate::plant::REACH;
use crate::state::State;
use std::mem::MaybeUninit;
use std::slice;

/// The most groups: one more than an order of whole groups has.
const MAX_GROUPS: usize = MAX_COORDINATES.div_ceil(GROUP);

/// Sums of sizes below this have parts all of which are [usable](crate::plant::all_usable).
pub(crate) const USABLE: f64 = f64::MAX / REACH;

/// A step with held forces: the functions of the step, the forces.
#[derive(Clone, Copy)]
pub(super) struct Held<'a> {
    pub table: &'a Table,
    pub readings: &'a Readings,
    pub rigid: &'a Rigid,
    pub forces: &'a [f64; FORCES],
}

impl Held<'_> {
    /// Replaces the coordinates by those after the step, if they and their signals are usable; whether it did. What else moves is asked for
    /// as soon as it is known, and given back with the signals if the step is made: `moves` refuses it by none.
    #[inline]
    pub fn make<T>(
        self,
        state: &mut State,
        moves: impl FnOnce(&State, &Travel) -> Option<T>,
        accept: impl FnOnce(&mut State, T, Signals),
    ) -> bool {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.make_wide(state, moves, accept) };
        }
        self.make_here::<Lanes, T>(state, moves, accept)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn make_wide<T>(
        self,
        state: &mut State,
        moves: impl FnOnce(&State, &Travel) -> Option<T>,
        accept: impl FnOnce(&mut State, T, Signals),
    ) -> bool {
        self.make_here::<Wide, T>(state, moves, accept)
    }

    #[inline(always)]
    fn make_here<V: Four, T>(
        self,
        state: &mut State,
        moves: impl FnOnce(&State, &Travel) -> Option<T>,
        accept: impl FnOnce(&mut State, T, Signals),
    ) -> bool {
        let Self { table, readings, rigid, forces } = self;
        let (groups, rest) = state.coordinates.as_chunks::<GROUP>();
        let [zeta] = rest else { return false };
        let (held, positions, columns) = (&table.held[..], &readings.positions[..], &readings.signals[..]);
        let count = groups.len();
        if held.len() != count || positions.len() != count || columns.len() != count || count > MAX_GROUPS {
            return false;
        }
        // Not initialised, because that would take as long as a group.
        let mut buffer = Aligned([const { MaybeUninit::<[f64; GROUP]>::uninit() }; MAX_GROUPS]);
        let (forces, mut total, mut size) = (splat::<V>(forces), [V::splat(0.0); FORCES], V::splat(0.0));
        let (after, rise) = rigid.held(table.h, *zeta, &forces);
        for (((group, next), held), positions) in groups.iter().zip(&mut buffer[..count]).zip(held).zip(positions) {
            let (from, next) = (group.as_chunks::<LANES>().0, next.write([0.0; GROUP]));
            let from = [V::load(&from[0]), V::load(&from[1])];
            for (c, lanes) in next.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
                let change = moved(&from, &held.increment[c], &held.gain[c], &forces);
                let after = from[c].plus(change);
                *lanes = after.kept().lanes();
                size = size.plus(after.size());
                for f in 0..FORCES {
                    total[f] = total[f].plus(V::load(&positions[f][c]).times(change));
                }
            }
        }
        // SAFETY: all that the loop went through are of this length, so it has written so many places.
        let next = unsafe { slice::from_raw_parts(buffer.as_ptr().cast::<[f64; GROUP]>(), count) };
        let total = [sum(total[0]), sum(total[1]), sum(total[2]) + rise];
        // Decided before the signals are begun: these keep the processor busy while positions and energy wait for each other.
        if !(size.is_below(USABLE) & (after.abs() < USABLE)) {
            return false;
        }
        let Some(moved) = moves(state, &Travel { total, ..Travel::default() }) else { return false };
        // A loop of its own: the sums of both do not fit into the registers.
        let mut sums = Sums::<V>::zero();
        for (columns, next) in columns.iter().zip(next) {
            sums.add(columns, next);
        }
        let signals = sums.with(&readings.rigid, after);
        let mut size = V::splat(0.0);
        for row in signals {
            size = size.plus(row.size());
        }
        if !size.is_below(USABLE) {
            return false;
        }
        accept(state, moved, lanes(signals));
        let (groups, rest) = state.coordinates.as_chunks_mut::<GROUP>();
        for (group, next) in groups.iter_mut().zip(next) {
            // In registers: a call that copies would take longer.
            for (group, next) in group.as_chunks_mut().0.iter_mut().zip(next.as_chunks().0) {
                *group = V::load(next).lanes();
            }
        }
        if let [zeta] = rest {
            *zeta = after;
        }
        true
    }
}
