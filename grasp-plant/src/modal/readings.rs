//! Rows that read signals and positions from modal coordinates.
//!
//! A row is as long as the coordinates and lies beside them, four blocks in a register: the sums of all rows are independent of each other.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::Four;
#[cfg(target_arch = "x86_64")]
use super::four::Wide;
use super::table::{Aligned, GROUP, LANES, Lanes};
use crate::dynamics::{FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, SIGNALS, Signals, VELOCITY};

/// A row's entries for a group.
type Row = [Lanes; 2];

/// The signals that every step reads, in the order of their rows: as they stand in [`Signals`], the object's velocity last.
const READ: [usize; 9] = [0, 1, 2, 3, 8, 9, 10, 11, VELOCITY[2]];

/// The rows that read signals and positions from the coordinates.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    /// Of the signals that every step reads, by group.
    rows: Vec<Aligned<[Row; READ.len()]>>,
    /// Of the rates of the root moments.
    root_rates: Vec<Aligned<[Row; 2]>>,
    /// The first four signals, and the object's velocity, per ζ.
    rigid: (Lanes, f64),
    pub positions: Vec<Aligned<Positions>>,
}

/// The rows of w_1(l), w_2(l) and y_M for a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Positions {
    pub rows: [Row; FORCES],
    /// −0.0 where there is a block, −1.0 where none is: see [`Four::lowered`].
    pub filler: Lanes,
}

/// Signals of a step.
pub(super) struct Read<V> {
    first: V,
    last: V,
    object_velocity: f64,
}

impl<V: Four> Read<V> {
    /// Puts them where they stand; the rates of the root moments are left.
    #[inline(always)]
    pub fn write(self, signals: &mut Signals) {
        let fours = signals.as_chunks_mut::<LANES>().0;
        (fours[0], fours[2]) = (self.first.lanes(), self.last.lanes());
        signals[VELOCITY[2]] = self.object_velocity;
    }
}

impl Readings {
    /// Of so many blocks; the rigid velocities of hubs and object per ζ.
    pub fn new(blocks: usize, rigid: &[f64; FORCES]) -> Self {
        let groups = blocks.div_ceil(LANES);
        let row = Row::default();
        let mut positions = vec![Aligned(Positions { rows: [row; FORCES], filler: [-1.0; LANES] }); groups];
        for block in 0..blocks {
            positions[block / LANES].filler[block % LANES] = -0.0;
        }
        Self {
            rows: vec![Aligned([row; READ.len()]); groups],
            root_rates: vec![Aligned([row; 2]); groups],
            rigid: ([rigid[0], rigid[1], 0.0, 0.0], rigid[2]),
            positions,
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
            &mut self.rows[group][place.expect("a signal that is read")]
        };
        &mut row[coordinate][lane]
    }

    /// Number of groups.
    pub fn groups(&self) -> usize {
        self.rows.len()
    }

    /// The signals that every step reads.
    #[inline(always)]
    pub fn read<V: Four>(&self, groups: &[[f64; GROUP]], zeta: f64) -> Read<V> {
        let mut sums = [V::splat(0.0); READ.len()];
        if V::HOLDS_ALL_ROWS {
            sums = products::<V, { READ.len() }, { READ.len() }>(&self.rows, 0, groups);
        } else {
            for (i, sums) in sums.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                *sums = products::<V, { READ.len() }, 3>(&self.rows, 3 * i, groups);
            }
        }
        let [a, b, c, d, e, f, g, h, object] = sums;
        let (rigid, rigid_object) = &self.rigid;
        Read {
            first: V::sums([a, b, c, d]).plus(V::load(rigid).times(V::splat(zeta))),
            last: V::sums([e, f, g, h]),
            object_velocity: super::step::sum(object) + rigid_object * zeta,
        }
    }

    #[inline(always)]
    fn signals_here<V: Four>(&self, coordinates: &[f64]) -> Signals {
        let (groups, rest) = coordinates.as_chunks::<GROUP>();
        let mut signals = [0.0; SIGNALS];
        let zeta = rest.first().copied().unwrap_or_default();
        self.read::<V>(groups, zeta).write(&mut signals);
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
        let [first, second] = products::<V, 2, 2>(&self.root_rates, 0, groups);
        [super::step::sum(first), super::step::sum(second)]
    }

    /// w_1(l) and w_2(l).
    pub fn tip_deflection(&self, coordinates: &[f64]) -> [f64; 2] {
        let (groups, _) = coordinates.as_chunks::<GROUP>();
        let mut tips = [0.0; 2];
        for (positions, group) in self.positions.iter().zip(groups) {
            for (tip, position) in tips.iter_mut().zip(&positions.rows) {
                *tip += position.as_flattened().iter().zip(group).map(|(position, z)| position * z).sum::<f64>();
            }
        }
        tips
    }

    /// The largest sums of the sizes of a signal's row, and of a position's.
    pub fn largest_sums(&self) -> (f64, f64) {
        let (rigid, rigid_object) = &self.rigid;
        let of_zeta = rigid.iter().fold(rigid_object.abs(), |sum, entry| sum + entry.abs());
        let position = |i: usize| size(self.positions.iter().map(|group| &group.rows[i]));
        (
            (0..READ.len()).map(|i| size(self.rows.iter().map(|rows| &rows[i]))).fold(0.0, f64::max) + of_zeta,
            (0..FORCES).map(position).fold(0.0, f64::max),
        )
    }

    /// Every number.
    #[cfg(test)]
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let rows = self.rows.iter().flat_map(|rows| rows.as_flattened().as_flattened());
        let rates = self.root_rates.iter().flat_map(|rows| rows.as_flattened().as_flattened());
        let positions = self.positions.iter().flat_map(|group| group.rows.as_flattened().as_flattened());
        rows.chain(rates).chain(positions).chain(&self.rigid.0).chain([&self.rigid.1]).copied()
    }
}

/// Some rows, from the `first` on, times coordinates, by lane.
#[inline(always)]
fn products<V: Four, const ALL: usize, const SOME: usize>(
    rows: &[Aligned<[Row; ALL]>],
    first: usize,
    groups: &[[f64; GROUP]],
) -> [V; SOME] {
    let mut sums = [V::splat(0.0); SOME];
    for (rows, group) in rows.iter().zip(groups) {
        let (x, y) = (V::load(&group.as_chunks().0[0]), V::load(&group.as_chunks().0[1]));
        for (sum, row) in sums.iter_mut().zip(&rows[first..]) {
            *sum = sum.plus(V::load(&row[0]).times(x).plus(V::load(&row[1]).times(y)));
        }
    }
    sums
}

/// The sum of the sizes of a row.
fn size<'a>(row: impl Iterator<Item = &'a Row>) -> f64 {
    row.flat_map(|row| row.as_flattened()).map(|entry| entry.abs()).sum()
}
