//! Directional derivatives in initialization mode: of outputs by parameters, and by inputs through the initial state.
//!
//! `InitialUnknowns` lists both. A model's own derivative cannot tell them, since it holds the state fixed; here the model is
//! initialized anew beside the instance for neighbouring values, and the differences are extrapolated.

use super::Slave;
use crate::difference::derivative;
use crate::layout::RealSlot;
use crate::model::Model;
use crate::status::Refusal;

impl<M: Model> Slave<M> {
    /// Derivatives of the unknowns along the seed.
    pub(super) fn initial_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<Vec<f64>, Refusal> {
        let layout = &self.layout;
        let reals = layout.reals.as_slice();
        let mut model = self.state.model.clone();
        // The same known may be named twice: the directions add up.
        let mut along: Vec<(&RealSlot<M>, u32, f64, f64)> = Vec::new();
        for (reference, value) in knowns.iter().zip(seed) {
            if let Some((.., slope)) = along.iter_mut().find(|(_, known, ..)| known == reference) {
                *slope += value;
            } else {
                let real = &reals[*reference as usize];
                along.push((real, *reference, *(real.lens)(&mut model), *value));
            }
        }
        along.retain(|(.., slope)| *slope != 0.0);
        if along.is_empty() || unknowns.is_empty() {
            return Ok(vec![0.0; unknowns.len()]);
        }
        let (mut below, mut above, mut scale) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        for (real, _, here, slope) in &along {
            let (down, up) = ((here - real.min) / slope.abs(), (real.max - here) / slope.abs());
            let (down, up) = if *slope > 0.0 { (down, up) } else { (up, down) };
            (below, above) = (below.min(down), above.min(up));
            scale = scale.min(self.size(real, *here) / slope.abs());
        }
        let wanted = unknowns.iter().fold(0, |wanted, reference| wanted | reals[*reference as usize].slot.evaluation);
        let experiment = self.state.experiment.unwrap_or_default();
        let initialize = self.initializer();
        let outputs = |s: f64| {
            let mut beside = model.clone();
            for (real, _, here, slope) in &along {
                *(real.lens)(&mut beside) = (here + s * slope).clamp(real.min, real.max);
            }
            initialize(&mut beside, &experiment).ok()?;
            layout.evaluate(wanted, &mut beside);
            let values: Vec<f64> =
                unknowns.iter().map(|reference| *(reals[*reference as usize].lens)(&mut beside)).collect();
            values.iter().all(|value| value.is_finite()).then_some(values)
        };
        derivative(outputs, below, above, scale).ok_or_else(|| {
            let names: Vec<&str> = along.iter().map(|(real, ..)| self.name(&real.slot)).collect();
            Refusal::error(format!(
                "nothing can be derived by {} here: there is no initial state for neighbouring values",
                names.join(", ")
            ))
        })
    }

    /// By how much a variable changes notably.
    fn size(&self, real: &RealSlot<M>, here: f64) -> f64 {
        let nominal = self.layout.variables[real.slot.variable as usize].nominal.map(f64::abs);
        if here.abs() > 1e-9 {
            here.abs().max(nominal.unwrap_or(0.0))
        } else {
            nominal.unwrap_or(1.0).min(real.max - real.min)
        }
    }
}
