//! A delay line: the newest samples, as many as a delay needs.

use serde::{Deserialize, Serialize};

use crate::clock::SampleClock;

/// The longest delay, in samples. It bounds the size of a state.
pub const LONGEST_LINE: usize = 1000;

/// The newest samples of a signal. Allocates when it is made and never again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct DelayLine {
    values: Box<[f64]>,
    newest: u64,
}

impl DelayLine {
    /// A line for delays up to `delay` at this `period` \[s\], full of the sample of index 0.
    pub fn new(delay: f64, period: f64, first: f64) -> Self {
        Self { values: vec![first; Self::capacity(delay, period)].into(), newest: 0 }
    }

    /// Samples that are newer than the delayed one, that one, and one more, since both indices are rounded.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked settings: at most LONGEST_LINE
    fn capacity(delay: f64, period: f64) -> usize {
        (delay / period).ceil() as usize + 2
    }

    /// Index of the newest sample.
    pub fn newest(&self) -> u64 {
        self.newest
    }

    /// The first sample after the newest one that would still be in the line when `last` is the newest.
    pub fn first_to_take(&self, last: u64) -> u64 {
        (self.newest + 1).max((last + 1).saturating_sub(self.values.len() as u64))
    }

    /// Takes the sample of a later index.
    pub fn push(&mut self, index: u64, value: f64) {
        let place = self.place(index);
        self.values[place] = value;
        self.newest = index;
    }

    /// A sample that is still in the line.
    pub fn get(&self, index: u64) -> f64 {
        self.values[self.place(index)]
    }

    #[allow(clippy::cast_possible_truncation)] // less than the length
    fn place(&self, index: u64) -> usize {
        (index % self.values.len() as u64) as usize
    }

    /// Whether a line that was read from somewhere can be one as long as `like`.
    pub fn is_sound(&self, like: &Self) -> bool {
        let finite = self.values.iter().all(|value| value.is_finite());
        finite && self.values.len() == like.values.len() && self.newest < SampleClock::MOST
    }
}
