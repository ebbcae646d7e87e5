//! What the instances in a loaded library share: the models it serves, their layouts, the saved states.
//!
//! The C functions know a library as a [`Served`]. Nothing in it leads to what describes a model: the XML is written by the
//! packaging program ([`Library`](crate::Library)), and its code is not linked into what importing tools load.
//!
//! A library can be loaded and unloaded many times in the life of a host, and the memory of statics is not freed then.
//! So nothing here keeps memory once the last instance is gone.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use crate::any_model::{AnyModel, fresh};
use crate::declarations::Declarations;
use crate::handles::Handles;
use crate::layout::{DeclarationError, Layout};
use crate::model::Model;
use crate::phase::Kind;
use crate::resources::Resources;
use crate::slave::Slave;
use crate::snapshot::GUID_LENGTH;
use crate::status::Refusal;
use crate::xml::{Description, describe};

/// A model of a library, its type forgotten: see [`export!`](crate::export).
pub struct Exported {
    identity: Identity,
    declared: fn() -> Declarations,
    fresh: fn() -> Box<dyn AnyModel>,
    layout: Mutex<Weak<Layout>>,
}

/// Where a model's GUID is from. A function is named only where it is needed, since what a static names is linked.
enum Identity {
    /// The packaging had it compiled in, and has checked the declarations.
    Fixed(&'static str),
    /// The library was built by itself: from the description, when it is first asked for.
    Computed {
        layout: fn() -> Result<Layout, DeclarationError>,
        describe: fn() -> Result<Description, DeclarationError>,
        guid: OnceLock<[u8; GUID_LENGTH]>,
    },
}

impl Exported {
    /// For a static.
    #[must_use]
    pub const fn of<M: Model>(guid: Option<&'static str>) -> Self {
        let identity = match guid {
            Some(guid) => Identity::Fixed(guid),
            None => Identity::Computed { layout: Layout::build::<M>, describe: describe::<M>, guid: OnceLock::new() },
        };
        Self { identity, declared: Declarations::brief::<M>, fresh: fresh::<M>, layout: Mutex::new(Weak::new()) }
    }

    fn layout(&self) -> Result<Arc<Layout>, DeclarationError> {
        let mut shared = lock(&self.layout);
        if let Some(layout) = shared.upgrade() {
            return Ok(layout);
        }
        let layout = Arc::new(match &self.identity {
            Identity::Fixed(_) => Layout::of((self.declared)()),
            Identity::Computed { layout, .. } => layout()?,
        });
        *shared = Arc::downgrade(&layout);
        Ok(layout)
    }

    pub(crate) fn guid(&'static self) -> Result<&'static str, DeclarationError> {
        let (describe, guid) = match &self.identity {
            Identity::Fixed(guid) => return Ok(guid),
            Identity::Computed { describe, guid, .. } => (describe, guid),
        };
        let bytes = if let Some(bytes) = guid.get() {
            bytes
        } else {
            let mut bytes = [b' '; GUID_LENGTH];
            bytes.iter_mut().zip(describe()?.guid.bytes()).for_each(|(to, from)| *to = from);
            guid.get_or_init(|| bytes)
        };
        Ok(std::str::from_utf8(bytes).unwrap_or_default())
    }

    pub(crate) fn instantiate(&'static self, kind: Kind, resources: &Resources) -> Result<Slave, Refusal> {
        let refused = |error: DeclarationError| Refusal::error(error.to_string());
        let (layout, guid) = (self.layout().map_err(refused)?, self.guid().map_err(refused)?);
        let slave = Slave::new(layout, (self.fresh)(), guid, kind, resources.clone());
        // The layout was made before; without an instance nobody else would take it away.
        slave.inspect_err(|_| self.tidy())
    }

    /// Frees what only instances need, if there are none.
    pub(crate) fn tidy(&self) {
        let mut shared = lock(&self.layout);
        if shared.strong_count() == 0 {
            // Also frees the memory block that the weak reference kept.
            *shared = Weak::new();
        }
    }
}

/// A loaded library: the models it serves and the states saved by `fmi2GetFMUstate`.
pub struct Served {
    pub(crate) models: &'static [&'static Exported],
    pub(crate) states: Handles,
    /// A model has said that what all instances share is beyond repair.
    lost: AtomicBool,
}

impl Served {
    /// For a static.
    #[must_use]
    pub const fn new(models: &'static [&'static Exported]) -> Self {
        Self { models, states: Handles::new(), lost: AtomicBool::new(false) }
    }

    /// Whether `fmi2Fatal` has been returned: then "it is not possible to call any other function for any of the FMU instances"
    /// (FMI 2.0.4, section 2.1.3).
    pub(crate) fn is_lost(&self) -> bool {
        self.lost.load(Ordering::SeqCst)
    }

    /// For as long as the library stays loaded.
    pub(crate) fn lose(&self) {
        self.lost.store(true, Ordering::SeqCst);
    }
}

/// Locks; what a panicking thread left is consistent, since every critical section is a single operation.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
