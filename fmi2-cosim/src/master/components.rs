//! The components: their names, the sources of their inputs, and combinations that are impossible.

use std::collections::{HashMap, HashSet};

use super::MasterError;
use crate::grid::TimeGrid;
use crate::names::free_name;
use crate::settings;
use crate::wiring::{Wire, Wiring, wire_by_name};
use fmi2_import::{Fmu, Instance, ModelDescription};

/// A component that runs.
pub(super) struct Slave {
    pub name: String,
    pub instance: Instance,
    /// Its driven inputs, with the output that drives each.
    pub drivers: HashMap<usize, String>,
}

impl settings::Target for Slave {
    fn name(&self) -> &str {
        &self.name
    }
    fn description(&self) -> &ModelDescription {
        self.instance.description()
    }
    fn driven_by(&self, variable: usize) -> Option<&str> {
        self.drivers.get(&variable).map(String::as_str)
    }
}

/// A component before instantiation, with the outputs that drive its inputs.
pub(crate) struct Draft<'a> {
    pub(super) name: &'a str,
    pub(super) fmu: &'a Fmu,
    pub(super) drivers: HashMap<usize, String>,
}

/// The components that these FMUs and wires will make.
pub(crate) fn drafts<'a>(named: &'a [(String, Fmu)], wires: &[Wire]) -> Vec<Draft<'a>> {
    let draft = |(name, fmu): &'a (String, Fmu)| Draft { name, fmu, drivers: HashMap::new() };
    let mut drafts: Vec<_> = named.iter().map(draft).collect();
    for wire in wires {
        let (from, fmu) = &named[wire.from.component];
        let driver = format!("{from}.{}", fmu.description().variables[wire.from.variable].name);
        drafts[wire.to.component].drivers.insert(wire.to.variable, driver);
    }
    drafts
}

impl settings::Target for Draft<'_> {
    fn name(&self) -> &str {
        self.name
    }
    fn description(&self) -> &ModelDescription {
        self.fmu.description()
    }
    fn driven_by(&self, variable: usize) -> Option<&str> {
        self.drivers.get(&variable).map(String::as_str)
    }
}

/// Checks that all components support the last step of a grid, which may be shorter than the others.
///
/// # Errors
/// When one supports only steps of equal size.
pub fn check_steps<'a>(
    components: impl IntoIterator<Item = (&'a str, &'a ModelDescription)>,
    grid: &TimeGrid,
) -> Result<(), MasterError> {
    for (name, description) in components {
        let interface = description.co_simulation.as_ref();
        if grid.has_shorter_last_step()
            && interface.is_some_and(|interface| !interface.can_handle_variable_communication_step_size)
        {
            return Err(MasterError::UnequalSteps {
                component: name.to_owned(),
                duration: grid.stop() - grid.start(),
                step: grid.step(),
            });
        }
    }
    Ok(())
}

/// An FMU that allows one instance only must not be there twice.
pub(super) fn check_instances(named: &[(String, Fmu)]) -> Result<(), MasterError> {
    let mut seen: HashMap<(&str, &str), &str> = HashMap::new();
    for (name, fmu) in named {
        let description = fmu.description();
        let Some(interface) = &description.co_simulation else { continue };
        if interface.can_be_instantiated_only_once_per_process
            && let Some(first) = seen.insert((&description.guid, &interface.model_identifier), name)
        {
            return Err(MasterError::OnlyOnce { first: first.to_owned(), second: name.clone() });
        }
    }
    Ok(())
}

/// The FMUs under unique names: the model's name, with a number from the second FMU of the same model on.
pub(crate) fn named(fmus: &[Fmu]) -> Vec<(String, Fmu)> {
    let models: HashSet<&str> = fmus.iter().map(|fmu| fmu.description().model_name.as_str()).collect();
    let mut taken: HashSet<String> = HashSet::new();
    let mut named = Vec::with_capacity(fmus.len());
    for fmu in fmus {
        let model = &fmu.description().model_name;
        // A model may be called like another one's second instance.
        let name = free_name(model, |name| taken.contains(name) || (name != model && models.contains(name)));
        taken.insert(name.clone());
        named.push((name, fmu.clone()));
    }
    named
}

/// See [`wire_by_name`].
pub(crate) fn wires_by_name(named: &[(String, Fmu)]) -> Result<Wiring, MasterError> {
    let described: Vec<_> = named.iter().map(|(name, fmu)| (name.as_str(), fmu.description())).collect();
    Ok(wire_by_name(&described)?)
}
