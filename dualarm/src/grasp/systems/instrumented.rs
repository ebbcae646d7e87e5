//! The variant with sensors and actuators: the connections of the default structure, routed through them.

use super::structure::connector;
use super::units::set_units;
use super::{COMPONENTS as CLOSED, CONTROLLER, INSTRUMENTED, PITCH, PLANT, WIDTH};
use super::{file_binding, fmu_path, paper_set_path};
use crate::grasp::instruments::{ACTUATORS, INSTRUMENTS, Passage};
use fmi2_cosim::scenario::Scenario;
use fmi2_cosim::ssp::structure::{
    ComponentElement, Connection, End, Extent, Kind, Line, Point, SystemElement, SystemStructure,
};
use fmi2_import::ModelDescription;

/// The built-in scenario that the variant is.
pub const SCENARIO: &str = "noise";

/// Names of the components between plant and controller.
const BETWEEN: [(&str, Passage); 2] = [("instruments", INSTRUMENTS), ("actuators", ACTUATORS)];

/// Names of all components, in the order of their descriptions.
pub const COMPONENTS: [&str; 4] = [CLOSED[0], CLOSED[1], BETWEEN[0].0, BETWEEN[1].0];

/// The structure, from the closed one and the descriptions of the plant, the controller, the sensors and the actuators.
pub fn structure(closed: SystemStructure, scenario: &Scenario, descriptions: &[&ModelDescription]) -> SystemStructure {
    let mut structure = closed;
    structure.name = format!("{}_{INSTRUMENTED}", structure.name);
    structure.description = Some(scenario.title.clone());
    let system = &mut structure.system;
    system.description = Some("The arms with the object between them, sensors, controller, actuators".into());
    // To the controller through the sensors, from it through the actuators.
    let through =
        |connection: &Connection| BETWEEN[usize::from(connection.start.element.as_deref() == Some(CONTROLLER))];
    system.connections = system
        .connections
        .iter()
        .flat_map(|connection| {
            let (name, Passage { suffix, .. }) = through(connection);
            let signal = &connection.start.connector;
            let to = Connection { end: End::of(name, signal), ..connection.clone() };
            let from = Connection { start: End::of(name, &format!("{signal}{suffix}")), ..connection.clone() };
            [to, from]
        })
        .collect();
    for (place, ((name, _), description)) in [1, 3].into_iter().zip(BETWEEN.iter().zip(&descriptions[2..])) {
        let connections = &system.connections;
        let is_connected = |variable: &str| {
            let end = End::of(name, variable);
            connections.iter().any(|connection| connection.start == end || connection.end == end)
        };
        let variables = description.variables.iter().filter(|variable| is_connected(&variable.name));
        let component = ComponentElement {
            name: (*name).to_owned(),
            description: description.description.clone(),
            source: fmu_path(&format!("{}.fmu", description.model_name)),
            connectors: variables.filter_map(connector).collect(),
            extent: None,
            bindings: vec![file_binding(paper_set_path(description))],
            line: Line::default(),
        };
        system.components.insert(place, component);
    }
    draw(system);
    set_units(&mut structure, descriptions);
    structure
}

/// Draws controller, actuators above sensors, and plant from the left to the right, with all connections as straight lines.
fn draw(system: &mut SystemElement) {
    // Commands above measured signals, each in the order of the file.
    let [sensors, actuators] = BETWEEN.map(|(name, _)| {
        let to = system.connections.iter().filter(move |connection| connection.end.element.as_deref() == Some(name));
        to.map(|connection| connection.end.connector.clone()).collect::<Vec<_>>()
    });
    let commands = actuators.len();
    let rows = [actuators, sensors].concat();
    let first_row = PITCH * rows.len() as f64;
    let row = |index: usize| first_row - PITCH * index as f64;
    let (top, seam) = (first_row + PITCH, row(commands) + 0.5 * PITCH);
    for component in &mut system.components {
        let (left, low, high) = match component.name.as_str() {
            CONTROLLER => (0.0, 0.0, top),
            PLANT => (4.0 * WIDTH, 0.0, top),
            name if name == BETWEEN[0].0 => (2.0 * WIDTH, 0.0, seam - 0.1 * PITCH),
            _ => (2.0 * WIDTH, seam + 0.1 * PITCH, top),
        };
        let extent = Extent::new(left, low, left + WIDTH, high);
        component.extent = Some(extent);
        let mut outer_rows = 0..;
        for connector in &mut component.connectors {
            let signal = BETWEEN.iter().find_map(|(_, passage)| connector.name.strip_suffix(passage.suffix));
            let index = rows.iter().position(|row| row == signal.unwrap_or(&connector.name));
            // Commands go to the right and measured signals to the left, so each side has one end of each line.
            let right = match (component.name.as_str(), index) {
                (CONTROLLER, Some(_)) | (PLANT, None) => true,
                (CONTROLLER, None) | (PLANT, Some(_)) => false,
                (name, _) => (name == BETWEEN[0].0) == (connector.kind == Kind::Input),
            };
            let index = index.unwrap_or_else(|| outer_rows.next().unwrap_or_default());
            let x = if right { extent.high.x } else { extent.low.x };
            connector.position = Some(extent.relative(Point { x, y: row(index) }));
        }
    }
}
