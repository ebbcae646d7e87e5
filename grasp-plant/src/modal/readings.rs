//! Rows that read signals and positions from modal coordinates.
//!
//! A row is as long as the coordinates and lies beside them, four blocks in a register: the sums of all rows are independent of each other.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::Four;
use super::table::{Aligned, GROUP, LANES, Lanes};
#[cfg(target_arch = "x86_64")]
use super::wide::Wide;
use crate::dynamics::{FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, SIGNALS, Signals, VELOCITY};

/// A row's entries for a group.
type Row = [Lanes; 2];

/// The signals that every step reads, in the order of their rows: as they stand in [`Signals`], the object's velocity last.
const READ: [usize; 9] = [0, 1, 2, 3, 8, 9, 10, 11, VELOCITY[2]];

/// The rows that read signals and positions from the coordinates.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    /// By group: what every step reads.
    pub groups: Vec<Aligned<Group>>,
    /// Of the rates of the root moments.
    root_rates: Vec<Aligned<[Row; 2]>>,
    /// The first four signals, and the object's velocity, per ζ.
    rigid: (Lanes, f64),
}

/// The rows for a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// Of the signals that every step reads.
    signals: [Row; READ.len()],
    /// Of w_1(l), w_2(l) and y_M.
    pub positions: [Row; FORCES],
    /// −0.0 where there is a block, −1.0 where none is: see [`Four::lowered`].
    pub filler: Lanes,
}

/// Signals of a step: the first four of [`READ`], the next four, and the sums that make the object's velocity without that by ζ, by lane.
pub(super) struct Read<V> {
    pub first: V,
    pub last: V,
    pub object: V,
}

/// Puts signals where they stand; the rates of the root moments are left.
#[inline(always)]
pub(super) fn write<V: Four>(signals: &mut Signals, first: V, last: V, object_velocity: f64) {
    let fours = signals.as_chunks_mut::<LANES>().0;
    (fours[0], fours[2]) = (first.lanes(), last.lanes());
    signals[VELOCITY[2]] = object_velocity;
}

impl Readings {
    /// Of so many blocks; the rigid velocities of hubs and object per ζ.
    pub fn new(blocks: usize, rigid: &[f64; FORCES]) -> Self {
        let groups = blocks.div_ceil(LANES);
        let row = Row::default();
        let group = Group { signals: [row; READ.len()], positions: [row; FORCES], filler: [-1.0; LANES] };
        let mut groups = vec![Aligned(group); groups];
        for block in 0..blocks {
            groups[block / LANES].filler[block % LANES] = -0.0;
        }
        Self {
            root_rates: vec![Aligned([row; 2]); groups.len()],
            rigid: ([rigid[0], rigid[1], 0.0, 0.0], rigid[2]),
            groups,
        }
    }

    /// The entry of a signal's row for a coordinate of a block.
    ///
    /// # Panics
    /// If the signal is none.
    pub fn entry(&mut self, signal: usize, block: usize, coordinate: usize) -> &mut f64 {
        let (group, lane) = (block / LANES, block % LANES);
        let row = if let Some(arm) = ROOT_MOMENT_RATE.iter().position(|rate| *rate == signal) {
            &mut self.root_rates[group][arm]
        } else {
            let place = READ.iter().position(|read| *read == signal);
            &mut self.groups[group].signals[place.expect("a signal that is read")]
        };
        &mut row[coordinate][lane]
    }

