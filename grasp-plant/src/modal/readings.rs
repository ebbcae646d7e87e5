//! Rows that read signals and positions from modal coordinates.
//!
//! A row is as long as the coordinates and lies beside them, four blocks in a register: the sums of all rows are independent of each other.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::arrangement::{Aligned, Arrangement, Parity, Parts, Row};
use super::four::Four;
use super::table::{GROUP, LANES, Lanes};
#[cfg(target_arch = "x86_64")]
use super::wide::Wide;
use crate::dynamics::{FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, SIGNALS, Signals, VELOCITY};

/// The signals that every step reads, in the order of their rows: as they stand in [`Signals`], the object's velocity last.
const READ: [usize; 9] = [0, 1, 2, 3, 8, 9, 10, 11, VELOCITY[2]];

/// Those that an even and an odd block are read by: the first arm's of each pair, of the first four signals and of the next four in turn. Even
/// ones move the object.
const READ_EVEN: [usize; 5] = [0, 8, 2, 10, VELOCITY[2]];
const READ_ODD: [usize; 4] = [0, 8, 2, 10];

/// The rows that read signals and positions from the coordinates.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    /// What every step reads.
    pub groups: Parts<Group<9>, Group<5>, Group<4>>,
    /// Of the rates of the root moments.
    root_rates: Vec<Aligned<[Row; 2]>>,
    /// The first four signals, and the object's velocity, per ζ.
    rigid: (Lanes, f64),
    pub arrangement: Arrangement,
}

/// The rows for a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group<const SIGNALS_READ: usize> {
    /// Of the signals that every step reads.
    signals: [Row; SIGNALS_READ],
    /// Of w_1(l), w_2(l) and y_M.
    pub positions: [Row; FORCES],
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

impl<const SIGNALS_READ: usize> Group<SIGNALS_READ> {
    const NONE: Self = Self { signals: [[[0.0; LANES]; 2]; SIGNALS_READ], positions: [[[0.0; LANES]; 2]; FORCES] };

    fn put(
        &mut self,
        lane: usize,
        read: [usize; SIGNALS_READ],
        of_block: &[Signals; 2],
        positions: &[[f64; 2]; FORCES],
    ) {
        for c in 0..2 {
            for (row, signal) in self.signals.iter_mut().zip(read) {
                row[c][lane] = of_block[c][signal];
            }
            for (row, position) in self.positions.iter_mut().zip(positions) {
                row[c][lane] = position[c];
            }
        }
    }

    /// The sums of lanes of each signal's row times coordinates.
    #[inline(always)]
    fn read<V: Four>(groups: &[Aligned<Self>], coordinates: &[[f64; GROUP]]) -> [V; SIGNALS_READ] {
        let mut sums = [V::splat(0.0); SIGNALS_READ];
        if V::HOLDS_ALL_ROWS {
            // The first group's products begin the sums. Some may be −0.0 then: to add zero in the end makes them 0.0, as they would be had
            // they begun with that.
            if let (Some(readings), Some(group)) = (groups.first(), coordinates.first()) {
                let [x, y] = halves::<V>(group);
                for (sum, row) in sums.iter_mut().zip(&readings.signals) {
                    *sum = V::load(&row[0]).times(x).plus(V::load(&row[1]).times(y));
                }
            }
            // Both are as long, which the compiler knows in a step; of their ends it would not.
            for i in 1..groups.len().min(coordinates.len()) {
                add(&mut sums, &groups[i].signals, &halves::<V>(&coordinates[i]));
            }
        } else {
            for (i, sums) in sums.chunks_mut(3).enumerate() {
                for (readings, group) in groups.iter().zip(coordinates) {
                    add(sums, &readings.signals[3 * i..], &halves::<V>(group));
                }
            }
        }
        sums
    }

    /// The sums of the sizes of each signal's row, and of each position's.
    fn sizes(groups: &[Aligned<Self>]) -> ([f64; SIGNALS_READ], [f64; FORCES]) {
        (
            std::array::from_fn(|i| size(groups.iter().map(|group| &group.signals[i]))),
            std::array::from_fn(|i| size(groups.iter().map(|group| &group.positions[i]))),
        )
    }
}

