//! The plant for a host that integrates: the states of [`grasp_plant`] as variables, and what follows from them.

use fmi2_export::{Completed, Evaluation, EventUpdate, Experiment, Failure, Model, ModelExchange, Moment, Variables};
use grasp_plant::{ORDER_RANGE, Plant};

use super::DualArmPlant;

/// The order at which the plant has its continuous states. FMI 2.0 fixes their number when an FMU is packaged; the packaging
/// program can be told another one.
pub const ORDER: usize = packaged_order(option_env!("DUALARM_PLANT_ORDER"));
/// Energy coordinates x.
const COORDINATES: usize = 4 * ORDER + 1;
/// The place of the supplied energy, after the object's position.
const SUPPLIED_ENERGY: usize = COORDINATES + 1;
/// Where what only a grasp that can open has begins: both clearances, their rates, the faces' deformations, the energy lost. In one
/// that cannot they are zero and stay so: an FMU has one number of states for all contact models.
const CONTACT: usize = SUPPLIED_ENERGY + 1;
const STATES: usize = CONTACT + Plant::CONTACT_STATES;
/// The most states at any order.
const MOST_STATES: usize = 4 * *ORDER_RANGE.end() + 3 + Plant::CONTACT_STATES;

const _: () = assert!(
    *ORDER_RANGE.start() <= ORDER && ORDER <= *ORDER_RANGE.end(),
    "DUALARM_PLANT_ORDER is no order that the plant can have"
);

/// The order that was asked for, or 8.
const fn packaged_order(text: Option<&str>) -> usize {
    let Some(text) = text else { return 8 };
    let (digits, mut order, mut i) = (text.as_bytes(), 0, 0);
    while i < digits.len() {
        assert!(digits[i].is_ascii_digit() && i < 3, "DUALARM_PLANT_ORDER must be a whole number");
        order = 10 * order + (digits[i] - b'0') as usize;
        i += 1;
    }
    order
}

/// What only a host that integrates looks at.
#[derive(Clone)]
pub(super) struct Continuous {
    coordinates: [f64; COORDINATES],
    clearance: [f64; 2],
    opening: [f64; 2],
    rates: [f64; STATES],
    indicators: [f64; Plant::EVENT_INDICATORS],
}

impl Default for Continuous {
    fn default() -> Self {
        Self {
            coordinates: [0.0; COORDINATES],
            clearance: [0.0; 2],
            opening: [0.0; 2],
            rates: [0.0; STATES],
            indicators: [0.0; Plant::EVENT_INDICATORS],
        }
    }
}

impl DualArmPlant {
    fn continuous(&mut self) -> &mut Continuous {
        self.continuous.get_or_insert_default()
    }

    /// The plant, if it has the FMU's states: in co-simulation the order is free.
    fn with_states(&self) -> Option<&Plant> {
        self.plant.as_ref().filter(|plant| plant.parameters().order == ORDER)
    }

    fn coordinates(&mut self) {
        let mut states = [0.0; MOST_STATES];
        let (mut coordinates, mut contact) = ([0.0; COORDINATES], [0.0; 4]);
        if let Some(plant) = &self.plant {
            let states = &mut states[..plant.state_count()];
            plant.continuous_states(states);
            if plant.parameters().order == ORDER {
                coordinates.copy_from_slice(&states[..COORDINATES]);
            }
            if plant.can_open() {
                // At any order.
                let first = states.len() - Plant::CONTACT_STATES;
                contact.copy_from_slice(&states[first..first + 4]);
            }
        }
        let continuous = self.continuous();
        continuous.coordinates = coordinates;
        let [clearance1, clearance2, opening1, opening2] = contact;
        (continuous.clearance, continuous.opening) = ([clearance1, clearance2], [opening1, opening2]);
    }

    fn state_rates(&mut self) {
        let mut rates = [0.0; STATES];
        if let Some(plant) = self.with_states() {
            plant.derivatives(&self.inputs, &mut rates[..plant.state_count()]);
        }
        self.continuous().rates = rates;
    }

    fn indicators(&mut self) {
        let mut indicators = [1.0; Plant::EVENT_INDICATORS];
        if let Some(plant) = &self.plant {
            plant.event_indicators(&self.inputs, &mut indicators);
        }
        self.continuous().indicators = indicators;
    }

    /// The states as the fields of this model have them: values, or a direction.
    fn states(&mut self) -> [f64; STATES] {
        let continuous = self.continuous.get_or_insert_default();
        let mut states = [0.0; STATES];
        let (coordinates, others) = states.split_at_mut(COORDINATES);
        coordinates.copy_from_slice(&continuous.coordinates);
        let (of_grasp, of_contact) = others.split_at_mut(CONTACT - COORDINATES);
        of_grasp.copy_from_slice(&[self.outputs.measured.y_object, self.outputs.shape.supplied_energy]);
        let pairs = [continuous.clearance, continuous.opening, self.outputs.contact.indentation];
        let (pairs_of_states, loss) = of_contact.split_at_mut(6);
        pairs_of_states.copy_from_slice(pairs.as_flattened());
        loss[0] = self.outputs.contact.loss;
        states
    }
}

