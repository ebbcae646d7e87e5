//! The step that most steps are: with held forces, where the coordinates are.
//!
//! The bits are those of [`Motion`](super::step::Motion) and of the signals read after it. That the step can be made, and that nothing
//! leaves the range of numbers, is known before it begins: see [`calm`](super::calm).

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::Four;
use super::readings::{Read, Readings, write};
use super::step::{NEGLIGIBLE, Rigid, moved};
use super::table::{GROUP, LANES, Lanes, Table};
use crate::dynamics::{FORCES, Signals};
use crate::state::State;

/// A step with held forces: the functions of the step, the forces in lanes of which the last is no matter.
#[derive(Clone, Copy)]
pub(super) struct Held<'a, V> {
    pub table: &'a Table,
    pub readings: &'a Readings,
    pub rigid: &'a Rigid,
    pub forces: V,
    /// By what to divide travels of the forces: l, l, 1, 1.
    pub lengths: &'a Lanes,
}

impl<V: Four> Held<'_, V> {
    /// Moves the state by the step, and reads the signals; gives the rates of the tips' shears, and the
    /// shears. None if these are no coordinates of this plant; nothing has changed then.
    #[inline(always)]
    pub fn make(self, state: &mut State, signals: &mut Signals) -> Option<V> {
        let Self { table, readings, rigid, forces, lengths } = self;
        let (groups, rest) = state.coordinates.as_chunks_mut::<GROUP>();
        let [zeta] = rest else { return None };
        let (held, of_groups) = (&table.held[..], &readings.groups[..]);
        if groups.is_empty() || held.len() != groups.len() || of_groups.len() != groups.len() {
            return None;
        }
        let (lanes, mut total) =
            ([forces.spread::<0>(), forces.spread::<1>(), forces.spread::<2>()], [V::splat(0.0); FORCES]);
        let mut lowest = V::splat(f64::MIN);
        let (after, rise) = rigid.held(table.h, *zeta, &lanes);
        *zeta = after;
        for ((group, held), readings) in groups.iter_mut().zip(held).zip(of_groups) {
            let [first, second] = group.as_chunks_mut::<LANES>().0 else { return None };
            let from = [V::load(first), V::load(second)];
            for (c, next) in [first, second].into_iter().enumerate() {
                let change = moved(&from, &held.increment[c], &held.gain[c], &lanes);
                let after = from[c].plus(change);
                *next = after.lanes();
                lowest = lowest.lowered(after, &readings.filler);
                for (total, row) in total.iter_mut().zip(&readings.positions) {
                    *total = total.plus(V::load(&row[c]).times(change));
                }
            }
        }
        if lowest.is_any_above(-NEGLIGIBLE) {
            for four in groups.as_flattened_mut().as_chunks_mut::<LANES>().0 {
                *four = V::load(four).kept().lanes();
            }
        }
        // A loop of its own: the sums of both do not fit into the registers.
        let Read { first, last, object } = readings.read::<V>(of_groups, groups, after);
        // The object's velocity is one more sum of a register's lanes.
        let total = V::sums([total[0], total[1], total[2], object]);
        let total = total.plus(V::load(&[0.0, 0.0, rise, readings.object_velocity_of(after)])).plus(V::splat(0.0));
        write(signals, first, last, total.lanes()[3]);
        // As `Travel::of_forces`.
        let moved = total.plus(total.spread::<2>().first_two()).over(V::load(lengths));
        let work = forces.times(moved).lanes();
        state.travel_in_lanes(moved.with_last_of(V::splat((work[0] + work[1]) + work[2])));
        Some(first.last_twos(last))
    }
}