impl Readings {
    /// Of blocks that lie so; the rigid velocities of hubs and object per ζ.
    pub fn new(arrangement: Arrangement, rigid: &[f64; FORCES]) -> Self {
        Self {
            root_rates: vec![Aligned([Row::default(); 2]); arrangement.groups()],
            rigid: ([rigid[0], rigid[1], 0.0, 0.0], rigid[2]),
            groups: Parts::new(arrangement, Group::NONE, Group::NONE, Group::NONE),
            arrangement,
        }
    }

    /// Sets what a block is read by: all signals, w_1(l), w_2(l) and y_M, per coordinate. Of an even or odd block what the second arm shows is
    /// taken from the first.
    pub fn put(&mut self, block: usize, signals: &[Signals; 2], positions: &[[f64; 2]; FORCES]) {
        let (group, lane) = self.arrangement.place(block);
        let Parts { any, even, odd } = &mut self.groups;
        match self.arrangement.parity(block) {
            None => any[group].put(lane, READ, signals, positions),
            Some(Parity::Even) => even[group].put(lane, READ_EVEN, signals, positions),
            Some(Parity::Odd) => odd[group].put(lane, READ_ODD, signals, positions),
        }
        let (group, lane) = self.arrangement.place_among_all(block);
        for (row, rate) in self.root_rates[group].iter_mut().zip(ROOT_MOMENT_RATE) {
            for c in 0..2 {
                row[c][lane] = signals[c][rate];
            }
        }
    }

    /// The rows of w_1(l) and w_2(l), and of ẏ_M, for a block.
    pub fn of_block(&self, block: usize) -> ([[f64; 2]; 2], [f64; 2]) {
        let (group, lane) = self.arrangement.place(block);
        let of_lane = |row: Row| row.map(|entries| entries[lane]);
        let Parts { any, even, odd } = &self.groups;
        let (positions, object) = match self.arrangement.parity(block) {
            None => (any[group].positions, of_lane(any[group].signals[READ.len() - 1])),
            Some(Parity::Even) => (even[group].positions, of_lane(even[group].signals[READ_EVEN.len() - 1])),
            Some(Parity::Odd) => (odd[group].positions, [0.0; 2]),
        };
        let [first, second, _] = positions.map(of_lane);
        ([first, second], object)
    }

    /// The rows of the positions, by group.
    pub fn positions(&self) -> impl Iterator<Item = &[Row; FORCES]> {
        let Parts { any, even, odd } = &self.groups;
        let halves = even.iter().map(|group| &group.positions).chain(odd.iter().map(|group| &group.positions));
        any.iter().map(|group| &group.positions).chain(halves)
    }

    /// The row of y_M for a coordinate of a block.
    pub fn object_position(&self, block: usize, coordinate: usize) -> f64 {
        let (group, lane) = self.arrangement.place_among_all(block);
        self.positions().nth(group).map_or(0.0, |positions| positions[2][coordinate][lane])
    }

    /// The signals that every step reads, as far as the coordinates determine them, of blocks of any kind.
    #[inline(always)]
    pub fn read_any<V: Four>(&self, coordinates: &[[f64; GROUP]]) -> Read<V> {
        let [a, b, c, d, e, f, g, h, object] = Group::read(&self.groups.any, coordinates);
        Read { first: V::sums([a, b, c, d]), last: V::sums([e, f, g, h]), object }
    }

