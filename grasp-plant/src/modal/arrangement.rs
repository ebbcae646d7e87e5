//! Which blocks lie side by side, and what there is for each four of them.
//!
//! The second of two equal arms does what the first one does in some motions, and the opposite in all others: even and odd ones. The object
//! and the rigid motion move with the even ones alone. So the blocks of such a plant are each driven by fewer sums of forces, and seen by
//! fewer sums of signals: even ones by τ_1 + τ_2 and the force on the object, odd ones by τ_1 − τ_2.

use super::table::{LANES, Lanes};
use std::ops::{Deref, DerefMut};

/// Whether the second arm does what the first one does, or the opposite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parity {
    Even,
    Odd,
}

impl Parity {
    /// What an entry of the first arm is for the second one.
    pub fn sign(self) -> f64 {
        match self {
            Self::Even => 1.0,
            Self::Odd => -1.0,
        }
    }
}

/// How many blocks there are, and whether they are even and odd ones: as many even ones first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrangement {
    pub blocks: usize,
    pub equal_arms: bool,
}

impl Arrangement {
    /// Groups of blocks of one kind.
    fn groups_of_kind(self) -> usize {
        if self.equal_arms { (self.blocks / 2).div_ceil(LANES) } else { self.blocks.div_ceil(LANES) }
    }

    /// Groups of blocks.
    pub fn groups(self) -> usize {
        if self.equal_arms { 2 * self.groups_of_kind() } else { self.groups_of_kind() }
    }

    pub fn parity(self, block: usize) -> Option<Parity> {
        self.equal_arms.then_some(if block < self.blocks / 2 { Parity::Even } else { Parity::Odd })
    }

    /// The group among those of its kind, and the lane.
    pub fn place(self, block: usize) -> (usize, usize) {
        let block = if self.equal_arms { block % (self.blocks / 2) } else { block };
        (block / LANES, block % LANES)
    }

    /// The group among all, and the lane.
    pub fn place_among_all(self, block: usize) -> (usize, usize) {
        let (group, lane) = self.place(block);
        (if self.parity(block) == Some(Parity::Odd) { self.groups_of_kind() + group } else { group }, lane)
    }
}

/// What there is for each group: of any blocks, or of even ones and then of odd ones.
#[derive(Clone, Debug)]
pub(super) struct Parts<A, E, O> {
    pub any: Vec<Aligned<A>>,
    pub even: Vec<Aligned<E>>,
    pub odd: Vec<Aligned<O>>,
}

impl<A: Clone, E: Clone, O: Clone> Parts<A, E, O> {
    /// The same for all groups of a kind.
    pub fn new(arrangement: Arrangement, any: A, even: E, odd: O) -> Self {
        let groups = arrangement.groups_of_kind();
        let (all, halves) = if arrangement.equal_arms { (0, groups) } else { (groups, 0) };
        Self { any: vec![Aligned(any); all], even: vec![Aligned(even); halves], odd: vec![Aligned(odd); halves] }
    }
}

impl<A, E, O> Parts<A, E, O> {
    /// Groups of all kinds.
    #[inline]
    pub fn len(&self) -> usize {
        self.any.len() + self.even.len() + self.odd.len()
    }
}

/// The sum and the difference of two torques, and the force: what drives even blocks, and odd ones.
#[inline]
pub(super) fn sides(forces: &[f64; 3]) -> ([f64; 2], [f64; 1]) {
    let [first, second, object] = *forces;
    ([first + second, object], [first - second])
}

/// At the beginning of a line of the processor's cache. Elsewhere every other register would be read from two lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Aligned<T>(pub T);

impl<T> Deref for Aligned<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> DerefMut for Aligned<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}

/// A row's entries for a group.
pub(super) type Row = [Lanes; 2];
