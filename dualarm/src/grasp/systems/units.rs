//! The definitions of the units that documents refer to.

use fmi2_cosim::ssp::structure::SystemStructure;
use fmi2_import::ModelDescription;
use fmi2_import::description::Unit;

pub(super) fn set_units(structure: &mut SystemStructure, descriptions: &[&ModelDescription]) {
    let system = &structure.system;
    let connectors = system.components.iter().flat_map(|component| &component.connectors).chain(&system.connectors);
    let used: Vec<_> = connectors.filter_map(|connector| connector.unit.as_deref()).collect();
    structure.units = units_of(descriptions, &used);
}

/// Definitions of the units, sorted by name.
pub(super) fn units_of(descriptions: &[&ModelDescription], names: &[&str]) -> Vec<Unit> {
    let mut units: Vec<_> = descriptions
        .iter()
        .flat_map(|description| &description.units)
        .filter(|unit| names.contains(&unit.name.as_str()))
        .cloned()
        .collect();
    units.sort_by(|a, b| a.name.cmp(&b.name));
    units.dedup_by(|a, b| a.name == b.name);
    for unit in &mut units {
        unit.display_units.clear(); // SSP has none
    }
    units
}
