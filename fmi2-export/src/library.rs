//! A library as its packaging program sees it: which models it has and what they say of themselves.
//!
//! The C functions do not use any of this (see `served`), so nothing of it is in the library that an importing tool loads.

use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;

use crate::any_model::fresh;
use crate::interface::Interface;
use crate::layout::{DeclarationError, Layout};
use crate::model::Model;
use crate::phase::Kind;
use crate::resources::Resources;
use crate::served::Served;
use crate::slave::Slave;
use crate::status::Refusal;
use crate::xml::{Description, describe};

/// A model that a library serves, whatever its type.
pub trait ExportedModel: Sync + sealed::Internal {
    /// The model's description.
    ///
    /// # Errors
    /// If the model's declarations contradict themselves.
    fn description(&self) -> Result<Description, DeclarationError>;
}

pub(crate) mod sealed {
    use super::{DeclarationError, Interface, Refusal, Resources, Slave};

    pub trait Internal {
        #[allow(private_interfaces)]
        fn interface(&self) -> Result<Interface, DeclarationError>;
        /// An instance that no host has.
        #[allow(private_interfaces)]
        fn instantiate(&self, resources: &Resources) -> Result<Slave, Refusal>;
    }
}

/// What a model says of itself: see [`export!`](crate::export).
pub struct Described<M>(PhantomData<fn() -> M>);

impl<M: Model> Described<M> {
    /// The model, its type forgotten.
    pub const MODEL: &'static dyn ExportedModel = &Self(PhantomData);
}

impl<M: Model> ExportedModel for Described<M> {
    fn description(&self) -> Result<Description, DeclarationError> {
        describe::<M>()
    }
}

impl<M: Model> sealed::Internal for Described<M> {
    #[allow(private_interfaces)]
    fn interface(&self) -> Result<Interface, DeclarationError> {
        Interface::of::<M>()
    }

    #[allow(private_interfaces)]
    fn instantiate(&self, resources: &Resources) -> Result<Slave, Refusal> {
        let layout = Layout::build::<M>().map_err(|error| Refusal::error(error.to_string()))?;
        // The GUID guards states that are read from bytes; the packaging reads none.
        Slave::new(Arc::new(layout), fresh::<M>(), "", Kind::CoSimulation, resources.clone())
    }
}

/// The models of a library.
pub struct Library {
    package: &'static str,
    models: &'static [&'static dyn ExportedModel],
    served: &'static Served,
}

impl Library {
    /// For a static.
    #[must_use]
    pub const fn new(
        package: &'static str,
        models: &'static [&'static dyn ExportedModel],
        served: &'static Served,
    ) -> Self {
        Self { package, models, served }
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

    /// The same as the C functions know it: for tests that call these as Rust functions.
    #[doc(hidden)]
    #[must_use]
    pub fn served(&self) -> &'static Served {
        self.served
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
