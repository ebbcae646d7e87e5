//! The change of basis that separates the rigid motion.

use crate::kernel::dot;
use nalgebra::DVector;

/// A Householder reflection v ↦ v − 2 u (u·v)/(u·u): symmetric, orthogonal, its own inverse.
#[derive(Clone, Debug)]
pub(super) struct Reflection {
    axis: DVector<f64>,
    factor: f64,
}

impl Reflection {
    /// The reflection that takes `direction` (its last entry positive) to the negative last axis.
    pub fn onto_last(direction: DVector<f64>) -> Self {
        let mut axis = direction;
        let norm = dot(axis.as_slice(), axis.as_slice()).sqrt();
        if let Some(last) = axis.as_mut_slice().last_mut() {
            *last += norm;
        }
        let factor = 2.0 / dot(axis.as_slice(), axis.as_slice());
        Self { axis, factor }
    }

    /// Reflects `vector`, in place.
    pub fn apply(&self, vector: &mut [f64]) {
        let amount = self.factor * dot(self.axis.as_slice(), vector);
        for (entry, axis) in vector.iter_mut().zip(&self.axis) {
            *entry -= amount * axis;
        }
    }
}
