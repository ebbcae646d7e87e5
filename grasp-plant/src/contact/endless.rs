//! Rigid contacts that open and close without end.
//!
//! A rigid contact opens when its force f_i falls through zero. Then the built-in ΔF, which acts while both tips touch, ends, and with it the
//! part ΔF/m of the tip's acceleration. With Kelvin–Voigt damping S_i follows the tip's velocity, so ḟ_i jumps by as much as the damped beam
//! answers this: f_i may fall while the contact is closed and rise once it is open. Then the gap that opens closes at once,
//! and the contact has no next mode: it would have to slide along f_i = 0 with a part of ΔF, which is no mode of this model. Without damping
//! f_i answers a jump of the acceleration only in its second derivative, without ΔF nothing jumps, and a soft face's force does not depend on the
//! acceleration: such contacts switch finitely often.

use crate::parameters::{ContactModel, Parameters};

/// Whether contacts of these parameters can switch without end.
pub(super) fn may_not_end(parameters: &Parameters) -> bool {
    let rigid = parameters.contact_model == ContactModel::Unilateral;
    rigid && parameters.kelvin_voigt > 0.0 && parameters.tip_uncertainty > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Modes, SIGN};
    use crate::dynamics::FORCES;
    use crate::plant::Plant;
    use crate::signals::Inputs;
    use crate::state::StepError;

    /// Contact forces that both tips would have at x, pulling or not: −D⁻¹b of the complementarity problem.
    fn forces(modes: &Modes, x: &[f64]) -> [f64; 2] {
        let b = [0, 1].map(|i| {
            let shear: f64 = modes.shear.row(i).iter().zip(x).map(|(row, x)| row * x).sum();
            -SIGN[i] * shear / modes.tip_masses[i]
        });
        let ([d_1, d_2], coupling) = (modes.delassus.diagonal, 1.0 / modes.object_mass);
        let determinant = d_1 * d_2 - coupling * coupling;
        [-(d_2 * b[0] + coupling * b[1]) / determinant, -(coupling * b[0] + d_1 * b[1]) / determinant]
    }

    /// Where steps are refused, one tip's force is zero, falls while it touches, and rises while it does not.
    #[test]
    fn a_contact_without_a_next_mode_is_what_is_refused() {
        for order in [8, 12] {
            let parameters = Parameters {
                order,
                kelvin_voigt: 1e-5,
                contact_model: ContactModel::Unilateral,
                ..Parameters::default()
            };
            let mut plant = Plant::new(parameters.clone()).unwrap();
            let torque = [0.5, 0.0, 0.0];
            let inputs = Inputs { hub_disturbance: [torque[0], torque[1]], ..Inputs::ZERO };
            // Ever closer to the moment from which on there is no next mode: the state before the last step that is refused.
            let (mut h, mut before) = (1e-3, None);
            for _ in 0..60 {
                match plant.step(h, &inputs, &Inputs::ZERO) {
                    Ok(()) => {}
                    Err(StepError::Endless { .. }) => {
                        before = Some(plant.state().clone());
                        h *= 0.5;
                    }
                    Err(other) => panic!("{other}"),
                }
            }
            let before = before.expect("a refused step");
            let modes = Modes::new(&parameters, [1.0; 2]);
            let x = &before.coordinates[..];
            let size = forces(&modes, x).map(f64::abs);
            let side = usize::from(size[1] < size[0]);
            let rate = |touching: [bool; 2]| {
                let rates = modes.rates(touching, x, &torque[..FORCES]);
                forces(&modes, &rates.as_flattened()[..modes.layout.size()])[side]
            };
            let mut open = [true; 2];
            open[side] = false;
            let (closed, open) = (rate([true; 2]), rate(open));
            // The refused step, 2h long, begins just before the force is zero.
            assert!(size[side] < 2.0 * h * closed.abs(), "order {order}: {size:?}");
            assert!(closed < 0.0 && open > 0.0, "order {order}: {closed} {open}");
        }
    }
}
