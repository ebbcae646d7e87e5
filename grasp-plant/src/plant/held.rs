//! The step that most steps are: in modal coordinates, of a size that is kept, with held inputs.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::Plant;
#[cfg(target_arch = "x86_64")]
use crate::modal::Wide;
use crate::modal::{BUDGET, CALM, Four, Lanes, Table};
use crate::signals::Inputs;
use crate::state::{Basis, State};

/// A command and the disturbance beside it may have this size together: then all inputs are below [`CALM`] together.
const CALM_INPUT: f64 = CALM / 4.0;

impl Plant {
    /// Makes such a step; false if it is none, or may have to be refused. Nothing has changed then, and [`Self::any_step`] makes the step,
    /// to the same bits, or knows the reason why not.
    #[inline]
    pub(super) fn held_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> bool {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.held_step_wide(h, inputs, rates) };
        }
        self.held_step_narrow::<Lanes>(h, inputs, rates)
    }

    // Out of the way of processors with wide registers; generic, or it would be compiled with this crate, for size.
    #[inline(never)]
    fn held_step_narrow<V: Four>(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> bool {
        self.held_step_here::<V>(h, inputs, rates)
    }

    // Inlined, or it would be compiled with this crate, for size.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    #[target_feature(enable = "avx2")]
    fn held_step_wide(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> bool {
        self.held_step_here::<Wide>(h, inputs, rates)
    }

    #[inline(always)]
    fn held_step_here<V: Four>(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> bool {
        if !V::are_zeros(rates.numbers()) {
            return false;
        }
        // While a state is calm, it is modal, and the last step was a usual one of the last table.
        if self.cache.tables.last(h).is_none_or(|table| self.calm < table.calm_cost()) && !self.look(h, inputs) {
            return false;
        }
        let [commands, disturbances] = inputs.fresh_lanes().each_ref().map(V::load);
        // Infinity and NaN are not below. Of commands, an actuator may hide them.
        if !commands.are_sizes_below(disturbances, CALM_INPUT) {
            return false;
        }
        let Self { model, state, signals, cache, calm, pulls, limited, .. } = self;
        let (Some(table), Some(modal)) = (cache.tables.newest(), model.modal()) else { return false };
        let forces = model.forces_in_lanes(commands, disturbances);
        let Some(of_tips) = modal.hold(table, forces, state, signals) else { return false };
        *pulls = model.pulls(of_tips, forces.lanes()[2]);
        *limited = model.is_any_limited(commands);
        *calm -= table.calm_cost();
        true
    }

    /// Looks at the state and the step size before such a step is made. False if it is none, or may have to be refused; nothing has changed
    /// then but which table is the last.
    #[inline(never)]
    fn look(&mut self, h: f64, inputs: &Inputs) -> bool {
        let [commands, disturbances] = inputs.fresh_lanes();
        if !commands.are_sizes_below(disturbances, CALM_INPUT) {
            return false;
        }
        let Self { state, cache, calm, .. } = self;
        let is_another = *calm == 0 || cache.tables.last(h).is_none();
        let mut sizes = state.sizes;
        if is_another {
            sizes.note(h);
            // A size that has a table is positive and not too long. A grasp that can open is never in modal coordinates.
            if !(state.basis != Basis::Energy && sizes.repeat() && cache.tables.recall(h)) {
                return false;
            }
        }
        let Some(cost) = cache.tables.last(h).map(Table::calm_cost) else { return false };
        let budget = if *calm < cost { budget(state) } else { *calm };
        if budget < cost {
            return false;
        }
        // After a size that is new, the next step is another one too: to repeat a size is noted.
        (state.sizes, *calm) = (sizes, if sizes.is_usual(h) { budget } else { cost });
        true
    }
}

/// What steps may cost together until something that has to be refused can come of a state.
fn budget(state: &State) -> u32 {
    let State { coordinates, position, carry, supplied_energy, .. } = state;
    let numbers = coordinates.iter().chain(position).chain(carry).chain([supplied_energy]);
    // NaN persists in a sum.
    if numbers.map(|number| number.abs()).sum::<f64>() < CALM { BUDGET } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::super::Model;
    use super::*;
    use crate::parameters::{ActuatorModel, Parameters};

    /// Everything that a step changes, in bits.
    fn bits(plant: &Plant) -> Vec<u64> {
        let State { coordinates, position, carry, supplied_energy, .. } = &plant.state;
        let numbers = coordinates.iter().chain(position).chain(carry).chain([supplied_energy]).chain(&plant.signals);
        numbers.map(|number| number.to_bits()).collect()
    }

    /// The usual step and the general one are the same, of whole and of incomplete groups of modes, of equal arms and of others; other step
    /// sizes between them.
    #[test]
    fn the_usual_step_has_the_bits_of_any_step() {
        for (order, actuator_model, stiffer) in [
            (4, ActuatorModel::Raw, 1.0),
            (4, ActuatorModel::Raw, 1.5),
            (6, ActuatorModel::Ideal, 1.0),
            (8, ActuatorModel::Compensated, 1.0),
            (8, ActuatorModel::Compensated, 0.8),
            (13, ActuatorModel::Ideal, 1.0),
            (13, ActuatorModel::Ideal, 2.0),
            (21, ActuatorModel::Compensated, 1.0),
            (24, ActuatorModel::Raw, 1.0),
            (24, ActuatorModel::Raw, 1.1),
        ] {
            let mut parameters = Parameters { actuator_model, order, ..Parameters::default() };
            parameters.arms[1].ei *= stiffer;
            let mut usual = Plant::new(parameters).unwrap();
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
                assert_eq!(bits(&usual), bits(&any), "order {order}, {stiffer}, step {i}");
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

    /// A step that was refused leaves no trace: the sizes of later steps are noted as without it.
    #[test]
    fn a_refused_step_of_another_size_leaves_no_trace() {
        let inputs = Inputs { force_command: 0.1, ..Inputs::ZERO };
        let mut plain = Plant::new(Parameters::default()).unwrap();
        for _ in 0..3 {
            plain.step(1e-4, &inputs, &Inputs::ZERO).unwrap();
        }
        let mut refused = plain.clone();
        let rates = Inputs { object_disturbance: 1e200, ..Inputs::ZERO };
        assert_eq!(refused.step(2e-4, &inputs, &rates), Err(crate::StepError::Overflow));
        for plant in [&mut plain, &mut refused] {
            plant.step(2e-4, &inputs, &Inputs::ZERO).unwrap();
        }
        assert_eq!(bits(&plain), bits(&refused));
        assert_eq!(plain.state, refused.state);
    }

    /// A few long steps of a plant, usual ones and general ones.
    fn compare(mut usual: Plant, inputs: impl Fn(u32) -> Inputs, steps: u32) -> (u32, u32) {
        let mut any = usual.clone();
        let (mut held, mut refused) = (0, 0);
        for i in 0..steps {
            let inputs = inputs(i);
            held += u32::from(usual.clone().held_step(1e-3, &inputs, &Inputs::ZERO));
            let found = usual.step(1e-3, &inputs, &Inputs::ZERO);
            assert_eq!(found, any.any_step(1e-3, &inputs, &Inputs::ZERO), "step {i}");
            assert_eq!(bits(&usual), bits(&any), "step {i}");
            refused += u32::from(found.is_err());
        }
        (held, refused)
    }

    /// Numbers that die away become zero in the same step, whole and incomplete groups of modes.
    #[test]
    fn small_numbers_vanish_as_in_any_step() {
        for order in [8, 9] {
            let mut plant = Plant::new(Parameters { order, ..Parameters::default() }).unwrap();
            for push in [1e-141, 0.0, 0.0] {
                plant
                    .step(1e-3, &Inputs { torque_command: [push, 0.3 * push], ..Inputs::ZERO }, &Inputs::ZERO)
                    .unwrap();
            }
            let (held, refused) = compare(plant.clone(), |_| Inputs::ZERO, 400);
            assert_eq!((held, refused), (400, 0));
            for _ in 0..3000 {
                plant.step(1e-3, &Inputs::ZERO, &Inputs::ZERO).unwrap();
            }
            let zeros = plant.state.coordinates.iter().filter(|z| **z == 0.0).count();
            assert!(zeros > order, "{zeros} zeros");
        }
    }

    /// A motion that grows out of the range of numbers is refused in the same step.
    #[test]
    fn a_motion_that_leaves_the_range_of_numbers_is_refused_as_in_any_step() {
        let mut plant =
            Plant::new(Parameters { actuator_model: ActuatorModel::Ideal, ..Parameters::default() }).unwrap();
        for _ in 0..3 {
            plant.step(1e-3, &Inputs { object_disturbance: 0.1, ..Inputs::ZERO }, &Inputs::ZERO).unwrap();
        }
        let growing = |i: u32| Inputs { object_disturbance: 10f64.powi(i32::try_from(i).unwrap()), ..Inputs::ZERO };
        let (held, refused) = compare(plant, growing, 120);
        // The inputs are calm up to 1e39; the energy, which grows by 100 in a step, makes a look at the state fail from 1e40 on. Above 1e100
        // nothing is usable.
        assert!((18..=40).contains(&held), "{held}");
        assert!((10..25).contains(&refused), "{refused}");
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
            assert_eq!(plant.may_have_pulled(), plant.may_pull(&inputs));
            assert_eq!(plant.may_pull(&inputs), force.iter().any(|force| *force < 0.0));
            let of_tips = Model::of_tips(&plant.signals);
            let on_object = plant.direct(&inputs).force + inputs.object_disturbance;
            for (grip, force) in plant.model.grip(of_tips, on_object).iter().zip(force) {
                // Differences of shears of some newtons.
                assert!((grip - force).abs() < 1e-13, "{grip} {force}");
            }
        }
    }
}