    /// The signals, of what the coordinates determine of them, with what ζ adds to the first four.
    #[inline(always)]
    pub fn with_rigid<V: Four>(&self, read: Read<V>, zeta: f64) -> Read<V> {
        let (Read { first, last, object }, zero) = (read, V::splat(0.0));
        let first = first.plus(V::load(&self.rigid.0).times(V::splat(zeta))).plus(zero);
        Read { first, last: last.plus(zero), object }
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
        let Parts { even, odd, .. } = &self.groups;
        let read =
            if self.arrangement.equal_arms { read_halves(even, odd, groups) } else { self.read_any::<V>(groups) };
        let Read { first, last, object } = self.with_rigid(read, zeta);
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
            add(&mut sums, &**rows, &halves::<V>(group));
        }
        [super::step::sum(sums[0]), super::step::sum(sums[1])]
    }

    /// w_1(l) and w_2(l).
    pub fn tip_deflection(&self, coordinates: &[f64]) -> [f64; 2] {
        let (groups, _) = coordinates.as_chunks::<GROUP>();
        let mut tips = [0.0; 2];
        for (positions, group) in self.positions().zip(groups) {
            for (tip, position) in tips.iter_mut().zip(positions) {
                *tip += position.as_flattened().iter().zip(group).map(|(position, z)| position * z).sum::<f64>();
            }
        }
        tips
    }

    /// The largest sums of the sizes of a signal's row, and of a position's.
    pub fn largest_sums(&self) -> (f64, f64) {
        let (rigid, rigid_object) = &self.rigid;
        let of_zeta = rigid.iter().fold(rigid_object.abs(), |sum, entry| sum + entry.abs());
        let largest = |sums: &[f64]| sums.iter().copied().fold(0.0, f64::max);
        let Parts { any, even, odd } = &self.groups;
        let ((any, of_any), (even, of_even), (odd, of_odd)) =
            (Group::sizes(any), Group::sizes(even), Group::sizes(odd));
        // A pair of signals is what even and odd blocks show together.
        let halves: f64 = largest(&even) + largest(&odd);
        let positions: [f64; FORCES] = std::array::from_fn(|i| of_any[i] + of_even[i] + of_odd[i]);
        (largest(&any).max(halves) + of_zeta, largest(&positions))
    }

    /// Every number.
    #[cfg(test)]
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let Parts { any, even, odd } = &self.groups;
        let halves = even.iter().flat_map(|group| &group.signals).chain(odd.iter().flat_map(|group| &group.signals));
        let signals = any.iter().flat_map(|group| &group.signals).chain(halves);
        let rates = self.root_rates.iter().flat_map(|rows| rows.iter());
        let rows = signals.chain(rates).chain(self.positions().flatten()).flatten().flatten();
        rows.chain(&self.rigid.0).chain([&self.rigid.1]).copied()
    }
}

/// The signals that every step reads, as far as the coordinates determine them, of even and odd blocks.
#[inline(always)]
pub(super) fn read_halves<V: Four>(
    even: &[Aligned<Group<5>>],
    odd: &[Aligned<Group<4>>],
    coordinates: &[[f64; GROUP]],
) -> Read<V> {
    let (of_even, of_odd) = coordinates.split_at(even.len().min(coordinates.len()));
    let [a, b, c, d, object] = Group::read(even, of_even);
    let (both, opposite) = (V::sums([a, b, c, d]), V::sums(Group::read(odd, of_odd)));
    // Of the arms in turn: hubs' velocities and rates of shears; moments and shears.
    let (first, last) = both.plus(opposite).in_turns(both.minus(opposite));
    Read { first, last, object }
}

/// Adds as many rows times coordinates of a group, by lane.
#[inline(always)]
pub(super) fn add<V: Four>(sums: &mut [V], rows: &[Row], [x, y]: &[V; 2]) {
    for (sum, row) in sums.iter_mut().zip(rows) {
        *sum = sum.plus(V::load(&row[0]).times(*x).plus(V::load(&row[1]).times(*y)));
    }
}

/// The first coordinates of a group's blocks, and the second.
#[inline(always)]
pub(super) fn halves<V: Four>(group: &[f64; GROUP]) -> [V; 2] {
    [V::load(&group.as_chunks().0[0]), V::load(&group.as_chunks().0[1])]
}

/// The sum of the sizes of a row.
fn size<'a>(row: impl Iterator<Item = &'a Row>) -> f64 {
    row.flat_map(|row| row.as_flattened()).map(|entry| entry.abs()).sum()
}
