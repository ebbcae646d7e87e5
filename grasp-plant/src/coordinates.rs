//! Coordinates in memory.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::slice;

/// Bytes of a line of a processor's cache.
const LINE: usize = 64;

/// Numbers before the first, at most.
const BEFORE: usize = LINE / size_of::<f64>() - 1;

/// Coordinates, as a list of numbers that begins where a line of a processor's cache does. Elsewhere every other wide register would be
/// read from two lines, and written to two.
///
/// It is used as a slice, made of a [`Vec`] or by collecting, and serialised as either.
// An allocation that is aligned takes the system much longer than one that is somewhat larger.
#[derive(Default)]
pub struct Coordinates {
    /// Never shorter than `first + length`.
    memory: Vec<f64>,
    /// Which number in memory is the first.
    first: usize,
    length: usize,
}

impl Coordinates {
    /// Makes it as long, with zeros where there is more than before.
    #[inline(never)]
    pub(crate) fn resize(&mut self, length: usize) {
        if length > self.length {
            let longer: Vec<f64> = self.iter().copied().chain(std::iter::repeat(0.0)).take(length).collect();
            self.assign(&longer);
        }
        self.length = length;
    }

    /// Makes it the same as a list; memory is asked for only if that is longer than any before.
    pub(crate) fn assign(&mut self, numbers: &[f64]) {
        self.memory.clear();
        if self.memory.capacity() < self.first + numbers.len() || self.memory.capacity() == 0 {
            self.memory = Vec::with_capacity(numbers.len() + BEFORE);
            self.first = (LINE - self.memory.as_ptr().addr() % LINE) % LINE / size_of::<f64>();
        }
        // There is room: where the memory is stays as it is.
        self.memory.resize(self.first, 0.0);
        self.memory.extend_from_slice(numbers);
        self.length = numbers.len();
    }
}

impl Deref for Coordinates {
    type Target = [f64];

    #[inline]
    fn deref(&self) -> &[f64] {
        // SAFETY: so much of the memory is there, see `assign` and `resize`.
        unsafe { self.memory.get_unchecked(self.first..self.first + self.length) }
    }
}

impl DerefMut for Coordinates {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f64] {
        // SAFETY: as above.
        unsafe { self.memory.get_unchecked_mut(self.first..self.first + self.length) }
    }
}

impl Clone for Coordinates {
    #[inline(never)]
    fn clone(&self) -> Self {
        Self::from(&**self)
    }

    fn clone_from(&mut self, source: &Self) {
        self.assign(source);
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
            assert!(coordinates.as_ptr().addr().is_multiple_of(LINE));
            let mut other = Coordinates::from(vec![1.0; 20]);
            other.clone_from(&coordinates);
            assert_eq!(other, coordinates.clone());
        }
        coordinates.resize(3);
        coordinates.resize(5);
        assert_eq!(*coordinates, [0.5, 1.5, 2.5, 0.0, 0.0]);
    }
}