/// The energy coordinates and what of the contacts is no output, and the time derivatives of all states. Other states are outputs, and
/// declared there.
pub(super) fn declare(variables: &mut Variables<DualArmPlant>) -> Evaluations {
    let coordinates = variables.evaluation(DualArmPlant::coordinates);
    let rates = variables.evaluation(DualArmPlant::state_rates);
    let indicators = variables.evaluation(DualArmPlant::indicators);
    let rows = Plant::state_variables(ORDER);
    variables.states(
        &rows[..COORDINATES],
        coordinates,
        |m| &mut m.continuous().coordinates,
        rates,
        |m| &mut m.continuous().rates[..COORDINATES],
    );
    // The position's is an output.
    variables
        .local("der(supplied_energy)", rates, |m| &mut m.continuous().rates[SUPPLIED_ENERGY])
        .derivative_of("supplied_energy")
        .unit("W")
        .description("Power of the actuators and the external disturbances");
    variables.event_indicators(indicators, |m| &mut m.continuous().indicators);
    Evaluations { coordinates, rates }
}

/// What fills in states and their time derivatives.
pub(super) struct Evaluations {
    coordinates: Evaluation,
    rates: Evaluation,
}

/// The states that only a grasp that can open has, but for those that are outputs.
pub(super) fn declare_contact(variables: &mut Variables<DualArmPlant>, evaluations: &Evaluations) {
    let Evaluations { coordinates, rates } = *evaluations;
    variables
        .local_array("clearance{}", coordinates, |m| &mut m.continuous().clearance)
        .state()
        .unit("m")
        .nominal(0.01)
        .description(
            "Distance of tip {} from the object's undeformed face, negative by as much as it is pressed in; zero with \
             contact_model = bilateral",
        );
    variables
        .local_array("clearance{}_dot", coordinates, |m| &mut m.continuous().opening)
        .state()
        .derivative_of("clearance{}")
        .depends_on_states(["clearance{}_dot"])
        .unit("m/s")
        .nominal(0.1)
        .description("Rate of clearance{}: all that an impact on a rigid face changes at once");
    variables
        .local_array("der(clearance{}_dot)", rates, |m| &mut m.continuous().rates[CONTACT + 2..CONTACT + 4])
        .derivative_of("clearance{}_dot")
        .unit("m/s2")
        .description("Time derivative of clearance{}_dot");
    variables
        .local_array("der(indentation{})", rates, |m| &mut m.continuous().rates[CONTACT + 4..CONTACT + 6])
        .derivative_of("indentation{}")
        .depends_on_states(["clearance{}_dot", "indentation{}"])
        .unit("m/s")
        .description("Time derivative of indentation{}");
    variables
        .local("der(impact_loss)", rates, |m| &mut m.continuous().rates[CONTACT + 6])
        .derivative_of("impact_loss")
        .depends_on_states(["clearance1_dot", "clearance2_dot", "indentation1", "indentation2"])
        .unit("W")
        .description("Power that the object's faces take");
}

/// Names of the energy coordinates.
pub(super) fn coordinate_names() -> Vec<String> {
    Plant::state_variables(ORDER).into_iter().take(COORDINATES).map(|row| row.name).collect()
}

impl ModelExchange for DualArmPlant {
    const COMPLETES_STEPS: bool = true;

    fn initialize_exchange(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        let order = self.parameters.order;
        if order != ORDER {
            return Err(Failure::error(format!(
                "order is {order}, but for model exchange this FMU has the states of order {ORDER}: their number is fixed when \
                 it is packaged. Leave order at {ORDER}, or use co-simulation, where it is free, or make an FMU of that order: \
                 dualarm package --plant-order {order}"
            )));
        }
        self.initialize(experiment)
    }

    fn states_set(&mut self) -> Result<(), Failure> {
        let states = self.states();
        let plant = self.plant.as_mut().ok_or_else(|| Failure::error("the plant has no start yet"))?;
        let count = plant.state_count();
        plant.set_continuous_states(&states[..count]).map_err(Failure::discard)
    }

    fn new_discrete_states(&mut self, _: &mut Moment<'_>) -> Result<EventUpdate, Failure> {
        let again = self.plant.as_mut().is_some_and(|plant| plant.update_contacts(&self.inputs));
        // Commands may follow what has jumped, and contacts may follow commands.
        Ok(EventUpdate { again, ..EventUpdate::default() })
    }

    fn step_completed(&mut self, moment: &mut Moment<'_>) -> Result<Completed, Failure> {
        // The host has moved the plant, which knows of no step of its own.
        let size = self.grip.passed(moment.time);
        if let Some(plant) = &self.plant {
            self.grip.look(moment.time, size, plant, &self.inputs);
        }
        if self.is_over(moment.time, size) {
            self.tell_of_contact(&mut |said| moment.warn(said));
        }
        let due = self.plant.as_ref().is_some_and(|plant| plant.contact_is_due(&self.inputs));
        Ok(if due { Completed::EnterEventMode } else { Completed::Continue })
    }

    fn jacobian_product(&mut self, direction: &mut Self) {
        let Some(plant) = self.with_states() else { return };
        let (states, count) = (direction.states(), plant.state_count());
        let mut rates = [0.0; STATES];
        plant.derivative_change(&self.inputs, &states[..count], &direction.inputs, &mut rates[..count]);
        let continuous = direction.continuous();
        continuous.rates = rates;
        // The time derivatives of the clearances have a field of their own.
        continuous.opening = [rates[CONTACT], rates[CONTACT + 1]];
        direction.outputs.change(&plant.output_change(&self.inputs, &states[..count], &direction.inputs));
    }
}
