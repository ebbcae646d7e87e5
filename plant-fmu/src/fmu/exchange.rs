//! The plant for a host that integrates: the states of [`grasp_plant`] as variables, and what follows from them.

use fmi2_export::{Completed, Experiment, Failure, Model, ModelExchange, Moment, Variables};
use grasp_plant::{ORDER_RANGE, Plant};

use super::DualArmPlant;

/// The order at which the plant has its continuous states. FMI 2.0 fixes their number when an FMU is packaged; the packaging
/// program can be told another one.
pub const ORDER: usize = packaged_order(option_env!("DUALARM_PLANT_ORDER"));
/// Energy coordinates x.
const COORDINATES: usize = 4 * ORDER + 1;
/// These, the object's position and the supplied energy.
const STATES: usize = COORDINATES + 2;
/// The place of the last one.
const SUPPLIED_ENERGY: usize = COORDINATES + 1;

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
    rates: [f64; STATES],
    indicators: [f64; Plant::EVENT_INDICATORS],
}

impl Default for Continuous {
    fn default() -> Self {
        Self { coordinates: [0.0; COORDINATES], rates: [0.0; STATES], indicators: [0.0; Plant::EVENT_INDICATORS] }
    }
}

impl DualArmPlant {
    /// The plant, if it has the FMU's states: in co-simulation the order is free, and the grasp may open.
    fn with_states(&self) -> Option<&Plant> {
        self.plant.as_ref().filter(|plant| !plant.can_open() && plant.state_count() == STATES)
    }

    fn coordinates(&mut self) {
        let mut states = [0.0; STATES];
        if let Some(plant) = self.with_states() {
            plant.continuous_states(&mut states);
        }
        self.continuous.coordinates.copy_from_slice(&states[..COORDINATES]);
    }

    fn state_rates(&mut self) {
        let mut rates = [0.0; STATES];
        if let Some(plant) = self.with_states() {
            plant.derivatives(&self.inputs, &mut rates);
        }
        self.continuous.rates = rates;
    }

    fn indicators(&mut self) {
        let mut indicators = [1.0; Plant::EVENT_INDICATORS];
        if let Some(plant) = &self.plant {
            plant.event_indicators(&self.inputs, &mut indicators);
        }
        self.continuous.indicators = indicators;
    }

    /// The states as the fields of this model have them: values, or a direction.
    fn states(&self) -> [f64; STATES] {
        let mut states = [0.0; STATES];
        let (coordinates, others) = states.split_at_mut(COORDINATES);
        coordinates.copy_from_slice(&self.continuous.coordinates);
        others.copy_from_slice(&[self.outputs.measured.y_object, self.outputs.shape.supplied_energy]);
        states
    }
}

/// The energy coordinates and the time derivatives of all states. Position and supplied energy are outputs, and declared there.
pub(super) fn declare(variables: &mut Variables<DualArmPlant>) {
    let coordinates = variables.evaluation(DualArmPlant::coordinates);
    let rates = variables.evaluation(DualArmPlant::state_rates);
    let indicators = variables.evaluation(DualArmPlant::indicators);
    let rows = Plant::state_variables(ORDER);
    variables.states(
        &rows[..COORDINATES],
        coordinates,
        |m| &mut m.continuous.coordinates,
        rates,
        |m| &mut m.continuous.rates[..COORDINATES],
    );
    // The position's is an output.
    variables
        .local("der(supplied_energy)", rates, |m| &mut m.continuous.rates[SUPPLIED_ENERGY])
        .derivative_of("supplied_energy")
        .unit("W")
        .description("Power of the actuators and the external disturbances");
    variables.event_indicators(indicators, |m| &mut m.continuous.indicators);
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
        if self.contact_model != super::variables::ContactChoice::default() {
            return Err(Failure::error(
                "for model exchange contact_model must be bilateral: a grasp that can open goes from switch to switch by itself, in \
                 co-simulation",
            ));
        }
        self.initialize(experiment)
    }

    fn states_set(&mut self) -> Result<(), Failure> {
        let states = self.states();
        let plant = self.plant.as_mut().ok_or_else(|| Failure::error("the plant has no start yet"))?;
        plant.set_continuous_states(&states).map_err(Failure::discard)
    }

    fn step_completed(&mut self, moment: &mut Moment<'_>) -> Result<Completed, Failure> {
        self.watch_contact(moment.time, &mut |said| moment.warn(said));
        Ok(Completed::Continue)
    }

    fn jacobian_product(&mut self, direction: &mut Self) {
        let Some(plant) = self.with_states() else { return };
        let states = direction.states();
        let mut rates = [0.0; STATES];
        plant.derivative_change(&self.inputs, &states, &direction.inputs, &mut rates);
        direction.continuous.rates = rates;
        direction.outputs.change(&plant.output_change(&self.inputs, &states, &direction.inputs));
    }
}
