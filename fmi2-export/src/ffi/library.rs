//! What is shared by all instances in a loaded library: the models it serves, their layouts, the saved states.
//!
//! A library can be loaded and unloaded many times in the life of a host, and the memory of statics is not freed then.
//! So nothing here keeps memory once the last instance is gone.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use crate::Model;
use crate::interface::Interface;
use crate::layout::{DeclarationError, Layout};
use crate::slave::{AnySlave, Slave, Snapshot};
use crate::snapshot::GUID_LENGTH;
use crate::xml::{Description, describe, describe_interface};

/// A model that a library serves, whatever its type.
pub trait ExportedModel: Sync + sealed::Internal {
    /// The model's description.
    ///
    /// # Errors
    /// If the model's declarations contradict themselves.
    fn description(&self) -> Result<Description, DeclarationError>;
}

pub(crate) mod sealed {
    use super::{AnySlave, DeclarationError, Interface};

    pub trait Internal {
        fn guid(&'static self) -> Result<&'static str, DeclarationError>;
        #[allow(private_interfaces)]
        fn interface(&self) -> Result<Interface, DeclarationError>;
        #[allow(private_interfaces)]
        fn instantiate(&'static self) -> Result<Box<dyn AnySlave>, DeclarationError>;
        /// Frees what only instances need, if there are none.
        fn tidy(&self);
    }
}

/// A model of a library: see [`export!`](crate::export).
pub struct Exported<M> {
    guid: OnceLock<[u8; GUID_LENGTH]>,
    layout: Mutex<Weak<Layout<M>>>,
}

impl<M> Exported<M> {
    /// For a static.
    #[must_use]
    #[allow(clippy::new_without_default)]
    pub const fn new() -> Self {
        Self { guid: OnceLock::new(), layout: Mutex::new(Weak::new()) }
    }
}

impl<M: Model> Exported<M> {
    fn layout(&self) -> Result<Arc<Layout<M>>, DeclarationError> {
        let mut shared = lock(&self.layout);
        if let Some(layout) = shared.upgrade() {
            return Ok(layout);
        }
        let layout = Arc::new(Layout::build()?);
        *shared = Arc::downgrade(&layout);
        Ok(layout)
    }
}

impl<M: Model> ExportedModel for Exported<M> {
    fn description(&self) -> Result<Description, DeclarationError> {
        describe::<M>()
    }
}

impl<M: Model> sealed::Internal for Exported<M> {
    fn guid(&'static self) -> Result<&'static str, DeclarationError> {
        let bytes = if let Some(bytes) = self.guid.get() {
            bytes
        } else {
            let guid = describe_interface(&Interface::of(&*self.layout()?)).guid;
            self.tidy();
            let mut bytes = [b' '; GUID_LENGTH];
            bytes.iter_mut().zip(guid.bytes()).for_each(|(to, from)| *to = from);
            self.guid.get_or_init(|| bytes)
        };
        Ok(std::str::from_utf8(bytes).unwrap_or_default())
    }

    #[allow(private_interfaces)]
    fn interface(&self) -> Result<Interface, DeclarationError> {
        Ok(Interface::of(&Layout::<M>::build()?))
    }

    #[allow(private_interfaces)]
    fn instantiate(&'static self) -> Result<Box<dyn AnySlave>, DeclarationError> {
        Ok(Box::new(Slave::<M>::new(self.layout()?, self.guid()?)))
    }

    fn tidy(&self) {
        let mut shared = lock(&self.layout);
        if shared.strong_count() == 0 {
            // Also frees the memory block that the weak reference kept.
            *shared = Weak::new();
        }
    }
}

/// Owner and content of each saved state, by handle.
type Snapshots = BTreeMap<usize, (usize, Snapshot)>;

/// A loaded library: the models it serves and the states saved by `fmi2GetFMUstate`.
pub struct Library {
    pub(crate) models: &'static [&'static dyn ExportedModel],
    snapshots: Mutex<Snapshots>,
    next_handle: AtomicUsize,
}

impl Library {
    /// For a static.
    #[must_use]
    pub const fn new(models: &'static [&'static dyn ExportedModel]) -> Self {
        Self { models, snapshots: Mutex::new(Snapshots::new()), next_handle: AtomicUsize::new(1) }
    }

    /// The models this library serves.
    #[must_use]
    pub fn models(&self) -> &'static [&'static dyn ExportedModel] {
        self.models
    }

    /// Which models' descriptions differ from the files `NAME.xml` in a folder, or have none there. For a test in crates that
    /// keep their descriptions under version control, so that a change of the interface shows up in review.
    ///
    /// # Errors
    /// If a model's declarations contradict themselves.
    pub fn outdated(&self, folder: &Path) -> Result<Vec<&'static str>, DeclarationError> {
        let mut names = Vec::new();
        for model in self.models {
            let description = model.description()?;
            let kept = std::fs::read(folder.join(format!("{}.xml", description.name)));
            if !kept.is_ok_and(|kept| kept == description.xml.as_bytes()) {
                names.push(description.name);
            }
        }
        Ok(names)
    }

    /// Keeps a state under a new handle, which is never zero and never reused.
    ///
    /// A host that confuses the states of two FMUs shall get an error and not another state. So handles count from
    /// where this library is, with room for some 10⁸ before those of the next one in the address space.
    pub(crate) fn keep(&self, owner: usize, snapshot: Snapshot) -> usize {
        let first = std::ptr::from_ref(self).addr().rotate_left(usize::BITS / 4);
        let handle = first.wrapping_add(self.next_handle.fetch_add(1, Ordering::Relaxed));
        lock(&self.snapshots).insert(handle, (owner, snapshot));
        handle
    }

    /// Puts another state under a known handle. False if the handle is not known.
    pub(crate) fn replace(&self, handle: usize, owner: usize, snapshot: Snapshot) -> bool {
        let old = lock(&self.snapshots).get_mut(&handle).map(|entry| std::mem::replace(entry, (owner, snapshot)));
        old.is_some()
    }

    pub(crate) fn snapshot(&self, handle: usize) -> Option<Snapshot> {
        lock(&self.snapshots).get(&handle).map(|(_, snapshot)| Arc::clone(snapshot))
    }

    /// Forgets a state. False if the handle is not known.
    pub(crate) fn forget(&self, handle: usize) -> bool {
        let forgotten = self.remove(|snapshots| snapshots.remove(&handle));
        forgotten.is_some()
    }

    /// Forgets all states an instance has saved, and hands them over to be dropped.
    pub(crate) fn forget_all_of(&self, owner: usize) -> impl Iterator<Item = Snapshot> {
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
        let mut snapshots = lock(&self.snapshots);
        let removed = remove(&mut snapshots);
        if snapshots.is_empty() {
            *snapshots = Snapshots::new();
        }
        removed
    }
}

/// Locks; what a panicking thread left is consistent, since every critical section is a single operation.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
