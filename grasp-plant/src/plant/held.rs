//! The step that most steps are: in modal coordinates, of a size that is kept, with held inputs.

use super::Plant;
use crate::cache::Cache;
use crate::dynamics::FORCES;
use crate::kernel::dot;
use crate::modal::{Table, Travel, USABLE};
use crate::signals::Inputs;
use crate::state::{Basis, State, travelled};
use crate::step_sizes::StepSizes;

impl Plant {
    /// Makes such a step; false if it is none, or is to be refused. Nothing has changed then, and [`Self::any_step`] makes the step,
    /// to the same bits, or knows the reason.
    #[inline]
    pub(super) fn held_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> bool {
        let Self { model, state, signals, cache, .. } = self;
        // A grasp that can open is never in modal coordinates.
        if !((state.basis == Basis::Modal) & rates.is_zero()) {
            return false;
        }
        let noted = if cache.tables.last(h).is_some() && state.sizes.is_usual(h) {
            None
        } else if let Some(sizes) = another_size(&mut cache.tables, &state.sizes, h) {
            Some(sizes)
        } else {
            return false;
        };
        // A size that has a table is positive and not too long.
        let (Some(table), Some(modal)) = (cache.tables.last(h), model.modal()) else { return false };
        let (forces, length) = (model.forces(inputs), model.parameters.length);
        let moves = |state: &State, travel: &Travel| {
            let (moved, _) = travel.of_forces(length);
            let energy = state.supplied_energy + dot(&forces, &moved);
            let (there, rest) = travelled(&state.position, &state.carry, &moved);
            // Infinity and NaN persist in sums of sizes. Of commands, an actuator may hide them.
            let size = |values: [f64; FORCES]| values[0].abs() + values[1].abs() + values[2].abs();
            let usable = (size(there) + size(inputs.disturbances()) < USABLE)
                & (size(inputs.commands()) + energy.abs() < f64::INFINITY);
            usable.then_some((there, rest, energy))
        };
        modal.hold(table, &forces, state, moves, |state, (there, rest, energy), found| {
            (state.position, state.carry, state.supplied_energy, *signals) = (there, rest, energy, found);
            if let Some(noted) = noted {
                state.sizes = noted;
            }
        })
    }
}

/// Makes the table of a size that is not that of the step before the last, if it is kept; the step sizes with this one.
#[inline(never)]
fn another_size(tables: &mut Cache<Table>, sizes: &StepSizes, h: f64) -> Option<StepSizes> {
    let mut noted = *sizes;
    noted.note(h);
    (noted.repeat() && tables.recall(h)).then_some(noted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{ActuatorModel, Parameters};

    /// Everything that a step changes, in bits.
    fn bits(plant: &Plant) -> Vec<u64> {
        let State { coordinates, position, carry, supplied_energy, .. } = &plant.state;
        let numbers = coordinates.iter().chain(position).chain(carry).chain([supplied_energy]).chain(&plant.signals);
        numbers.map(|number| number.to_bits()).collect()
    }

    /// The usual step and the general one are the same, of whole and of incomplete groups of modes; other step sizes between them.
    #[test]
    fn the_usual_step_has_the_bits_of_any_step() {
        for (order, actuator_model) in [
            (4, ActuatorModel::Raw),
            (8, ActuatorModel::Compensated),
            (13, ActuatorModel::Ideal),
            (24, ActuatorModel::Raw),
        ] {
            let mut usual = Plant::new(Parameters { actuator_model, order, ..Parameters::default() }).unwrap();
            let mut any = usual.clone();
            let mut held = 0;
            for i in 0..300_u32 {
                let of = |scale: f64| scale * f64::from(i * i % 17) - 4.0 * scale;
                let inputs = Inputs {
                    torque_command: [of(0.3), of(-0.2)],
                    force_command: of(0.05),
                    hub_disturbance: [of(0.01), 0.0],
                    object_disturbance: of(0.02),
                };
                let h = [1e-4, 2e-4, 1e-4, 1e-4, 3e-4][i as usize % 5];
                // A negative zero is no ramp either.
                let rates = Inputs { force_command: -0.0, ..Inputs::ZERO };
                held += u32::from(usual.held_step(h, &inputs, &rates) || usual.any_step(h, &inputs, &rates).is_err());
                any.any_step(h, &inputs, &rates).unwrap();
                assert_eq!(bits(&usual), bits(&any), "order {order}, step {i}");
                assert_eq!(usual.state.sizes, any.state.sizes, "order {order}, step {i}");
            }
            // All but the first of each size.
            assert_eq!(held, 297);
        }
    }

    /// What would leave the range of numbers, or is none, is refused for the general step's reason, and nothing has changed.
    #[test]
    fn what_is_not_usable_is_refused_as_in_any_step() {
        let start = {
            let ideal = Parameters { actuator_model: ActuatorModel::Ideal, ..Parameters::default() };
            let mut plant = Plant::new(ideal).unwrap();
            let inputs = Inputs { torque_command: [0.1, -0.1], ..Inputs::ZERO };
            for _ in 0..3 {
                plant.step(1e-4, &inputs, &Inputs::ZERO).unwrap();
            }
            plant
        };
        for value in [f64::NAN, f64::INFINITY, -1e150, 1e300] {
            for place in 0..6 {
                let mut values = [0.0; 6];
                values[place] = value;
                let [a, b, force_command, c, d, object_disturbance] = values;
                let inputs =
                    Inputs { torque_command: [a, b], force_command, hub_disturbance: [c, d], object_disturbance };
                let (mut usual, mut any) = (start.clone(), start.clone());
                assert!(!usual.held_step(1e-4, &inputs, &Inputs::ZERO), "{value} at {place}");
                assert_eq!(bits(&usual), bits(&start), "{value} at {place}");
                let found = usual.step(1e-4, &inputs, &Inputs::ZERO).map_err(|error| error.to_string());
                let expected = any.any_step(1e-4, &inputs, &Inputs::ZERO).map_err(|error| error.to_string());
                assert_eq!((found, bits(&usual)), (expected, bits(&any)), "{value} at {place}");
            }
        }
    }

    /// What is known of the grip after a step are the contact forces, to rounding.
    #[test]
    fn a_grip_is_the_contact_forces() {
        let parameters = Parameters { kelvin_voigt: 1e-3, ..Parameters::default() };
        let mut plant = Plant::new(parameters).unwrap();
        for i in 0..100 {
            let inputs = Inputs {
                torque_command: [0.5, -0.1 * f64::from(i % 5)],
                force_command: 0.01 * f64::from(i % 7),
                object_disturbance: 0.2,
                ..Inputs::ZERO
            };
            plant.step(1e-3, &inputs, &Inputs::ZERO).unwrap();
            let force = plant.contact_force(&inputs);
            let grip = plant.model.grip(&plant.signals, plant.direct(&inputs).force + inputs.object_disturbance);
            for (grip, force) in grip.iter().zip(force) {
                // Differences of shears of some newtons.
                assert!((grip - force).abs() < 1e-13, "{grip} {force}");
            }
            assert_eq!(plant.may_pull(&inputs), force.iter().any(|force| *force < 0.0));
        }
    }
}