    /// The signals that every step reads. `readings` are its [groups](Self::groups), which a step has at hand.
    #[inline(always)]
    pub fn read<V: Four>(&self, readings: &[Aligned<Group>], groups: &[[f64; GROUP]], zeta: f64) -> Read<V> {
        let mut sums = [V::splat(0.0); READ.len()];
        if V::HOLDS_ALL_ROWS {
            // The first group's products begin the sums. Some may be −0.0 then: to add zero in the end makes them 0.0, as they would be had
            // they begun with that.
            if let (Some(readings), Some(group)) = (readings.first(), groups.first()) {
                let (x, y) = halves::<V>(group);
                for (sum, row) in sums.iter_mut().zip(&readings.signals) {
                    *sum = V::load(&row[0]).times(x).plus(V::load(&row[1]).times(y));
                }
            }
            // Both are as long, which the compiler knows in a step; of their ends it would not.
            for i in 1..groups.len().min(readings.len()) {
                add(&mut sums, &readings[i].signals, &groups[i]);
            }
        } else {
            for (i, sums) in sums.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                for (readings, group) in readings.iter().zip(groups) {
                    add(sums, &readings.signals[3 * i..], group);
                }
            }
        }
        let [a, b, c, d, e, f, g, h, object] = sums;
        let zero = V::splat(0.0);
        Read {
            first: V::sums([a, b, c, d]).plus(V::load(&self.rigid.0).times(V::splat(zeta))).plus(zero),
            last: V::sums([e, f, g, h]).plus(zero),
            object,
        }
    }

    /// The object's velocity by ζ.
    #[inline(always)]
    pub fn object_velocity_of(&self, zeta: f64) -> f64 {
        self.rigid.1 * zeta
    }

    #[inline(always)]
    fn signals_here<V: Four>(&self, coordinates: &[f64]) -> Signals {
        let (groups, rest) = coordinates.as_chunks::<GROUP>();
        let mut signals = [0.0; SIGNALS];
        let zeta = rest.first().copied().unwrap_or_default();
        let Read { first, last, object } = self.read::<V>(&self.groups, groups, zeta);
        let object_velocity = super::step::sum(object) + self.object_velocity_of(zeta) + 0.0;
        write(&mut signals, first, last, object_velocity);
        signals
    }

    /// All signals of coordinates but the rates of the root moments, which are zero here.
    #[inline]
    pub fn signals(&self, coordinates: &[f64]) -> Signals {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.signals_wide(coordinates) };
        }
        self.signals_here::<Lanes>(coordinates)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn signals_wide(&self, coordinates: &[f64]) -> Signals {
        self.signals_here::<Wide>(coordinates)
    }

    /// d/dt EI w''(0) of both arms.
    #[inline(never)]
    pub fn root_moment_rates(&self, coordinates: &[f64]) -> [f64; ROOT_MOMENT.len()] {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.root_moment_rates_wide(coordinates) };
        }
        self.root_moment_rates_here::<Lanes>(coordinates)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn root_moment_rates_wide(&self, coordinates: &[f64]) -> [f64; ROOT_MOMENT.len()] {
        self.root_moment_rates_here::<Wide>(coordinates)
    }

    #[inline(always)]
    fn root_moment_rates_here<V: Four>(&self, coordinates: &[f64]) -> [f64; ROOT_MOMENT.len()] {
        let (groups, _) = coordinates.as_chunks::<GROUP>();
        let mut sums = [V::splat(0.0); 2];
        for (rows, group) in self.root_rates.iter().zip(groups) {
            add(&mut sums, &**rows, group);
        }
        [super::step::sum(sums[0]), super::step::sum(sums[1])]
    }

    /// w_1(l) and w_2(l).
    pub fn tip_deflection(&self, coordinates: &[f64]) -> [f64; 2] {
        let (groups, _) = coordinates.as_chunks::<GROUP>();
        let mut tips = [0.0; 2];
        for (readings, group) in self.groups.iter().zip(groups) {
            for (tip, position) in tips.iter_mut().zip(&readings.positions) {
                *tip += position.as_flattened().iter().zip(group).map(|(position, z)| position * z).sum::<f64>();
            }
        }
        tips
    }

    /// The largest sums of the sizes of a signal's row, and of a position's.
    pub fn largest_sums(&self) -> (f64, f64) {
        let (rigid, rigid_object) = &self.rigid;
        let of_zeta = rigid.iter().fold(rigid_object.abs(), |sum, entry| sum + entry.abs());
        let position = |i: usize| size(self.groups.iter().map(|group| &group.positions[i]));
        (
            (0..READ.len()).map(|i| size(self.groups.iter().map(|group| &group.signals[i]))).fold(0.0, f64::max)
                + of_zeta,
            (0..FORCES).map(position).fold(0.0, f64::max),
        )
    }

    /// Every number.
    #[cfg(test)]
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let rows = self.groups.iter().flat_map(|group| group.signals.as_flattened().as_flattened());
        let rates = self.root_rates.iter().flat_map(|rows| rows.as_flattened().as_flattened());
        let positions = self.groups.iter().flat_map(|group| group.positions.as_flattened().as_flattened());
        rows.chain(rates).chain(positions).chain(&self.rigid.0).chain([&self.rigid.1]).copied()
    }
}

/// Adds as many rows times coordinates of a group, by lane.
#[inline(always)]
fn add<V: Four, const ROWS: usize>(sums: &mut [V; ROWS], rows: &[Row], group: &[f64; GROUP]) {
    let (x, y) = halves::<V>(group);
    for (sum, row) in sums.iter_mut().zip(rows) {
        *sum = sum.plus(V::load(&row[0]).times(x).plus(V::load(&row[1]).times(y)));
    }
}

/// The first coordinates of a group's blocks, and the second.
#[inline(always)]
fn halves<V: Four>(group: &[f64; GROUP]) -> (V, V) {
    (V::load(&group.as_chunks().0[0]), V::load(&group.as_chunks().0[1]))
}

/// The sum of the sizes of a row.
fn size<'a>(row: impl Iterator<Item = &'a Row>) -> f64 {
    row.flat_map(|row| row.as_flattened()).map(|entry| entry.abs()).sum()
}
