//! Saved states: copies in memory, and what of them becomes bytes.

use super::DualArmPlant;

impl Clone for DualArmPlant {
    fn clone(&self) -> Self {
        let mut plant = Self::default();
        plant.clone_from(self);
        plant
    }

    /// In the memory that is there: hosts save and restore states at every step.
    fn clone_from(&mut self, source: &Self) {
        let Self {
            parameters,
            actuator_model,
            contact_model,
            before,
            continuous,
            outputs,
            inputs,
            input_rates,
            plant,
            grip,
            told_of_contact,
            stop_time,
            told_of_limits,
            time_at_limits,
        } = source;
        self.parameters.clone_from(parameters);
        self.actuator_model.clone_from(actuator_model);
        self.contact_model.clone_from(contact_model);
        self.before.clone_from(before);
        self.continuous.clone_from(continuous);
        self.outputs.clone_from(outputs);
        (self.inputs, self.input_rates) = (*inputs, *input_rates);
        self.plant.clone_from(plant);
        (self.grip, self.told_of_contact) = (*grip, *told_of_contact);
        (self.stop_time, self.told_of_limits, self.time_at_limits) = (*stop_time, *told_of_limits, *time_at_limits);
    }
}

/// A plant in a saved state is its parameters and what moves; the matrices are computed again.
pub(super) mod plant {
    use grasp_plant::{Parameters, Plant, State};
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    #[allow(clippy::ref_option)] // The signature serde asks for.
    pub fn serialize<S: Serializer>(plant: &Option<Plant>, serializer: S) -> Result<S::Ok, S::Error> {
        plant.as_ref().map(|plant| (plant.parameters(), plant.state())).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Plant>, D::Error> {
        let Some((parameters, state)) = Option::<(Parameters, State)>::deserialize(deserializer)? else {
            return Ok(None);
        };
        let mut plant = Plant::new(parameters).map_err(D::Error::custom)?;
        plant.set_state(&state).map_err(D::Error::custom)?;
        Ok(Some(plant))
    }
}
