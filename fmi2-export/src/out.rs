//! Memory that a caller provides for results.

use std::mem::MaybeUninit;

/// Places for results, which may be uninitialised: they are written and never read.
pub(crate) struct Out<'a, T>(&'a mut [MaybeUninit<T>]);

impl<'a, T: Copy> Out<'a, T> {
    pub fn new(places: &'a mut [MaybeUninit<T>]) -> Self {
        Self(places)
    }

    /// The same places, for somebody who may leave them as they are.
    pub fn again(&mut self) -> Out<'_, T> {
        Out(self.0)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Writes one value after the other. Nobody relies on there being as many values as places.
    #[inline]
    pub fn write(self, values: impl IntoIterator<Item = T>) {
        for (place, value) in self.0.iter_mut().zip(values) {
            place.write(value);
        }
    }
}

impl<'a, T: Copy> From<&'a mut [T]> for Out<'a, T> {
    fn from(places: &'a mut [T]) -> Self {
        // SAFETY: `MaybeUninit<T>` has the layout of `T`; through it only values of `T` are written, see `write`.
        Self(unsafe { &mut *(std::ptr::from_mut(places) as *mut [MaybeUninit<T>]) })
    }
}
