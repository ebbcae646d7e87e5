//! Coordinates in memory.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::slice;

/// Numbers of a line of a processor's cache.
const LINE: usize = 8;

#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Line([f64; LINE]);

/// Coordinates, as a list of numbers that begins where a line of a processor's cache does. Elsewhere every other wide register would be
/// read from two lines, and written to two.
///
/// It is used as a slice, made of a [`Vec`] or by collecting, and serialised as either.
#[derive(Default)]
pub struct Coordinates {
    lines: Vec<Line>,
    length: usize,
}

impl Coordinates {
    /// Makes it as long, with zeros where there is more than before.
    #[inline(never)]
    pub(crate) fn resize(&mut self, length: usize) {
        let before = self.length.min(length);
        self.lines.resize(length.div_ceil(LINE), Line([0.0; LINE]));
        self.length = length;
        self[before..].fill(0.0);
    }

    /// Makes it the same as a list; memory is asked for only if that is longer than any before.
    pub(crate) fn assign(&mut self, numbers: &[f64]) {
        self.resize(numbers.len());
        self.copy_from_slice(numbers);
    }
}

impl Deref for Coordinates {
    type Target = [f64];

    #[inline]
    fn deref(&self) -> &[f64] {
        // SAFETY: lines are eight numbers each, without gaps, and there are enough of them.
        unsafe { slice::from_raw_parts(self.lines.as_ptr().cast(), self.length) }
    }
}

impl DerefMut for Coordinates {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f64] {
        // SAFETY: as above.
        unsafe { slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast(), self.length) }
    }
}

impl Clone for Coordinates {
    #[inline(never)]
    fn clone(&self) -> Self {
        Self { lines: self.lines.clone(), length: self.length }
    }

    fn clone_from(&mut self, source: &Self) {
        self.lines.clone_from(&source.lines);
        self.length = source.length;
    }
}

impl From<&[f64]> for Coordinates {
    fn from(numbers: &[f64]) -> Self {
        let mut coordinates = Self::default();
        coordinates.assign(numbers);
        coordinates
    }
}

impl From<Vec<f64>> for Coordinates {
    fn from(numbers: Vec<f64>) -> Self {
        Self::from(&numbers[..])
    }
}

impl FromIterator<f64> for Coordinates {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        Self::from(numbers.into_iter().collect::<Vec<f64>>())
    }
}

impl<'a> IntoIterator for &'a Coordinates {
    type Item = &'a f64;
    type IntoIter = slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl PartialEq for Coordinates {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl fmt::Debug for Coordinates {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(formatter)
    }
}

impl Serialize for Coordinates {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Coordinates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_list_of_any_length() {
        let numbers = |length: u32| (0..length).map(|i| f64::from(i) + 0.5).collect::<Vec<f64>>();
        let mut coordinates = Coordinates::default();
        for length in [0, 1, 8, 33, 9, 16] {
            let expected = numbers(length);
            coordinates.assign(&expected);
            assert_eq!(*coordinates, expected);
            assert_eq!(coordinates, expected.iter().copied().collect());
            assert!(coordinates.as_ptr().addr().is_multiple_of(align_of::<Line>()));
            let mut other = Coordinates::from(vec![1.0; 20]);
            other.clone_from(&coordinates);
            assert_eq!(other, coordinates.clone());
        }
        coordinates.resize(3);
        coordinates.resize(5);
        assert_eq!(*coordinates, [0.5, 1.5, 2.5, 0.0, 0.0]);
    }
}
