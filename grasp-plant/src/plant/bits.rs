//! The same bits on every processor, from the parameters to the end of a run.

use super::Plant;
use crate::modal::Modal;
use crate::parameters::{ActuatorModel, Arm, ContactModel, Parameters};
use crate::propagator::Propagator;
use crate::signals::Inputs;
use grasp_kernel::narrowly;

const STEP: f64 = 1e-3;
const STEPS: usize = 200;

/// Plants that take every branch of the set-up: skew-symmetric and damped, equal and unequal arms, one panel of rows and
/// several.
fn plants() -> [Parameters; 6] {
    // No other test uses such plants, so none shares results that were computed in the other way.
    let default = Parameters { object_mass: 0.300_001, ..Parameters::default() };
    let conservative = Parameters { root_uncertainty: 0.0, tip_uncertainty: 0.0, ..default.clone() };
    let stiff = Arm { ei: 0.4, hub_inertia: 0.01, ..Arm::default() };
    [
        default.clone(),
        Parameters { order: 4, ..conservative.clone() },
        Parameters { order: 15, arms: [Arm::default(), stiff], ..conservative },
        Parameters { contact_model: ContactModel::Unilateral, ..default.clone() },
        Parameters { contact_model: ContactModel::Compliant, ..default.clone() },
        Parameters { order: 24, kelvin_voigt: 1e-3, actuator_model: ActuatorModel::Ideal, ..default },
    ]
}

/// Every number of the set-up, then of a run whose commands depend on measurements: strain feedback to a new angle.
fn numbers(parameters: &Parameters) -> Vec<u64> {
    let mut plant = Plant::new(parameters.clone()).unwrap();
    let model = plant.model.clone();
    let mut numbers: Vec<f64> =
        model.dynamics.system.iter().chain(model.dynamics.signal_rows.iter()).copied().collect();
    numbers.extend(model.extended.increment(STEP).iter());
    numbers.extend(Propagator::new(&model.extended, STEP).entries());
    let modal = Modal::new(&model.dynamics, parameters).unwrap();
    numbers.extend(modal.numbers());
    let mut table = modal.table();
    modal.fill(&mut table, STEP);
    numbers.extend(table.entries());
    let mut before = Inputs::ZERO;
    for step in 0..STEPS {
        let m = plant.measured();
        let torque = |i: usize| 0.6 * (0.1 - m.theta[i]) - 0.05 * m.theta_dot[i] + 0.5 * m.root_moment[i];
        let force = 2.0 * (0.02 - m.y_object) - 0.3 * m.y_object_dot + m.tip_shear[0] - m.tip_shear[1];
        let inputs = Inputs { torque_command: [torque(0), torque(1)], force_command: force, ..Inputs::ZERO };
        // Ramps use the other half of the step matrix; in every other step inputs are held.
        let rate = |now: f64, before: f64| if step % 2 == 0 { 0.0 } else { (now - before) / STEP };
        let rates = Inputs {
            torque_command: [0, 1].map(|i| rate(inputs.torque_command[i], before.torque_command[i])),
            force_command: rate(inputs.force_command, before.force_command),
            ..Inputs::ZERO
        };
        plant.step(STEP, &inputs, &rates).unwrap();
        before = inputs;
        let state = plant.state();
        numbers.extend(state.coordinates.iter().chain(&state.position).chain(&state.carry));
        numbers.extend([state.supplied_energy, plant.energy()]);
        numbers.extend(plant.deflection().as_flattened());
        numbers.extend(plant.constraint());
        numbers.extend(plant.contact().gap.iter().chain(&plant.contact().indentation).chain([&plant.contact().loss]));
    }
    numbers.into_iter().map(f64::to_bits).collect()
}

/// Set-up, step matrices and 200 steps in a loop are the same with and without wide registers (on processors that have none,
/// both runs are the same code).
#[test]
fn whole_runs_are_the_same_bits_without_wide_registers() {
    for parameters in plants() {
        let (chosen, narrow) = (numbers(&parameters), narrowly(|| numbers(&parameters)));
        let first = chosen.iter().zip(&narrow).position(|(chosen, narrow)| chosen != narrow);
        assert_eq!((chosen.len(), first), (narrow.len(), None), "order {}", parameters.order);
    }
}
