//! What is shared by all instances in a loaded library: the models it serves, their layouts, the saved states.
//!
//! A library can be loaded and unloaded many times in the life of a host, and the memory of statics is not freed then.
//! So nothing here keeps memory once the last instance is gone.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use crate::handles::Handles;
use crate::interface::Interface;
use crate::layout::{DeclarationError, Layout};
use crate::model::Model;
use crate::resources::Resources;
use crate::slave::{AnySlave, Slave};
use crate::snapshot::GUID_LENGTH;
use crate::status::Refusal;
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
    use super::{AnySlave, DeclarationError, Interface, Refusal, Resources};

    pub trait Internal {
        fn guid(&'static self) -> Result<&'static str, DeclarationError>;
        #[allow(private_interfaces)]
        fn interface(&self) -> Result<Interface, DeclarationError>;
        #[allow(private_interfaces)]
        fn instantiate(&'static self, resources: &Resources) -> Result<Box<dyn AnySlave>, Refusal>;
        /// Frees what only instances need, if there are none.
        fn tidy(&self);
    }
}

/// A model of a library: see [`export!`](crate::export).
pub struct Exported<M> {
    /// As the packaging had it compiled in.
    fixed: Option<&'static str>,
    guid: OnceLock<[u8; GUID_LENGTH]>,
    layout: Mutex<Weak<Layout<M>>>,
}

impl<M> Exported<M> {
    /// For a static.
    #[must_use]
    pub const fn new(guid: Option<&'static str>) -> Self {
        Self { fixed: guid, guid: OnceLock::new(), layout: Mutex::new(Weak::new()) }
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
        if let Some(guid) = self.fixed {
            return Ok(guid);
        }
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
    fn instantiate(&'static self, resources: &Resources) -> Result<Box<dyn AnySlave>, Refusal> {
        let refused = |error: DeclarationError| Refusal::error(error.to_string());
        let (layout, guid) = (self.layout().map_err(refused)?, self.guid().map_err(refused)?);
        Ok(Box::new(Slave::<M>::new(layout, guid, resources.clone())?))
    }

    fn tidy(&self) {
        let mut shared = lock(&self.layout);
        if shared.strong_count() == 0 {
            // Also frees the memory block that the weak reference kept.
            *shared = Weak::new();
        }
    }
}

/// A loaded library: the models it serves and the states saved by `fmi2GetFMUstate`.
pub struct Library {
    package: &'static str,
    pub(crate) models: &'static [&'static dyn ExportedModel],
    pub(crate) states: Handles,
}

impl Library {
    /// For a static.
    #[must_use]
    pub const fn new(package: &'static str, models: &'static [&'static dyn ExportedModel]) -> Self {
        Self { package, models, states: Handles::new() }
    }

    /// Name of the crate that it is of.
    #[must_use]
    pub fn package(&self) -> &'static str {
        self.package
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
}

/// Locks; what a panicking thread left is consistent, since every critical section is a single operation.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
