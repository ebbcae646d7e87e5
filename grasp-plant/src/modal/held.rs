//! The step that most steps are: with held forces, where the coordinates are.
//!
//! The bits are those of [`Motion`](super::step::Motion) and of the signals read after it. That the step can be made, and that nothing
//! leaves the range of numbers, is known before it begins: see [`calm`](super::calm).

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::arrangement::Aligned;
use super::four::Four;
use super::readings::{self, Group, Read, Readings, add, halves, write};
use super::step::{NOT_NEGLIGIBLE, kept, moved, sum};
use super::table::{self, GROUP, LANES, Table};
use crate::dynamics::{FORCES, Signals};
use crate::state::{Positions, State};

/// A step with held forces: the functions of the step, the forces in lanes of which the last is no matter.
#[derive(Clone, Copy)]
pub(super) struct Held<'a, V> {
    pub table: &'a Table,
    pub readings: &'a Readings,
    pub forces: V,
}

/// What there is for even and for odd groups: of the step, and to be read.
struct Halves<'a> {
    even: (&'a [Aligned<table::Held<2>>], &'a [Aligned<Group<5>>]),
    odd: (&'a [Aligned<table::Held<1>>], &'a [Aligned<Group<4>>]),
}

/// What a step changes, besides the coordinates of groups.
struct Rest<'a> {
    zeta: &'a mut f64,
    motion: &'a mut Positions,
    signals: &'a mut Signals,
}

impl<V: Four> Held<'_, V> {
    /// Moves the state by the step, and reads the signals; gives the rates of the tips' shears, and the
    /// shears. None if these are no coordinates of this plant; nothing has changed then.
    #[inline(always)]
    pub fn make(self, state: &mut State, signals: &mut Signals) -> Option<V> {
        let Self { table, readings, .. } = self;
        let (held, rows) = (&table.held, &readings.groups);
        let (coordinates, motion) = state.coordinates_and_motion();
        // Of orders up to 8: of as many groups as the compiler knows.
        if let Some(Ok(coordinates)) =
            V::HOLDS_ALL_ROWS.then(|| <&mut [f64; 4 * GROUP + 1]>::try_from(&mut **coordinates))
            && let (Ok(even), Ok(odd)) = (<&[_; 2]>::try_from(&held.even[..]), <&[_; 2]>::try_from(&held.odd[..]))
            && let (Ok(even_rows), Ok(odd_rows)) =
                (<&[_; 2]>::try_from(&rows.even[..]), <&[_; 2]>::try_from(&rows.odd[..]))
        {
            let (groups, [zeta, ..]) = coordinates.as_chunks_mut::<GROUP>() else { return None };
            let halves = Halves { even: (even, even_rows), odd: (odd, odd_rows) };
            return Some(self.make_halves(&halves, groups, Rest { zeta, motion, signals }));
        }
        let (groups, [zeta]) = coordinates.as_chunks_mut::<GROUP>() else { return None };
        let mut rest = Rest { zeta, motion, signals };
        if groups.is_empty() || held.len() != groups.len() || rows.len() != groups.len() {
            return None;
        }
        if readings.arrangement.equal_arms {
            let halves = Halves { even: (&held.even, &rows.even), odd: (&held.odd, &rows.odd) };
            return Some(self.make_halves(&halves, groups, rest));
        }
        let mut common = V::splat(f64::from_bits(u64::MAX));
        let forces = self.lanes();
        let sums = advance(&held.any, groups, &forces, &mut common);
        self.travel(sums, &forces, groups, common, &mut rest);
        Some(rest.read(readings, readings.read_any::<V>(groups)))
    }

    /// The same of even and odd groups.
    #[inline(always)]
    fn make_halves(self, halves: &Halves<'_>, groups: &mut [[f64; GROUP]], mut rest: Rest<'_>) -> V {
        let [first, second, object] = self.lanes();
        let forces @ [both, object, opposite] = [first.plus(second), object, first.minus(second)];
        let mut common = V::splat(f64::from_bits(u64::MAX));
        let (even, odd) = groups.split_at_mut(halves.even.0.len().min(groups.len()));
        let [turn, rise] = advance(halves.even.0, even, &[both, object], &mut common);
        let [apart] = advance(halves.odd.0, odd, &[opposite], &mut common);
        self.travel([turn, rise, apart], &forces, groups, common, &mut rest);
        rest.read(self.readings, readings::read_halves::<V>(halves.even.1, halves.odd.1, groups))
    }

    /// Each force, in all lanes.
    #[inline(always)]
    fn lanes(&self) -> [V; FORCES] {
        [self.forces.spread::<0>(), self.forces.spread::<1>(), self.forces.spread::<2>()]
    }

    /// Moves what depends on the travels: positions, energy, ζ; and has coordinates vanish that are negligible, which is looked for if not
    /// all have the bits of others.
    #[inline(always)]
    fn travel(
        &self,
        [a, b, c]: [V; FORCES],
        forces: &[V; FORCES],
        groups: &mut [[f64; GROUP]],
        common: V,
        Rest { zeta, motion, .. }: &mut Rest<'_>,
    ) {
        // Before the signals: what follows from it one after the other is computed beside them.
        let sums = V::sums([a, b, c, V::splat(0.0)]);
        let travel = self.table.travel(sums, **zeta, forces, self.readings.arrangement.equal_arms);
        let work = self.forces.times(travel).lanes();
        State::travel_in_lanes(motion, travel.with_last_of(V::splat((work[0] + work[1]) + work[2])));
        **zeta = kept(**zeta + travel.lanes()[3]);
        // Some may be; large ones, and those that only fill up a group, are not told from them here.
        if !common.have_all(NOT_NEGLIGIBLE) {
            vanish::<V>(groups);
        }
    }
}

/// Has negligible coordinates vanish.
#[inline(always)]
fn vanish<V: Four>(groups: &mut [[f64; GROUP]]) {
    for four in groups.as_flattened_mut().as_chunks_mut::<LANES>().0 {
        *four = V::load(four).kept().lanes();
    }
}

impl Rest<'_> {
    /// Puts the signals where they stand; gives the rates of the tips' shears, and the shears.
    #[inline(always)]
    fn read<V: Four>(self, readings: &Readings, read: Read<V>) -> V {
        let Read { first, last, object } = readings.with_rigid(read, *self.zeta);
        write(self.signals, first, last, sum(object) + readings.object_velocity_of(*self.zeta) + 0.0);
        first.last_twos(last)
    }
}

/// Moves groups of one kind; gives the sums of the travel's lanes, and takes into `common` the bits that all coordinates have.
#[inline(always)]
fn advance<V: Four, const DRIVES: usize>(
    held: &[Aligned<table::Held<DRIVES>>],
    groups: &mut [[f64; GROUP]],
    forces: &[V; DRIVES],
    common: &mut V,
) -> [V; DRIVES] {
    let mut sums = [V::splat(0.0); DRIVES];
    for (group, held) in groups.iter_mut().zip(held) {
        let from = halves::<V>(group);
        add(&mut sums, &held.travel, &from);
        for (c, next) in group.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let after = from[c].plus(moved(&from, &held.increment[c], &held.gain[c], forces));
            *next = after.lanes();
            *common = common.common(after);
        }
    }
    sums
}
