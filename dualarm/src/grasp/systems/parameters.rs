//! Parameter sets: the start values of FMUs, and those of scenarios.

use super::units::units_of;
use super::{ComposeError, PAPER, origin};
use fmi2_cosim::scenario::Scenario;
use fmi2_cosim::ssp::parameters::{ParameterSet, ParameterValue, Reference};
use fmi2_cosim::ssp::structure::{Connector, Line};
use fmi2_cosim::system::Located;
use fmi2_import::description::VariableType;
use fmi2_import::{Causality, ModelDescription, Variable};

/// Start values of an FMU's parameters, except enumerations, and of the inputs that are not among its connectors.
pub(super) fn paper_set(description: &ModelDescription, connectors: &[Connector]) -> ParameterSet {
    let mut set = ParameterSet {
        name: PAPER.into(),
        description: Some(format!("Start values of {}: the paper's case", description.model_name)),
        origin: origin(),
        ..ParameterSet::default()
    };
    let is_set = |variable: &&Variable| match variable.causality {
        Causality::Parameter => true,
        Causality::Input => !connectors.iter().any(|connector| connector.name == variable.name),
        _ => false,
    };
    set.parameters = description.variables.iter().filter(is_set).filter_map(parameter).collect();
    set.units = units_of(&[description], &parameter_units(&set));
    set
}

/// A variable's start value, if it has one and is no enumeration.
pub(super) fn parameter(variable: &Variable) -> Option<ParameterValue> {
    if matches!(variable.kind, VariableType::Enumeration { .. }) {
        return None;
    }
    let refers_to = variable.unit().map(str::to_owned).into();
    Some(ParameterValue { name: variable.name.clone(), value: variable.start()?, refers_to, line: Line::default() })
}

/// Settings of a scenario as a parameter set of the system, under hierarchical names.
pub(super) fn settings_set(
    variant: &str,
    scenario: &Scenario,
    components: &[&str],
    descriptions: &[&ModelDescription],
) -> Result<ParameterSet, ComposeError> {
    let mut set = ParameterSet {
        name: variant.to_lowercase(),
        description: Some(scenario.title.clone()),
        origin: origin(),
        ..ParameterSet::default()
    };
    for Located { item: setting, .. } in scenario.settings.iter().chain(&scenario.held) {
        let unfit = || ComposeError::Setting { scenario: scenario.title.clone(), setting: setting.clone() };
        let before = set.parameters.len();
        for (component, model) in components.iter().zip(descriptions) {
            let Some(variable) = model.variable(&setting.target) else { continue };
            let fitted = variable.value(&setting.value).map_err(|_| unfit())?;
            let refers_to = match &variable.kind {
                VariableType::Enumeration { declared_type, .. } => {
                    let kind = declared_type.map(|index| &model.types[index]);
                    set.enumerations.extend(kind.map(|kind| (kind.name.clone(), kind.items.clone())));
                    Reference::Enumeration(kind.map(|kind| kind.name.clone()))
                }
                _ => variable.unit().map(str::to_owned).into(),
            };
            let (name, value) = (format!("{component}.{}", variable.name), variable.with_name(fitted));
            set.parameters.push(ParameterValue { name, value, refers_to, line: Line::default() });
        }
        if set.parameters.len() == before {
            return Err(unfit());
        }
    }
    set.units = units_of(descriptions, &parameter_units(&set));
    Ok(set)
}

pub(super) fn parameter_units(set: &ParameterSet) -> Vec<&str> {
    set.parameters.iter().filter_map(|parameter| parameter.refers_to.unit()).collect()
}
