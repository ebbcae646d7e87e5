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
    /// What the user wants.
    pub fn profiles(&self) -> Vec<&'static Profile> {
        self.instruments.iter().filter_map(|key| Profile::find(key)).collect()
    }

    /// Puts it into the system's loop.
    pub fn put_into(&self, system: &mut System, fmus: &Path) -> Result<(), Failure> {
        Ok(instruments::put_into(system, &self.profiles(), fmus)?)
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
