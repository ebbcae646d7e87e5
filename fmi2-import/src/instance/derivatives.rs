//! Derivatives of inputs and outputs, over time and by other variables.

use super::{Instance, Result};
use crate::floating_point::guarded;
use crate::library::{Status, ValueReference};

impl Instance {
    /// `fmi2GetDirectionalDerivative`: d`unknowns` = (∂unknowns/∂knowns) · `seed`.
    ///
    /// # Errors
    /// When the slave cannot.
    ///
    /// # Panics
    /// When matching slices differ in length.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[ValueReference],
        knowns: &[ValueReference],
        seed: &[f64],
        derivative: &mut [f64],
    ) -> Result<Status> {
        assert_eq!((unknowns.len(), knowns.len()), (derivative.len(), seed.len()));
        let function =
            self.optional("fmi2GetDirectionalDerivative", self.functions().get_directional_derivative, |interface| {
                interface.provides_directional_derivative
            })?;
        // SAFETY: living component, arrays of the stated lengths.
        let status = guarded(|| unsafe {
            function(
                self.component.as_ptr(),
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                derivative.as_mut_ptr(),
            )
        });
        self.check("fmi2GetDirectionalDerivative", status)
    }

    /// `fmi2SetRealInputDerivatives`: the derivatives of inputs during the next step.
    ///
    /// # Errors
    /// When the slave cannot.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn set_input_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[i32],
        values: &[f64],
    ) -> Result<Status> {
        assert_eq!((references.len(), references.len()), (orders.len(), values.len()));
        let function =
            self.optional("fmi2SetRealInputDerivatives", self.functions().set_real_input_derivatives, |interface| {
                interface.can_interpolate_inputs
            })?;
        // SAFETY: living component, arrays of the stated length.
        let status = guarded(|| unsafe {
            function(self.component.as_ptr(), references.as_ptr(), references.len(), orders.as_ptr(), values.as_ptr())
        });
        self.check("fmi2SetRealInputDerivatives", status)
    }

    /// `fmi2GetRealOutputDerivatives`: the derivatives of outputs at the end of the last step.
    ///
    /// # Errors
    /// When the slave cannot.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn output_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<Status> {
        assert_eq!((references.len(), references.len()), (orders.len(), values.len()));
        let highest = orders.iter().copied().max().map_or(0, i32::unsigned_abs);
        let function =
            self.optional("fmi2GetRealOutputDerivatives", self.functions().get_real_output_derivatives, |interface| {
                interface.max_output_derivative_order >= highest
            })?;
        // SAFETY: living component, arrays of the stated length.
        let status = guarded(|| unsafe {
            function(
                self.component.as_ptr(),
                references.as_ptr(),
                references.len(),
                orders.as_ptr(),
                values.as_mut_ptr(),
            )
        });
        self.check("fmi2GetRealOutputDerivatives", status)
    }
}
