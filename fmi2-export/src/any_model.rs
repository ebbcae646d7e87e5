//! A model whose type is forgotten. This is what is compiled for each type of model; an instance and all that the C interface does
//! with it are compiled once for a library.

use std::any::Any;

use crate::model::{Conclusion, Experiment, Failure, Model, Step};
use crate::resources::Resources;
use crate::snapshot::Sink;

/// A [`Model`], whatever its type.
pub(crate) trait AnyModel: Any + Send + Sync {
    fn copy(&self) -> Box<dyn AnyModel>;
    /// Another one of this type, with its default values.
    fn fresh(&self) -> Box<dyn AnyModel>;
    /// Makes it what another one is, in the memory that it has; false if that is of another type.
    fn assign(&mut self, from: &dyn AnyModel) -> bool;
    /// Begins anew. What the model before has computed is passed on, unless it cannot be trusted.
    fn renew(&mut self, resources: &Resources, inherits: bool) -> Result<(), Failure>;
    fn resources(&mut self, resources: &Resources) -> Result<(), Failure>;
    fn initialize(&mut self, experiment: &Experiment) -> Result<(), Failure>;
    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure>;
    fn retuned(&mut self) -> Result<(), Failure>;
    fn restored(&mut self) -> Result<(), Failure>;
    fn conclude(&mut self, conclusion: &mut Conclusion<'_>);
    fn directional_derivative(&mut self, direction: &mut dyn AnyModel);
    fn encode(&self, sink: &mut Sink<'_>) -> postcard::Result<()>;
    /// Another one of this type, from bytes; and what is left of them.
    fn decode<'b>(&self, bytes: &'b [u8]) -> postcard::Result<(Box<dyn AnyModel>, &'b [u8])>;
}

/// A model with its default values.
#[inline(never)]
pub(crate) fn fresh<M: Model>() -> Box<dyn AnyModel> {
    Box::<M>::default()
}

/// The model as what it is.
pub(crate) fn typed<M: 'static>(model: &mut dyn AnyModel) -> &mut M {
    let model: &mut dyn Any = model;
    model.downcast_mut().expect("what belongs to a model is only used with models of its type")
}

impl<M: Model> AnyModel for M {
    fn copy(&self) -> Box<dyn AnyModel> {
        Box::new(copied(self))
    }

    fn fresh(&self) -> Box<dyn AnyModel> {
        fresh::<M>()
    }

    fn assign(&mut self, from: &dyn AnyModel) -> bool {
        let from: &dyn Any = from;
        let from = from.downcast_ref();
        if let Some(from) = from {
            self.clone_from(from);
        }
        from.is_some()
    }

    fn renew(&mut self, resources: &Resources, inherits: bool) -> Result<(), Failure> {
        let mut fresh = M::default();
        Model::resources(&mut fresh, resources)?;
        let before = std::mem::replace(self, fresh);
        if inherits {
            self.inherit(before);
        }
        Ok(())
    }

    fn resources(&mut self, resources: &Resources) -> Result<(), Failure> {
        Model::resources(self, resources)
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        Model::initialize(self, experiment)
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        Model::step(self, step)
    }

    fn retuned(&mut self) -> Result<(), Failure> {
        Model::retuned(self)
    }

    fn restored(&mut self) -> Result<(), Failure> {
        Model::restored(self)
    }

    fn conclude(&mut self, conclusion: &mut Conclusion<'_>) {
        Model::conclude(self, conclusion);
    }

    fn directional_derivative(&mut self, direction: &mut dyn AnyModel) {
        Model::directional_derivative(self, typed(direction));
    }

    fn encode(&self, sink: &mut Sink<'_>) -> postcard::Result<()> {
        sink.put(self)
    }

    fn decode<'b>(&self, bytes: &'b [u8]) -> postcard::Result<(Box<dyn AnyModel>, &'b [u8])> {
        let (model, rest) = postcard::take_from_bytes::<M>(bytes)?;
        Ok((Box::new(model), rest))
    }
}

/// A model's `clone` is long; one is enough.
#[inline(never)]
fn copied<M: Clone>(model: &M) -> M {
    model.clone()
}
