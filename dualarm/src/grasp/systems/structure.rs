//! The structures with plant and controller only: closed, and with the open inputs led outside.

use super::drawing::draw;
use super::parameters::{parameter, parameter_units};
use super::units::{set_units, units_of};
use super::{
    COMPONENTS, ComposeError, DRIVEN, Grasp, SHOWN, TOLERANCE, file_binding, fmu_path, origin, paper_set_path,
};
use crate::grasp::scenarios::BuiltIn;
use fmi2_cosim::ssp::parameters::ParameterSet;
use fmi2_cosim::ssp::structure::{
    ComponentElement, Connection, Connector, DefaultExperiment, End, Kind, Line, SystemElement, SystemStructure,
};
use fmi2_cosim::wiring::{Terminal, wire_by_name};
use fmi2_import::{Causality, ModelDescription, Variable};

impl Grasp {
    /// The default structure: two components, connected by equal names.
    pub(super) fn structure(&self, descriptions: &[&ModelDescription]) -> Result<SystemStructure, ComposeError> {
        let scenario = BuiltIn::find(self.scenario)?.scenario()?;
        let names = COMPONENTS;
        let named: Vec<_> = names.into_iter().zip(descriptions.iter().copied()).collect();
        let connections: Vec<Connection> = wire_by_name(&named)?
            .wires
            .iter()
            .map(|wire| {
                let end = |terminal: Terminal| {
                    let variable = &descriptions[terminal.component].variables[terminal.variable];
                    End::of(names[terminal.component], &variable.name)
                };
                Connection {
                    start: end(wire.from),
                    end: end(wire.to),
                    suppress_unit_conversion: false,
                    line: Line::default(),
                }
            })
            .collect();
        let components: Vec<_> = names
            .iter()
            .zip(descriptions)
            .map(|(name, description)| {
                let is_connected = |variable: &&Variable| {
                    let end = End::of(name, &variable.name);
                    connections.iter().any(|connection| connection.start == end || connection.end == end)
                };
                let variables = description
                    .variables
                    .iter()
                    .filter(|variable| is_connected(variable) || SHOWN.contains(&variable.name.as_str()));
                ComponentElement {
                    name: (*name).to_owned(),
                    description: description.description.clone(),
                    source: fmu_path(&format!("{}.fmu", description.model_name)),
                    connectors: variables.filter_map(connector).collect(),
                    extent: None,
                    bindings: vec![file_binding(paper_set_path(description))],
                    line: Line::default(),
                }
            })
            .collect();
        let mut structure = SystemStructure {
            name: self.name().replace('-', "_"),
            description: Some(scenario.title),
            system: SystemElement {
                name: "DualArmGrasp".into(),
                description: Some("The arms with the object between them, and the controller".into()),
                components,
                connections,
                ..SystemElement::default()
            },
            experiment: DefaultExperiment {
                start: Some(0.0),
                stop: scenario.experiment.stop,
                step: Some(self.step),
                tolerance: Some(TOLERANCE),
            },
            origin: origin(),
            ..SystemStructure::default()
        };
        draw(&mut structure.system);
        set_units(&mut structure, descriptions);
        Ok(structure)
    }
}

/// The connector of an input or output.
pub(super) fn connector(variable: &Variable) -> Option<Connector> {
    let kind = match variable.causality {
        Causality::Input => Kind::Input,
        Causality::Output => Kind::Output,
        _ => return None,
    };
    Some(Connector {
        name: variable.name.clone(),
        kind,
        base_type: Some(variable.base_type()),
        unit: variable.unit().map(str::to_owned),
        description: variable.description.clone(),
        position: None,
        line: Line::default(),
    })
}

/// The variant in which all open inputs of the components are inputs of the system, and the shown outputs its outputs; with
/// the start values of those inputs.
pub(super) fn driven(closed: SystemStructure, descriptions: &[&ModelDescription]) -> (SystemStructure, ParameterSet) {
    let mut structure = closed;
    structure.name = format!("{}_{DRIVEN}", structure.name);
    structure.description =
        Some("References and disturbances are inputs of the system, the contact forces its outputs".into());
    let system = &mut structure.system;
    let mut start_values = ParameterSet {
        name: DRIVEN.to_lowercase(),
        description: Some("Start values of the system's inputs: those of the FMUs".into()),
        origin: origin(),
        ..ParameterSet::default()
    };
    for (component, description) in system.components.iter_mut().zip(descriptions) {
        let is_free = |variable: &&Variable| {
            variable.causality == Causality::Input
                && !component.connectors.iter().any(|connector| connector.name == variable.name)
        };
        let free: Vec<&Variable> = description.variables.iter().filter(is_free).collect();
        component.connectors.extend(free.iter().copied().filter_map(connector));
        start_values.parameters.extend(free.iter().copied().filter_map(parameter));
        let outer = component.connectors.iter().filter(|connector| {
            free.iter().any(|variable| variable.name == connector.name) || SHOWN.contains(&connector.name.as_str())
        });
        for connector in outer {
            let (inside, outside) = (End::of(&component.name, &connector.name), End::system(&connector.name));
            let (start, end) = if connector.kind == Kind::Input { (outside, inside) } else { (inside, outside) };
            let line = Line::default();
            system.connections.push(Connection { start, end, suppress_unit_conversion: false, line });
            system.connectors.push(connector.clone());
        }
    }
    start_values.units = units_of(descriptions, &parameter_units(&start_values));
    draw(system);
    set_units(&mut structure, descriptions);
    (structure, start_values)
}
