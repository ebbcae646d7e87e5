//! What the packaging needs of a model: its interface as data, and an instance that runs without a host.
//!
//! Hidden from the documentation, since only `fmi2-package` of the very same version uses it; it may change with any.

pub use crate::access::EnumerationKind;
pub use crate::identity::VARIABLE;
pub use crate::interface::{Interface, Kind, VariableFacts, number};
pub use crate::unit::{BASE_UNITS, DisplayUnit};
pub use crate::xml::GENERATION_TOOL;

use crate::categories::CATEGORIES;
use crate::layout::{BaseType, DeclarationError};
use crate::library::ExportedModel;
use crate::model::Experiment;
use crate::resources::Resources;
use crate::slave::Slave;
use crate::status::Refusal;
use crate::unit::Unit;

/// A model's interface.
///
/// # Errors
/// If the model's declarations contradict themselves.
pub fn interface(model: &'static dyn ExportedModel) -> Result<Interface, DeclarationError> {
    model.interface()
}

/// Exponents of the base units, in the order of [`BASE_UNITS`], factor and offset of a unit.
#[must_use]
pub fn in_base_units(unit: &Unit) -> ([i32; BASE_UNITS.len()], f64, f64) {
    (unit.exponents, unit.factor, unit.offset)
}

/// Names of the log categories.
pub fn log_categories() -> impl Iterator<Item = &'static str> {
    CATEGORIES.iter().map(|(name, _)| *name)
}

/// An instance of a model that no host has: all rules of the standard hold for it, but nobody hears its warnings. Errors are
/// what a host would be told.
pub struct Instance {
    slave: Slave,
}

impl Instance {
    /// A new one.
    ///
    /// # Errors
    /// If the model refuses; the error says why.
    pub fn new(model: &'static dyn ExportedModel, resources: &Resources) -> Result<Self, String> {
        Ok(Self { slave: model.instantiate(resources).map_err(message)? })
    }

    /// Into initialization mode of an experiment from 0 s on without an end.
    ///
    /// # Errors
    /// If the model refuses; the error says why.
    pub fn enter_initialization(&mut self) -> Result<(), String> {
        let experiment = Experiment { start_time: 0.0, stop_time: None, tolerance: None };
        self.slave.setup_experiment(experiment).and_then(|()| self.slave.enter_initialization()).map_err(message)
    }

    /// Out of initialization mode.
    ///
    /// # Errors
    /// If the model refuses; the error says why.
    pub fn exit_initialization(&mut self) -> Result<(), String> {
        self.slave.exit_initialization().map_err(message)
    }

    /// A communication step (s).
    ///
    /// # Errors
    /// If the model refuses; the error says why.
    pub fn step(&mut self, time: f64, size: f64) -> Result<(), String> {
        self.slave.do_step(time, size, &mut |_| {}).map_err(message)
    }

    /// Sets a variable that is no string. Booleans are 0 or 1, enumerations numbered from 1.
    ///
    /// # Errors
    /// If it cannot have this value, or not now.
    pub fn set(&mut self, variable: &VariableFacts, value: f64) -> Result<(), String> {
        let reference = [variable.reference.index];
        #[allow(clippy::cast_possible_truncation)] // What is no whole number is refused.
        let integer = || {
            let whole = value as i32;
            if f64::from(whole) == value {
                Ok([whole])
            } else {
                Err(format!("{} cannot be {value}: it must be a whole number", variable.name))
            }
        };
        match variable.reference.base {
            BaseType::Integer => self.slave.set_integer(&reference, &integer()?),
            BaseType::Boolean => self.slave.set_boolean(&reference, &integer()?),
            BaseType::Real | BaseType::String => self.slave.set_real(&reference, &[value]),
        }
        .map_err(message)
    }

    /// The value of a variable that is no string, as [`set`](Self::set) takes it.
    ///
    /// # Errors
    /// If the model refuses; the error says why.
    pub fn get(&mut self, variable: &VariableFacts) -> Result<f64, String> {
        let reference = [variable.reference.index];
        let (mut real, mut integer) = ([0.0], [0]);
        match variable.reference.base {
            BaseType::Integer => self.slave.get_integer(&reference, integer.as_mut_slice().into()),
            BaseType::Boolean => self.slave.get_boolean(&reference, integer.as_mut_slice().into()),
            BaseType::Real | BaseType::String => {
                self.slave.get_real(&reference, real.as_mut_slice().into()).map_err(message)?;
                return Ok(real[0]);
            }
        }
        .map_err(message)?;
        Ok(f64::from(integer[0]))
    }
}

fn message(refusal: Refusal) -> String {
    refusal.into_message()
}
