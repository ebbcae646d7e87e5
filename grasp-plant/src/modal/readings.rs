//! What is read from modal coordinates.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::table::{GROUP, LANES, Lanes};
use crate::dynamics::{FORCES, SIGNALS, Signals};

/// What is read from the coordinates.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    /// Signals per coordinate of each group, and per ζ.
    pub signals: Vec<[Signals; GROUP]>,
    pub rigid: Signals,
    /// w_1(l), w_2(l) and y_M per coordinate.
    pub positions: Vec<[[Lanes; 2]; FORCES]>,
}

impl Readings {
    /// The signals of coordinates.
    #[inline(always)]
    fn signals_here(&self, coordinates: &[f64]) -> Signals {
        let (groups, rest) = coordinates.as_chunks::<GROUP>();
        let (mut first, mut second) = ([0.0; SIGNALS], [0.0; SIGNALS]);
        for (columns, group) in self.signals.iter().zip(groups) {
            for lane in 0..LANES {
                let (x, y) = (group[lane], group[LANES + lane]);
                for row in 0..SIGNALS {
                    first[row] += columns[lane][row] * x;
                    second[row] += columns[LANES + lane][row] * y;
                }
            }
        }
        let rigid = rest.first().copied().unwrap_or_default();
        std::array::from_fn(|row| first[row] + second[row] + self.rigid[row] * rigid)
    }

    /// w_1(l) and w_2(l).
    pub fn tip_deflection(&self, coordinates: &[f64]) -> [f64; 2] {
        let (groups, _) = coordinates.as_chunks::<GROUP>();
        let mut tips = [0.0; 2];
        for (positions, group) in self.positions.iter().zip(groups) {
            for (tip, position) in tips.iter_mut().zip(positions) {
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
        self.signals_here(coordinates)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn signals_wide(&self, coordinates: &[f64]) -> Signals {
        self.signals_here(coordinates)
    }
}
