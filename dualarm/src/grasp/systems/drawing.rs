//! Where boxes and connectors are drawn.

use super::{CONTROLLER, PITCH, PLANT, WIDTH};
use fmi2_cosim::ssp::structure::{Extent, Kind, Point, SystemElement};

/// Draws the usual block diagram: the controller on the left, the plant on the right, commands and measured signals as
/// straight lines between them. References enter from the left, disturbances from above, forces leave to the right.
pub(super) fn draw(system: &mut SystemElement) {
    let between = system
        .connections
        .iter()
        .filter(|connection| connection.start.element.is_some() && connection.end.element.is_some());
    // Commands above measured signals, each in the order of the file.
    let mut rows: Vec<(bool, String)> = between
        .map(|connection| (connection.start.element.as_deref() == Some(PLANT), connection.start.connector.clone()))
        .collect();
    rows.sort_by_key(|(is_measured, _)| *is_measured);
    let is_driven = !system.connectors.is_empty();
    let first_row = PITCH * rows.len() as f64;
    // Names of the connectors at the top need room above the first row.
    let height = first_row + if is_driven { 4.0 * PITCH } else { PITCH };
    let row = |index: usize| first_row - PITCH * index as f64;
    let boxes = |name: &str| {
        let left = if name == CONTROLLER { 0.0 } else { 2.0 * WIDTH };
        Extent::new(left, 0.0, left + WIDTH, height)
    };
    let canvas = Extent::new(-WIDTH, -2.0 * PITCH, 4.0 * WIDTH, height + 4.0 * PITCH);

    for component in &mut system.components {
        let extent = boxes(&component.name);
        component.extent = Some(extent);
        let is_plant = component.name == PLANT;
        let (mut outer_rows, mut columns) = (0.., 0..);
        for connector in &mut component.connectors {
            let shared = rows.iter().position(|(_, name)| *name == connector.name);
            let (inner, outer) = if is_plant { (extent.low.x, extent.high.x) } else { (extent.high.x, extent.low.x) };
            let point = match (shared, connector.kind) {
                (Some(index), _) => Point { x: inner, y: row(index) },
                (None, Kind::Input) if is_plant => {
                    let column: usize = columns.next().unwrap_or_default();
                    Point { x: extent.low.x + 2.0 * PITCH * (column + 1) as f64, y: extent.high.y }
                }
                (None, _) => Point { x: outer, y: row(outer_rows.next().unwrap_or_default()) },
            };
            connector.position = Some(extent.relative(point));
            if let Some(own) = system.connectors.iter_mut().find(|own| own.name == connector.name) {
                let at_border = if point.y >= extent.high.y {
                    Point { y: canvas.high.y, ..point }
                } else if is_plant {
                    Point { x: canvas.high.x, ..point }
                } else {
                    Point { x: canvas.low.x, ..point }
                };
                own.position = Some(canvas.relative(at_border));
            }
        }
    }
    system.canvas = is_driven.then_some(canvas);
}
