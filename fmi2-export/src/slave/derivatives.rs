//! Derivatives: of inputs and outputs by time, of outputs and of the states' time derivatives by inputs and states.

use super::{Slave, out_of_range};
use crate::out::Out;
use crate::phase::{Call, Phase};
use crate::status::{Outcome, Refusal};
use crate::variable::{Causality, Variable};

impl Slave {
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome {
        self.check_co_simulation(Call::Set, "fmi2SetRealInputDerivatives")?;
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            let real = self.real(*reference)?;
            let (name, variable) = (self.name(real), &self.layout().variables[real.variable as usize]);
            if variable.ramp.is_none() {
                return Err(Refusal::error(format!("{name} takes no derivatives")));
            }
            if *order != 1 {
                return Err(Refusal::error(format!("derivative of order {order} of {name}: only order 1 is taken")));
            }
            if !value.is_finite() {
                return Err(out_of_range(name, *value, f64::NEG_INFINITY, f64::INFINITY));
            }
        }
        let (_, mut view) = self.subject.view();
        for (reference, value) in references.iter().zip(values) {
            if let Some(ramp) = view.ramp(*reference) {
                *ramp = *value;
            }
        }
        self.frame.ramped |= !references.is_empty();
        // The time derivatives of outputs that depend on inputs depend on the inputs' slopes.
        self.frame.stale |= self.layout().input_dependent;
        Ok(())
    }

    pub fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: Out<'_, f64>) -> Outcome {
        self.check_co_simulation(Call::GetOutputDerivatives, "fmi2GetRealOutputDerivatives")?;
        let mut wanted = 0;
        for (reference, order) in references.iter().zip(orders) {
            let real = self.real(*reference)?;
            if *order < 1 {
                let name = self.name(real);
                return Err(Refusal::error(format!(
                    "derivative of order {order} of {name}: the order must be 1 or more"
                )));
            }
            if let Some((_, evaluation)) = &self.layout().variables[real.variable as usize].rate {
                wanted |= 1 << evaluation.0;
            } else {
                return Err(Refusal::error(format!("{} provides no derivative", self.name(real))));
            }
        }
        self.evaluate(wanted)?;
        let (_, mut view) = self.subject.view();
        values.write(references.iter().zip(orders).map(|(reference, order)| {
            // "If the actual order is lower, the retrieved value is 0."
            if *order == 1 { view.rate(*reference).unwrap_or(0.0) } else { 0.0 }
        }));
        Ok(())
    }

    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        values: Out<'_, f64>,
    ) -> Outcome {
        self.check(Call::Get, "fmi2GetDirectionalDerivative")?;
        if !self.layout().info.directional_derivatives {
            return Err(Refusal::error("this model provides no directional derivatives"));
        }
        // Whether states are involved, as knowns or by their time derivatives.
        let mut of_states = false;
        for reference in unknowns {
            let slot = self.real(*reference)?;
            let variable = &self.layout().variables[slot.variable as usize];
            let is_initial_state = variable.is_state && self.frame.phase == Phase::Initialization;
            of_states |= variable.derivative_of.is_some();
            if !slot.has(Causality::Output) && variable.derivative_of.is_none() && !is_initial_state {
                return Err(Refusal::error(format!("{} is no output: it has no derivative", self.name(slot))));
            }
        }
        for (reference, value) in knowns.iter().zip(seed) {
            let slot = self.real(*reference)?;
            let Variable { causality, is_state, .. } = &self.layout().variables[slot.variable as usize];
            let is_state = *is_state;
            of_states |= is_state;
            match (causality, self.frame.phase) {
                (Causality::Input, _) | (Causality::Parameter, Phase::Initialization) => {}
                (Causality::Parameter, _) => {
                    let hint = "is no input: outputs are derived by parameters in initialization mode only";
                    return Err(Refusal::error(format!("{} {hint}", self.name(slot))));
                }
                (Causality::Output | Causality::Local, Phase::Initialization) if is_state => {
                    let hint = "is a state, which is computed in initialization mode: nothing is derived by it then";
                    return Err(Refusal::error(format!("{} {hint}", self.name(slot))));
                }
                (Causality::Output | Causality::Local, _) if is_state => {}
                _ => return Err(Refusal::error(format!("{} is no input: nothing is derived by it", self.name(slot)))),
            }
            if !value.is_finite() {
                return Err(out_of_range(self.name(slot), *value, f64::NEG_INFINITY, f64::INFINITY));
            }
        }
        if self.frame.phase == Phase::Error {
            values.write(unknowns.iter().map(|_| 0.0));
            return Ok(());
        }
        if self.frame.phase == Phase::Initialization {
            // Of copies: the instance itself is not even initialized for it.
            values.write(self.initial_derivative(unknowns, knowns, seed)?);
            return Ok(());
        }
        let (layout, model) = self.subject.parts();
        let direction = self.direction.get_or_insert_with(|| model.fresh());
        let mut along = layout.view(&mut **direction);
        for (reference, real) in (0..).zip(&layout.reals) {
            if !real.has(Causality::Parameter) {
                along.set_real(reference, 0.0);
            }
        }
        // The same input may be named twice: the directions add up.
        for (reference, value) in knowns.iter().zip(seed) {
            let sum = along.real(*reference) + value;
            along.set_real(*reference, sum);
        }
        match &layout.continuous {
            Some(continuous) if of_states => {
                // What the model computed for its states may be what the derivative is taken of.
                let needed = continuous.derivative_evaluations & self.frame.stale;
                self.frame.stale &= !needed;
                layout.view(model).evaluate(needed);
                (continuous.exchange.jacobian_product)(model, &mut **direction);
            }
            _ => model.directional_derivative(&mut **direction),
        }
        let mut along = layout.view(&mut **direction);
        values.write(unknowns.iter().map(|reference| along.real(*reference)));
        Ok(())
    }
}
