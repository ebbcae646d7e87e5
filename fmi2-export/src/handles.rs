//! The states saved by `fmi2GetFMUstate`, by the handles that the host gets.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::slave::Snapshot;

/// Owner and content of each saved state, by handle.
type Snapshots = BTreeMap<usize, (usize, Snapshot)>;

/// The saved states of a library.
pub(crate) struct Handles {
    snapshots: Mutex<Snapshots>,
    next: AtomicUsize,
}

impl Handles {
    pub const fn new() -> Self {
        Self { snapshots: Mutex::new(Snapshots::new()), next: AtomicUsize::new(1) }
    }

    /// Keeps a state under a new handle, which is never zero and never reused.
    ///
    /// A host that confuses the states of two FMUs shall get an error and not another state. So handles count from
    /// where this library is, with room for some 10⁸ before those of the next one in the address space.
    pub fn keep(&self, owner: usize, snapshot: Snapshot) -> usize {
        let first = std::ptr::from_ref(self).addr().rotate_left(usize::BITS / 4);
        let handle = first.wrapping_add(self.next.fetch_add(1, Ordering::Relaxed));
        self.lock().insert(handle, (owner, snapshot));
        handle
    }

    /// Puts another state under a known handle. False if the handle is not known.
    pub fn replace(&self, handle: usize, owner: usize, snapshot: Snapshot) -> bool {
        let old = self.lock().get_mut(&handle).map(|entry| std::mem::replace(entry, (owner, snapshot)));
        old.is_some()
    }

    pub fn snapshot(&self, handle: usize) -> Option<Snapshot> {
        self.lock().get(&handle).map(|(_, snapshot)| Arc::clone(snapshot))
    }

    /// Forgets a state. False if the handle is not known.
    pub fn forget(&self, handle: usize) -> bool {
        let forgotten = self.remove(|snapshots| snapshots.remove(&handle));
        forgotten.is_some()
    }

    /// Forgets all states an instance has saved, and hands them over to be dropped.
    pub fn forget_all_of(&self, owner: usize) -> impl Iterator<Item = Snapshot> {
        let forgotten = self.remove(|snapshots| {
            let all = std::mem::take(snapshots);
            let (its, others): (Snapshots, Snapshots) = all.into_iter().partition(|(_, (of, _))| *of == owner);
            *snapshots = others;
            its
        });
        forgotten.into_values().map(|(_, snapshot)| snapshot)
    }

    /// Removes states, which the caller drops: models have destructors, and these must not run while the lock is held.
    fn remove<T>(&self, remove: impl FnOnce(&mut Snapshots) -> T) -> T {
        let mut snapshots = self.lock();
        let removed = remove(&mut snapshots);
        if snapshots.is_empty() {
            *snapshots = Snapshots::new();
        }
        removed
    }

    /// Locks; what a panicking thread left is consistent, since every critical section is a single operation.
    fn lock(&self) -> MutexGuard<'_, Snapshots> {
        self.snapshots.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
