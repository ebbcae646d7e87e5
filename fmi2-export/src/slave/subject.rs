//! A model and the layout of its variables, which are of one type, though nobody knows which.

use std::sync::Arc;

use crate::any_model::AnyModel;
use crate::layout::Layout;
use crate::view::View;

pub(super) struct Subject {
    layout: Arc<Layout>,
    /// Of the layout's type: checked when it comes in.
    model: Box<dyn AnyModel>,
}

impl Subject {
    /// # Panics
    /// If the two do not belong together.
    pub fn new(layout: Arc<Layout>, mut model: Box<dyn AnyModel>) -> Self {
        layout.view(&mut *model);
        Self { layout, model }
    }

    /// Another model with the same layout.
    ///
    /// # Panics
    /// If the two do not belong together.
    pub fn with(&self, model: Box<dyn AnyModel>) -> Self {
        Self::new(Arc::clone(&self.layout), model)
    }

    /// Another one that is the same.
    pub fn copy(&self) -> Self {
        Self { layout: Arc::clone(&self.layout), model: self.model.copy() }
    }

    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    pub fn model(&self) -> &dyn AnyModel {
        &*self.model
    }

    pub fn model_mut(&mut self) -> &mut dyn AnyModel {
        &mut *self.model
    }

    /// Both, where both are needed.
    pub fn parts(&mut self) -> (&Layout, &mut dyn AnyModel) {
        (&self.layout, &mut *self.model)
    }

    pub fn into_model(self) -> Box<dyn AnyModel> {
        self.model
    }

    /// The continuous states, as their fields have them.
    pub fn states(&mut self) -> impl Iterator<Item = f64> {
        self.layout.states(&mut *self.model)
    }

    /// Writes the fields of the continuous states.
    pub fn write_states(&mut self, values: &[f64]) {
        self.layout.write_states(&mut *self.model, values);
    }

    /// The values of the variables, and the layout.
    #[inline]
    pub fn view(&mut self) -> (&Layout, View<'_>) {
        // SAFETY: they are of one type.
        (&self.layout, unsafe { self.layout.view_unchecked(&mut *self.model) })
    }
}
