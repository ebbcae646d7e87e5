//! The states saved by `fmi2GetFMUstate`, by the handles that the host gets.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::slave::Snapshot;

/// The saved states of a library.
pub(crate) struct Handles {
    snapshots: Mutex<Snapshots>,
}

/// Saved states, sorted by number: the latest is the last.
struct Snapshots {
    list: Vec<Saved>,
    /// How many there have been.
    count: usize,
}

struct Saved {
    /// It was the first, second, ... that was saved.
    number: usize,
    owner: usize,
    snapshot: Snapshot,
}

impl Handles {
    pub const fn new() -> Self {
        Self { snapshots: Mutex::new(Snapshots { list: Vec::new(), count: 0 }) }
    }

    /// What handles count from.
    ///
    /// A host that confuses the states of two FMUs shall get an error and not another state. So handles count from
    /// where this library is, with room for some 10⁸ before those of the next one in the address space.
    fn first(&self) -> usize {
        std::ptr::from_ref(self).addr().rotate_left(usize::BITS / 4)
    }

    /// Keeps a state under a new handle, which is never zero and never reused.
    pub fn keep(&self, owner: usize, snapshot: Snapshot) -> usize {
        let mut snapshots = self.lock();
        snapshots.count += 1;
        let number = snapshots.count;
        snapshots.list.push(Saved { number, owner, snapshot });
        self.first().wrapping_add(number)
    }

    /// Puts another state under a known handle, and gives the one before. None if the handle is not known.
    pub fn replace(&self, handle: usize, owner: usize, snapshot: Snapshot) -> Option<Snapshot> {
        let number = handle.wrapping_sub(self.first());
        let mut snapshots = self.lock();
        let place = snapshots.place(number).ok()?;
        // A model's destructor must not run while the lock is held.
        Some(std::mem::replace(&mut snapshots.list[place], Saved { number, owner, snapshot }).snapshot)
    }

    pub fn snapshot(&self, handle: usize) -> Option<Snapshot> {
        let number = handle.wrapping_sub(self.first());
        let snapshots = self.lock();
        snapshots.place(number).ok().map(|place| Arc::clone(&snapshots.list[place].snapshot))
    }

    /// Forgets a state, and gives it to the caller. None if the handle is not known.
    pub fn forget(&self, handle: usize) -> Option<Snapshot> {
        let number = handle.wrapping_sub(self.first());
        let mut snapshots = self.lock();
        let place = snapshots.place(number).ok()?;
        // A model's destructor must not run while the lock is held.
        Some(snapshots.list.remove(place).snapshot)
    }

    /// Forgets all states of an instance that is going, and hands them over to be dropped: see above.
    pub fn forget_all_of(&self, owner: usize) -> impl Iterator<Item = Snapshot> {
        let mut snapshots = self.lock();
        let forgotten: Vec<Saved> = snapshots.list.extract_if(.., |saved| saved.owner == owner).collect();
        if snapshots.list.is_empty() {
            // No memory is left in a static.
            snapshots.list = Vec::new();
        }
        drop(snapshots);
        forgotten.into_iter().map(|saved| saved.snapshot)
    }

    /// Locks; what a panicking thread left is consistent, since every critical section is a single operation.
    fn lock(&self) -> MutexGuard<'_, Snapshots> {
        self.snapshots.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Snapshots {
    /// Where the state of this number is in the list.
    fn place(&self, number: usize) -> Result<usize, usize> {
        self.list.binary_search_by_key(&number, |saved| saved.number)
    }
}
