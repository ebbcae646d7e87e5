//! The step that most steps are: with held forces, where the coordinates are.
//!
//! The bits are those of [`Motion`](super::step::Motion) and of the signals read after it. That the step can be made, and that nothing
//! leaves the range of numbers, is known before it begins: see [`calm`](super::calm).

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::Four;
#[cfg(target_arch = "x86_64")]
use super::four::Wide;
use super::readings::Readings;
use super::step::{NEGLIGIBLE, Rigid, Travel, moved, splat, sum};
use super::table::{GROUP, LANES, Lanes, Table};
use crate::dynamics::{FORCES, Signals};
use crate::state::{State, travelled};

/// A step with held forces: the functions of the step, the forces.
#[derive(Clone, Copy)]
pub(super) struct Held<'a> {
    pub table: &'a Table,
    pub readings: &'a Readings,
    pub rigid: &'a Rigid,
    pub forces: &'a [f64; FORCES],
    pub length: f64,
}

impl Held<'_> {
    /// Moves the state by the step, and reads the signals. False if these are no coordinates of this plant; nothing has changed then.
    #[inline]
    pub fn make(self, state: &mut State, signals: &mut Signals) -> bool {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.make_wide(state, signals) };
        }
        self.make_here::<Lanes>(state, signals)
    }

    // Inlined, or it would be compiled with this crate, for size.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    #[target_feature(enable = "avx")]
    fn make_wide(self, state: &mut State, signals: &mut Signals) -> bool {
        self.make_here::<Wide>(state, signals)
    }

    #[inline(always)]
    fn make_here<V: Four>(self, state: &mut State, signals: &mut Signals) -> bool {
        let Self { table, readings, rigid, forces, length } = self;
        let (groups, rest) = state.coordinates.as_chunks_mut::<GROUP>();
        let [zeta] = rest else { return false };
        let (held, positions) = (&table.held[..], &readings.positions[..]);
        let count = groups.len();
        if held.len() != count || positions.len() != count || readings.groups() != count {
            return false;
        }
        let (lanes, mut total) = (splat::<V>(forces), [V::splat(0.0); FORCES]);
        let mut lowest = V::splat(f64::MIN);
        let (after, rise) = rigid.held(table.h, *zeta, &lanes);
        *zeta = after;
        for ((group, held), positions) in groups.iter_mut().zip(held).zip(positions) {
            let [first, second] = group.as_chunks_mut::<LANES>().0 else { return false };
            let from = [V::load(first), V::load(second)];
            for (c, next) in [first, second].into_iter().enumerate() {
                let change = moved(&from, &held.increment[c], &held.gain[c], &lanes);
                let after = from[c].plus(change);
                *next = after.lanes();
                lowest = lowest.lowered(after, &positions.filler);
                for (total, row) in total.iter_mut().zip(&positions.rows) {
                    *total = total.plus(V::load(&row[c]).times(change));
                }
            }
        }
        if lowest.is_any_above(-NEGLIGIBLE) {
            for four in groups.as_flattened_mut().as_chunks_mut::<LANES>().0 {
                *four = V::load(four).kept().lanes();
            }
        }
        let travel = Travel { total: [sum(total[0]), sum(total[1]), sum(total[2]) + rise], ..Travel::default() };
        let (moved, _) = travel.of_forces(length);
        state.supplied_energy += forces[0] * moved[0] + forces[1] * moved[1] + forces[2] * moved[2];
        (state.position, state.carry) = travelled(&state.position, &state.carry, &moved);
        // A loop of its own: the sums of both do not fit into the registers.
        readings.read::<V>(groups, after).write(signals);
        true
    }
}
