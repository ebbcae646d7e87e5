//! The step sizes that a plant has used, and so the decision which of its steps deserve a matrix.
//!
//! The matrix of a step size costs as much as some hundred steps. It pays if a host repeats its step sizes. If no step size
//! is used twice, steps without a matrix are faster ([`Extended::advance`](crate::extended::Extended::advance)). Both
//! methods are exact but round differently. So the data for this decision are part of the state, and a run that is saved
//! and continued has the bits of one that was not.

use serde::{Deserialize, Serialize};

/// Number of remembered step sizes. Masters that compute their step as a difference of times use a few sizes that differ by
/// rounding.
pub(crate) const REMEMBERED: usize = 8;

/// The last sizes, most recent first, and how many new ones have come in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepSizes {
    /// The last sizes; zero for none.
    recent: [f64; REMEMBERED],
    strangers: u8,
}

impl StepSizes {
    /// New sizes in a row that get matrices all the same: a host may begin with as many as are remembered.
    const PATIENCE: u8 = 8;

    /// Takes note of a step of size h.
    #[inline]
    pub(crate) fn note(&mut self, h: f64) {
        if self.recent[0].to_bits() == h.to_bits() {
            self.strangers = 0;
        } else {
            self.note_another(h);
        }
    }

    /// Whether to note a step of size h would change nothing.
    #[inline]
    pub(crate) fn is_usual(&self, h: f64) -> bool {
        self.recent[0].to_bits() == h.to_bits() && self.strangers == 0
    }

    #[inline(never)]
    fn note_another(&mut self, h: f64) {
        if let Some(index) = self.recent.iter().position(|size| size.to_bits() == h.to_bits()) {
            self.recent[..=index].rotate_right(1);
            self.strangers = 0;
        } else {
            self.recent.rotate_right(1);
            self.recent[0] = h;
            self.strangers = self.strangers.saturating_add(1);
        }
    }

    /// Whether the step noted last deserves a matrix: its size has occurred before, or may occur again.
    #[inline]
    pub(crate) fn repeat(&self) -> bool {
        self.strangers <= Self::PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_sizes_in_any_order_repeat_and_endless_new_ones_do_not() {
        let mut sizes = StepSizes::default();
        for i in 0..100 {
            sizes.note([1e-4, 1.1e-4, 0.9e-4, 2e-4][i * i % 4]);
            assert!(sizes.repeat());
        }
        for i in 1..=100 {
            sizes.note(1e-3 * f64::from(i));
            assert_eq!(sizes.repeat(), i <= 8, "{i}");
        }
        sizes.note(1e-3 * 95.0);
        assert!(sizes.repeat(), "remembered though it had no matrix");
    }
}
