//! SSP files: what is written reads back, systems run as they say, and what is wrong with a file is said with the file,
//! the line and the element.

#[path = "../../../fmi2-import/tests/support/mod.rs"]
mod support;

mod faults;
mod files;
mod runs;

use std::fs;
use std::path::{Path, PathBuf};

use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::Coupling;
use fmi2_cosim::record::Table;
use fmi2_cosim::ssp::parameters::{ParameterSet, ParameterValue, Reference};
use fmi2_cosim::ssp::structure::{
    Binding, ComponentElement, Connection, Connector, DefaultExperiment, End, Extent, Kind, Line, Mapping,
    MappingEntry, Origin, Point, SystemElement, SystemStructure, Values,
};
use fmi2_cosim::ssp::{Package, package, read, write};
use fmi2_cosim::system;
use fmi2_import::Value;
use fmi2_import::description::{BaseType, Item, Unit};
use support::{archive, package as package_fmu, package_as};

const LINE: Line = Line(0);

fn unit(name: &str, exponents: [i32; 8], factor: f64, offset: f64) -> Unit {
    Unit { name: name.into(), exponents, factor, offset, has_base_unit: true, display_units: Vec::new() }
}

fn connector(name: &str, kind: Kind) -> Connector {
    Connector {
        name: name.into(),
        kind,
        base_type: Some(BaseType::Real),
        unit: None,
        description: None,
        position: None,
        line: LINE,
    }
}

fn connection(start: End, end: End) -> Connection {
    Connection { start, end, suppress_unit_conversion: false, line: LINE }
}

/// The lag's output to the gain and the gain's back to the lag, with a value for the gain.
fn loop_of_two() -> SystemStructure {
    let component = |name: &str, source: &str, connectors| ComponentElement {
        name: name.into(),
        source: source.into(),
        connectors,
        ..ComponentElement::default()
    };
    SystemStructure {
        name: "Loop".into(),
        system: SystemElement {
            name: "loop".into(),
            components: vec![
                component("lag", "resources/Lag.fmu", vec![connector("u", Kind::Input), connector("y", Kind::Output)]),
                component(
                    "gain",
                    "resources/Gain.fmu",
                    vec![
                        connector("y", Kind::Input),
                        connector("u", Kind::Output),
                        connector("reference", Kind::Input),
                    ],
                ),
            ],
            connections: vec![
                connection(End::of("lag", "y"), End::of("gain", "y")),
                // The ends may stand in either order.
                connection(End::of("lag", "u"), End::of("gain", "u")),
            ],
            ..SystemElement::default()
        },
        ..SystemStructure::default()
    }
}

/// A real number without a unit.
fn real(value: f64) -> (Value, Reference) {
    (value.into(), Reference::Nothing)
}

/// A real number in a unit.
fn real_in(value: f64, unit: &str) -> (Value, Reference) {
    (value.into(), Reference::Unit(unit.into()))
}

/// A value that is no real number.
fn plain(value: impl Into<Value>) -> (Value, Reference) {
    (value.into(), Reference::Nothing)
}

fn set(parameters: Vec<(&str, (Value, Reference))>) -> ParameterSet {
    let parameters = parameters.into_iter().map(|(name, (value, refers_to))| ParameterValue {
        name: name.into(),
        value,
        refers_to,
        line: LINE,
    });
    ParameterSet { name: "set".into(), parameters: parameters.collect(), ..ParameterSet::default() }
}

fn inline(set: ParameterSet) -> Binding {
    Binding { values: Values::Inline(set), ..Binding::default() }
}

/// The description of a fixture with a time constant in s, which the fixture itself leaves out.
fn with_unit(description: &str) -> String {
    let units = "<UnitDefinitions><Unit name=\"s\"><BaseUnit s=\"1\"/></Unit></UnitDefinitions><TypeDefinitions>";
    let description = description.replacen("<TypeDefinitions>", units, 1);
    description.replacen("start=\"1\" min=\"0\"", "start=\"1\" min=\"0\" unit=\"s\"", 1)
}

/// Packages the two fixtures with this structure; `None` without a C compiler.
fn ssp(folder: &Path, structure: &str, others: &[(&str, &[u8])]) -> Option<PathBuf> {
    let lag = package_as(folder, "Lag", |description| with_unit(&description))?;
    let fmus = [fs::read(lag).unwrap(), fs::read(package_fmu(folder, "Gain")?).unwrap()];
    let path = folder.join("Loop.ssp");
    let mut entries: Vec<(&str, &[u8])> = vec![
        ("SystemStructure.ssd", structure.as_bytes()),
        ("resources/Lag.fmu", &fmus[0]),
        ("resources/Gain.fmu", &fmus[1]),
    ];
    entries.extend(others);
    archive(&path, &entries);
    Some(path)
}
