//! Results for the step sizes last used, of a plant and of all plants that share their matrices.

use crate::step_sizes::REMEMBERED;
use std::sync::{Arc, Mutex, PoisonError};

/// Something made for one step size.
pub(crate) trait OfOneSize {
    /// The step size \[s\].
    fn step_size(&self) -> f64;
}

/// Step sizes kept: as many as a state remembers.
const CAPACITY: usize = REMEMBERED;

/// The last sizes of one plant, most recent first. Clones share the results.
#[derive(Debug)]
#[repr(C)] // The last one first, beside what else the usual step needs.
pub(crate) struct Cache<T> {
    /// The last one. The usual step looks at no list.
    last: Option<Arc<T>>,
    others: Vec<Arc<T>>,
}

/// The last sizes of all plants of the same parameters.
#[derive(Debug)]
pub(crate) struct Shared<T> {
    entries: Mutex<Vec<Arc<T>>>,
}

impl<T> Default for Cache<T> {
    fn default() -> Self {
        Self { last: None, others: Vec::new() }
    }
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self { entries: Mutex::default() }
    }
}

impl<T> Clone for Cache<T> {
    fn clone(&self) -> Self {
        Self { last: self.last.clone(), others: self.others.clone() }
    }

    /// A plant that goes back to a state of its own mostly has the same results still.
    fn clone_from(&mut self, source: &Self) {
        let same = |own: &[Arc<T>], other: &[Arc<T>]| {
            own.len() == other.len() && own.iter().zip(other).all(|(own, other)| Arc::ptr_eq(own, other))
        };
        if !same(self.last.as_slice(), source.last.as_slice()) {
            self.last.clone_from(&source.last);
        }
        if !same(&self.others, &source.others) {
            self.others.clone_from(&source.others);
        }
    }
}

impl<T: OfOneSize> Cache<T> {
    /// The result for step size h, if that is the last size.
    #[inline]
    pub fn last(&self, h: f64) -> Option<&T> {
        self.last.as_ref().filter(|entry| is_of(entry, h)).map(|entry| &**entry)
    }

    /// The result for the last size, whatever that is.
    #[inline]
    pub fn newest(&self) -> Option<&T> {
        self.last.as_deref()
    }

    /// Makes the result for step size h the last, if it is here.
    pub fn recall(&mut self, h: f64) -> bool {
        if self.last(h).is_some() {
            return true;
        }
        let Some(index) = self.others.iter().position(|entry| is_of(entry, h)) else { return false };
        if let Some(last) = &mut self.last {
            std::mem::swap(last, &mut self.others[index]);
            // What was the last before comes first.
            self.others[..=index].rotate_right(1);
        } else {
            self.last = Some(self.others.remove(index));
        }
        true
    }

    /// The result for step size h, computed now unless this plant or one that shares with it has it among its last sizes.
    #[inline]
    pub fn get(&mut self, shared: &Shared<T>, h: f64, make: impl FnOnce() -> T) -> &T {
        if !self.recall(h)
            && let Some(before) = self.last.replace(shared.get(h, make))
        {
            self.others.truncate(CAPACITY - 2);
            self.others.insert(0, before);
        }
        self.last.as_deref().expect("the result is the last")
    }
}

impl<T: OfOneSize> Shared<T> {
    fn get(&self, h: f64, make: impl FnOnce() -> T) -> Arc<T> {
        // The data stay consistent if a thread panics.
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(index) = entries.iter().position(|entry| is_of(entry, h)) {
            entries[..=index].rotate_right(1);
        } else {
            entries.truncate(CAPACITY - 1);
            entries.insert(0, Arc::new(make()));
        }
        Arc::clone(&entries[0])
    }
}

fn is_of<T: OfOneSize>(entry: &Arc<T>, h: f64) -> bool {
    entry.step_size().to_bits() == h.to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Of(f64);

    impl OfOneSize for Of {
        fn step_size(&self) -> f64 {
            self.0
        }
    }

    #[test]
    fn the_cache_is_bounded_and_keeps_what_was_used_last() {
        let (shared, mut cache) = (Shared::default(), Cache::default());
        let first = 1e-3;
        for i in 1..20 {
            for h in [first * f64::from(i + 1), first] {
                assert_eq!(cache.get(&shared, h, || Of(h)).0.to_bits(), h.to_bits());
            }
        }
        assert_eq!(cache.others.len(), CAPACITY - 1);
        assert_eq!(shared.entries.lock().unwrap().len(), CAPACITY);
        assert_eq!(cache.last(first).unwrap().0.to_bits(), first.to_bits());
        assert!(cache.last(2.0 * first).is_none());
    }

    /// A result of one plant is reused by another with the same parameters.
    #[test]
    fn sizes_are_made_once() {
        let (shared, mut made) = (Shared::default(), 0);
        for mut cache in [Cache::default(), Cache::default()] {
            for h in [1e-3, 2e-3, 1e-3] {
                cache.get(&shared, h, || {
                    made += 1;
                    Of(h)
                });
            }
        }
        assert_eq!(made, 2);
    }
}
