//! Directional derivatives in initialization mode: of outputs by parameters, and by inputs through the initial state.
//!
//! `InitialUnknowns` lists both. A model's own derivative cannot tell them, since it holds the state fixed; here the model is
//! initialized anew beside the instance for neighbouring values, and the differences are extrapolated.

use super::Slave;
use crate::difference::derivative;
use crate::layout::RealSlot;
use crate::status::Refusal;

/// A known along which is derived.
struct Known<'l> {
    real: &'l RealSlot,
    reference: u32,
    here: f64,
    slope: f64,
}

impl Slave {
    /// Derivatives of the unknowns along the seed.
    pub(super) fn initial_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<Vec<f64>, Refusal> {
        let mut here = self.subject.copy();
        let reals = self.layout().reals.as_slice();
        // The same known may be named twice: the directions add up.
        let mut along: Vec<Known> = Vec::new();
        for (reference, value) in knowns.iter().zip(seed) {
            if let Some(known) = along.iter_mut().find(|known| known.reference == *reference) {
                known.slope += value;
            } else {
                let (real, here) = (&reals[*reference as usize], here.view().1.real(*reference));
                along.push(Known { real, reference: *reference, here, slope: *value });
            }
        }
        along.retain(|known| known.slope != 0.0);
        if along.is_empty() || unknowns.is_empty() {
            return Ok(vec![0.0; unknowns.len()]);
        }
        let (mut below, mut above, mut scale) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        for Known { real, here, slope, .. } in &along {
            let (down, up) = ((here - real.min) / slope.abs(), (real.max - here) / slope.abs());
            let (down, up) = if *slope > 0.0 { (down, up) } else { (up, down) };
            (below, above) = (below.min(down), above.min(up));
            scale = scale.min(self.size(real, *here) / slope.abs());
        }
        let wanted =
            unknowns.iter().fold(0, |wanted, reference| wanted | self.layout().evaluation(&reals[*reference as usize]));
        let experiment = self.frame.experiment.unwrap_or_default();
        let initialize = self.initializer();
        let outputs = |s: f64| {
            let mut beside = here.copy();
            let (_, mut view) = beside.view();
            for Known { real, reference, here, slope } in &along {
                view.set_real(*reference, (here + s * slope).clamp(real.min, real.max));
            }
            initialize(beside.model_mut(), &experiment).ok()?;
            let (_, mut view) = beside.view();
            view.evaluate(wanted);
            let values: Vec<f64> = unknowns.iter().map(|reference| view.real(*reference)).collect();
            values.iter().all(|value| value.is_finite()).then_some(values)
        };
        derivative(outputs, below, above, scale).ok_or_else(|| {
            let names: Vec<&str> = along.iter().map(|known| self.name(known.real)).collect();
            Refusal::error(format!(
                "nothing can be derived by {} here: there is no initial state for neighbouring values",
                names.join(", ")
            ))
        })
    }

    /// By how much a variable changes notably.
    fn size(&self, real: &RealSlot, here: f64) -> f64 {
        let nominal = self.layout().variables[real.variable as usize].nominal.map(f64::abs);
        if here.abs() > 1e-9 {
            here.abs().max(nominal.unwrap_or(0.0))
        } else {
            nominal.unwrap_or(1.0).min(real.max - real.min)
        }
    }
}
