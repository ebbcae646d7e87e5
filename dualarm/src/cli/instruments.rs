//! `--instruments`, of several commands.

use std::path::Path;

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::Failure;
use crate::grasp::instruments::{self, InstrumentsError, PROFILES, Profile};
use fmi2_cosim::system::System;

/// Sensors and actuators between plant and controller.
#[derive(Debug, Clone, Default, Args)]
pub struct InstrumentsChoice {
    /// Put sensors and actuators between plant and controller: with noise, encoders without rates, late commands (several
    /// with commas), or off but for what --set says
    #[arg(long, value_name = "PROFILE", value_delimiter = ',',
          value_parser = PossibleValuesParser::new(PROFILES.iter().map(|profile| profile.key)))]
    instruments: Vec<String>,
}

impl InstrumentsChoice {
    /// Puts what the user wants into the system's loop, and leads signals through what it has of its own.
    pub fn put_into(&self, system: &mut System, fmus: &Path) -> Result<(), Failure> {
        let profiles: Vec<&Profile> = self.instruments.iter().filter_map(|key| Profile::find(key)).collect();
        if profiles.is_empty() {
            return instruments::connect(system).map_err(|error| InstrumentsError::from(error).into());
        }
        Ok(instruments::insert(system, &profiles, fmus)?)
    }

    /// What the report says of them.
    pub fn sentence(&self) -> String {
        match self.instruments.as_slice() {
            [] => String::new(),
            profiles => format!(
                " Between plant and controller are GraspInstruments.fmu and GraspActuators.fmu: {}.",
                profiles.join(", ")
            ),
        }
    }
}

impl From<InstrumentsError> for Failure {
    fn from(error: InstrumentsError) -> Self {
        match error {
            InstrumentsError::NoLoop(_) => Self::usage(error),
            _ => Self::failed(error),
        }
    }
}
