//! A system structure description (SSD): components, connectors, connections, and how to draw them (SSP 1.0.1,
//! section 5). Only what this tool can run: no nested systems, no signal dictionaries.

use super::parameters::ParameterSet;
use fmi2_import::description::{BaseType, Unit};

/// One `.ssd` document.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SystemStructure {
    /// Name of this structure, shown when variants are chosen. `OMSimulator` requires an identifier.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// The system.
    pub system: SystemElement,
    /// Units that connectors refer to.
    pub units: Vec<Unit>,
    /// How long to simulate.
    pub experiment: DefaultExperiment,
    /// Where the file comes from.
    pub origin: Origin,
}

/// The licence of a document, and the program that wrote it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// The licence, as an SPDX identifier or a sentence.
    pub license: Option<String>,
    /// Name and version of the program.
    pub generation_tool: Option<String>,
}

/// The system: components and how they are connected.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SystemElement {
    /// Name of the system.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// Its connectors to the outside.
    pub connectors: Vec<Connector>,
    /// Parameters by hierarchical name, `component.parameter`. They take precedence over those of the components.
    pub bindings: Vec<Binding>,
    /// Its components, in the order of the file.
    pub components: Vec<ComponentElement>,
    /// From whom to whom.
    pub connections: Vec<Connection>,
    /// Extent of the drawing. Without one it is the bounding box of the components.
    pub canvas: Option<Extent>,
}

/// An FMU in the system.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComponentElement {
    /// Unique name.
    pub name: String,
    /// One sentence about it.
    pub description: Option<String>,
    /// The FMU, a path relative to the `.ssd` file.
    pub source: String,
    /// The variables that are connected or worth showing.
    pub connectors: Vec<Connector>,
    /// Where the component is drawn.
    pub extent: Option<Extent>,
    /// Parameters by their name in the FMU.
    pub bindings: Vec<Binding>,
    /// Where it is declared.
    pub line: Line,
}

/// A variable that can be connected.
#[derive(Debug, Clone, PartialEq)]
pub struct Connector {
    /// Name of the variable.
    pub name: String,
    /// Its role.
    pub kind: Kind,
    /// Base type; without one, that of the FMU's variable.
    pub base_type: Option<BaseType>,
    /// Unit of a real connector.
    pub unit: Option<String>,
    /// One sentence about it.
    pub description: Option<String>,
    /// Where it is drawn: (0, 0) is the lower left corner of its element, (1, 1) the upper right one.
    pub position: Option<Point>,
    /// Where it is declared.
    pub line: Line,
}

/// A connector's role, which is the causality of its variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Takes a signal.
    Input,
    /// Offers a signal.
    Output,
    /// Takes a value before the simulation.
    Parameter,
    /// Offers a value that follows from parameters.
    CalculatedParameter,
}

impl Kind {
    const NAMES: [(Self, &str); 4] = [
        (Self::Input, "input"),
        (Self::Output, "output"),
        (Self::Parameter, "parameter"),
        (Self::CalculatedParameter, "calculatedParameter"),
    ];

    /// The name in XML.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }

    /// The kind of this name in XML.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(_, known)| *known == name).map(|(kind, _)| *kind)
    }
}

/// A connection between two connectors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connection {
    /// One end.
    pub start: End,
    /// The other end.
    pub end: End,
    /// Values pass as they are, even if the units differ.
    pub suppress_unit_conversion: bool,
    /// Where it is declared.
    pub line: Line,
}

/// One end of a connection.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct End {
    /// The component; `None` for the system itself.
    pub element: Option<String>,
    /// The connector.
    pub connector: String,
}

impl End {
    /// A component's connector.
    #[must_use]
    pub fn of(element: &str, connector: &str) -> Self {
        Self { element: Some(element.to_owned()), connector: connector.to_owned() }
    }

    /// A connector of the system itself.
    #[must_use]
    pub fn system(connector: &str) -> Self {
        Self { element: None, connector: connector.to_owned() }
    }
}

/// Parameters for a component or a system.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Binding {
    /// The `.ssv` file, a path relative to the `.ssd` file, or the parameters themselves.
    pub values: Values,
    /// Put in front of every name, without anything between.
    pub prefix: String,
    /// Which parameters are applied under which names; without a mapping, all under their own.
    pub mapping: Option<Mapping>,
    /// Where it is declared.
    pub line: Line,
}

/// Where a binding's parameters are.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// In this file.
    File(String),
    /// Here.
    Inline(ParameterSet),
}

impl Default for Values {
    fn default() -> Self {
        Self::Inline(ParameterSet::default())
    }
}

/// Where a binding's mapping is.
#[derive(Debug, Clone, PartialEq)]
pub enum Mapping {
    /// In this `.ssm` file.
    File(String),
    /// Here.
    Inline(Vec<MappingEntry>),
}

/// One line of a parameter mapping: `target = factor · source + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct MappingEntry {
    /// Name in the parameter set.
    pub source: String,
    /// Name in the component or system.
    pub target: String,
    /// Factor and offset, if the value is transformed.
    pub linear: Option<(f64, f64)>,
    /// Where it is declared.
    pub line: Line,
}

/// How long to simulate, and with which step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DefaultExperiment {
    /// Start time in s.
    pub start: Option<f64>,
    /// Stop time in s.
    pub stop: Option<f64>,
    /// Communication step size in s. SSP 1.0 has no place for it; it is stored in the annotations that `OMSimulator` and
    /// `libcosim` read.
    pub step: Option<f64>,
    /// Relative tolerance. SSP 1.0 has no place for it either; `OMSimulator` reads it from its annotation.
    pub tolerance: Option<f64>,
}

/// A point in a drawing; x to the right, y upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// To the right.
    pub x: f64,
    /// Upwards.
    pub y: f64,
}

/// A rectangle in a drawing; x to the right, y upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Lower left corner.
    pub low: Point,
    /// Upper right corner.
    pub high: Point,
}

impl Extent {
    /// The rectangle from (`x1`, `y1`) to (`x2`, `y2`).
    #[must_use]
    pub fn new(x1: f64, y1: f64, x2: f64, y2: f64) -> Self {
        Self { low: Point { x: x1, y: y1 }, high: Point { x: x2, y: y2 } }
    }

    /// A point in units of this rectangle: (0, 0) its lower left corner, (1, 1) the upper right one.
    #[must_use]
    pub fn relative(&self, point: Point) -> Point {
        Point {
            x: (point.x - self.low.x) / (self.high.x - self.low.x),
            y: (point.y - self.low.y) / (self.high.y - self.low.y),
        }
    }
}

/// Line of a file from which something was read; 0 for values that were not read. It is not part of the value: all lines
/// compare equal.
#[derive(Debug, Clone, Copy, Default)]
pub struct Line(pub u32);

impl PartialEq for Line {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Line {}
