//! Rows that read signals from modal coordinates.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::Four;
#[cfg(target_arch = "x86_64")]
use super::four::Wide;
use super::table::{Aligned, GROUP, LANES, Lanes};
use crate::dynamics::{FORCES, SIGNALS, Signals};

/// The rows that read signals from the coordinates.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    /// Signals per coordinate of each group, and per ζ.
    pub signals: Vec<Aligned<[Signals; GROUP]>>,
    pub rigid: Signals,
    /// w_1(l), w_2(l) and y_M per coordinate.
    pub positions: Vec<Aligned<[[Lanes; 2]; FORCES]>>,
}

/// Registers of all signals.
const ROWS: usize = SIGNALS / LANES;

/// Sums of signals over groups: two for each, or each addition would wait for the one before.
pub(super) struct Sums<V>([V; ROWS], [V; ROWS]);

impl<V: Four> Sums<V> {
    #[inline(always)]
    pub fn zero() -> Self {
        Self([V::splat(0.0); ROWS], [V::splat(0.0); ROWS])
    }

    /// Adds the signals of a group's coordinates.
    #[inline(always)]
    pub fn add(&mut self, columns: &[Signals; GROUP], group: &[f64; GROUP]) {
        let Self(first, second) = self;
        for lane in 0..LANES {
            let (x, y) = (V::splat(group[lane]), V::splat(group[LANES + lane]));
            let (left, right) = (columns[lane].as_chunks().0, columns[LANES + lane].as_chunks().0);
            for row in 0..ROWS {
                first[row] = first[row].plus(V::load(&left[row]).times(x));
                second[row] = second[row].plus(V::load(&right[row]).times(y));
            }
        }
    }

    /// The signals, with those of the rigid motion.
    #[inline(always)]
    pub fn with(self, rigid: &Signals, zeta: f64) -> [V; ROWS] {
        let Self(first, second) = self;
        let (rigid, zeta) = (rigid.as_chunks().0, V::splat(zeta));
        std::array::from_fn(|row| first[row].plus(second[row]).plus(V::load(&rigid[row]).times(zeta)))
    }
}

/// Signals one by one.
#[inline(always)]
pub(super) fn lanes<V: Four>(rows: [V; ROWS]) -> Signals {
    let mut signals = [0.0; SIGNALS];
    for (lanes, row) in signals.as_chunks_mut().0.iter_mut().zip(rows) {
        *lanes = row.lanes();
    }
    signals
}

impl Readings {
    /// The signals of coordinates.
    #[inline(always)]
    fn signals_here<V: Four>(&self, coordinates: &[f64]) -> Signals {
        let (groups, rest) = coordinates.as_chunks::<GROUP>();
        let mut sums = Sums::<V>::zero();
        for (columns, group) in self.signals.iter().zip(groups) {
            sums.add(columns, group);
        }
        lanes(sums.with(&self.rigid, rest.first().copied().unwrap_or_default()))
    }

    /// w_1(l) and w_2(l).
    pub fn tip_deflection(&self, coordinates: &[f64]) -> [f64; 2] {
        let (groups, _) = coordinates.as_chunks::<GROUP>();
        let mut tips = [0.0; 2];
        for (positions, group) in self.positions.iter().zip(groups) {
            for (tip, position) in tips.iter_mut().zip(&**positions) {
                *tip += position.as_flattened().iter().zip(group).map(|(position, z)| position * z).sum::<f64>();
            }
        }
        tips
    }

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
}
