//! SSD, SSV and SSM documents from XML. What this tool cannot run is an error that names the element and its line.

use fmi2_import::document::{self, Lines};
use roxmltree::{Document, Node};

use super::error::DocumentError;
use super::namespace;
use super::parameters::{Parameter, ParameterSet, Reference};
use super::structure::{
    Binding, Component, Connection, Connector, DefaultExperiment, End, Extent, Kind, Line, Mapping, MappingEntry,
    Origin, Point, System, SystemStructure, Values,
};
use fmi2_import::Value;
use fmi2_import::description::{BASE_UNITS, BaseType, Item, Unit};
use fmi2_import::xml::{child, elements, line, listed, missing, needed, number, optional, required, truth, wrong};

type Result<T> = std::result::Result<T, DocumentError>;

const FMU_TYPE: &str = "application/x-fmu-sharedlibrary";

/// Reads an `.ssd` file.
///
/// # Errors
/// When it is no SSD of SSP 1.0, or has something this tool does not support, such as nested systems.
pub fn system_structure(bytes: &[u8]) -> Result<SystemStructure> {
    let text = text(bytes)?;
    let (document, lines) = (&document::parse(text)?, &Lines::of(text));
    let root = root(document, namespace::SSD, "SystemStructureDescription")?;
    version(root)?;
    let system_node = child(root, "System").ok_or_else(|| missing(root, "the child <System>"))?;
    let experiment_node = child(root, "DefaultExperiment");
    Ok(SystemStructure {
        name: required(root, "name")?.to_owned(),
        description: optional(root, "description"),
        system: system(system_node, lines)?,
        units: units(root)?,
        experiment: DefaultExperiment {
            start: experiment_node.map(|node| number(node, "startTime")).transpose()?.flatten(),
            stop: experiment_node.map(|node| number(node, "stopTime")).transpose()?.flatten(),
            step: step(experiment_node, system_node)?,
            tolerance: annotated(Some(system_node), (namespace::OMS, "FixedStepMaster"), "relativeTolerance")?,
        },
        origin: origin(root),
    })
}

/// Reads an `.ssv` file.
///
/// # Errors
/// When it is no parameter set of SSP 1.0, or has values of a type that FMI 2.0 lacks.
pub fn parameter_set(bytes: &[u8]) -> Result<ParameterSet> {
    let text = text(bytes)?;
    let document = document::parse(text)?;
    parameters(root(&document, namespace::SSV, "ParameterSet")?, &Lines::of(text))
}

/// Reads an `.ssm` file.
///
/// # Errors
/// When it is no parameter mapping of SSP 1.0, or transforms values by tables.
pub fn parameter_mapping(bytes: &[u8]) -> Result<Vec<MappingEntry>> {
    let text = text(bytes)?;
    let document = document::parse(text)?;
    mapping_entries(root(&document, namespace::SSM, "ParameterMapping")?, &Lines::of(text))
}

fn text(bytes: &[u8]) -> Result<&str> {
    let text = std::str::from_utf8(bytes).map_err(|_| DocumentError::Encoding)?;
    Ok(text.trim_start_matches('\u{feff}'))
}

fn root<'a>(document: &'a Document<'a>, space: &str, expected: &'static str) -> Result<Node<'a, 'a>> {
    let root = document.root_element();
    if root.tag_name().name() != expected || root.tag_name().namespace() != Some(space) {
        return Err(DocumentError::Root { found: root.tag_name().name().to_owned(), expected });
    }
    Ok(root)
}

fn origin(root: Node) -> Origin {
    Origin { license: optional(root, "license"), generation_tool: optional(root, "generationTool") }
}

fn version(node: Node) -> Result<()> {
    let version = required(node, "version")?;
    if version.starts_with("1.") { Ok(()) } else { Err(DocumentError::Version(version.to_owned())) }
}

fn system(node: Node, lines: &Lines) -> Result<System> {
    if let Some(dictionary) = child(node, "SignalDictionaries") {
        return Err(unsupported(dictionary, "signal dictionaries", "connect the components directly"));
    }
    let components = listed(node, "Elements").map(|node| component(node, lines)).collect::<Result<Vec<_>>>()?;
    let mut seen = std::collections::HashSet::new();
    if let Some(twice) = components.iter().find(|component| !seen.insert(component.name.as_str())) {
        let problem = format!("two components are called \"{}\"", twice.name);
        return Err(DocumentError::Conflict { problem, line: twice.line.0 });
    }
    Ok(System {
        name: required(node, "name")?.to_owned(),
        description: optional(node, "description"),
        connectors: listed(node, "Connectors").map(|node| connector(node, lines)).collect::<Result<_>>()?,
        bindings: listed(node, "ParameterBindings").map(|node| binding(node, lines)).collect::<Result<_>>()?,
        components,
        connections: listed(node, "Connections").map(|node| connection(node, lines)).collect::<Result<_>>()?,
        canvas: child(node, "SystemGeometry").map(extent).transpose()?,
    })
}

fn component(node: Node, lines: &Lines) -> Result<Component> {
    match node.tag_name().name() {
        "Component" => {}
        "System" => {
            return Err(unsupported(node, &named("the nested system", node), "move its components to the top level"));
        }
        "SignalDictionaryReference" => {
            return Err(unsupported(
                node,
                &named("the signal dictionary reference", node),
                "connect the components directly",
            ));
        }
        other => return Err(unsupported(node, &format!("the element <{other}>"), "leave it out")),
    }
    let kind = node.attribute("type").unwrap_or(FMU_TYPE);
    if kind != FMU_TYPE {
        let what = format!("{} of type {kind}", named("the component", node));
        return Err(unsupported(node, &what, "use FMUs, application/x-fmu-sharedlibrary"));
    }
    if node.attribute("implementation") == Some("ModelExchange") {
        let what = format!("{} as model exchange", named("the component", node));
        return Err(unsupported(node, &what, "use its co-simulation interface"));
    }
    Ok(Component {
        name: required(node, "name")?.to_owned(),
        description: optional(node, "description"),
        source: required(node, "source")?.to_owned(),
        connectors: listed(node, "Connectors").map(|node| connector(node, lines)).collect::<Result<_>>()?,
        extent: child(node, "ElementGeometry").map(extent).transpose()?,
        bindings: listed(node, "ParameterBindings").map(|node| binding(node, lines)).collect::<Result<_>>()?,
        line: Line(lines.of_node(node)),
    })
}

fn extent(node: Node) -> Result<Extent> {
    let corner = |name| needed(node, name);
    Ok(Extent::new(corner("x1")?, corner("y1")?, corner("x2")?, corner("y2")?))
}

fn connector(node: Node, lines: &Lines) -> Result<Connector> {
    let type_node = BaseType::ALL.iter().find_map(|base_type| Some((*base_type, child(node, base_type.name())?)));
    if type_node.is_none()
        && let Some(binary) = child(node, "Binary")
    {
        let what = named("the binary connector", node);
        return Err(unsupported(binary, &what, "FMI 2.0 has no binary variables"));
    }
    Ok(Connector {
        name: required(node, "name")?.to_owned(),
        kind: match required(node, "kind")? {
            "inout" => {
                let what = named("the connector", node) + " of kind inout";
                return Err(unsupported(node, &what, "make it an input or an output"));
            }
            name => Kind::from_name(name).ok_or_else(|| wrong(node, "kind", name, "a connector's kind"))?,
        },
        base_type: type_node.map(|(base_type, _)| base_type),
        unit: type_node.and_then(|(_, node)| optional(node, "unit")),
        description: optional(node, "description"),
        position: child(node, "ConnectorGeometry")
            .map(|node| -> Result<Point> { Ok(Point { x: needed(node, "x")?, y: needed(node, "y")? }) })
            .transpose()?,
        line: Line(lines.of_node(node)),
    })
}

fn connection(node: Node, lines: &Lines) -> Result<Connection> {
    let end = |element: &str, connector: &str| -> Result<End> {
        Ok(End { element: optional(node, element), connector: required(node, connector)?.to_owned() })
    };
    for kind in ["Linear", "BooleanMapping", "IntegerMapping", "EnumerationMapping"] {
        if let Some(transformation) = child(node, &format!("{kind}Transformation")) {
            return Err(unsupported(
                transformation,
                &format!("the {kind}Transformation of a connection"),
                "transform the signal in an FMU",
            ));
        }
    }
    Ok(Connection {
        start: end("startElement", "startConnector")?,
        end: end("endElement", "endConnector")?,
        suppress_unit_conversion: matches!(node.attribute("suppressUnitConversion"), Some("true" | "1")),
        line: Line(lines.of_node(node)),
    })
}

fn binding(node: Node, lines: &Lines) -> Result<Binding> {
    no_component_base(node)?;
    let values = if let Some(source) = optional(node, "source") {
        Values::File(source)
    } else {
        let set = child(node, "ParameterValues").and_then(|values| child(values, "ParameterSet"));
        let set = set.ok_or_else(|| missing(node, "the attribute \"source\" or a <ParameterSet>"))?;
        Values::Inline(parameters(set, lines)?)
    };
    let mapping = child(node, "ParameterMapping").map(|node| {
        no_component_base(node)?;
        if let Some(source) = optional(node, "source") {
            return Ok(Mapping::File(source));
        }
        let inside = child(node, "ParameterMapping");
        let inside = inside.ok_or_else(|| missing(node, "the attribute \"source\" or a <ParameterMapping>"))?;
        mapping_entries(inside, lines).map(Mapping::Inline)
    });
    Ok(Binding {
        values,
        prefix: optional(node, "prefix").unwrap_or_default(),
        mapping: mapping.transpose()?,
        line: Line(lines.of_node(node)),
    })
}

/// Files inside FMUs are not looked for.
fn no_component_base(node: Node) -> Result<()> {
    match node.attribute("sourceBase") {
        Some("component") => {
            Err(unsupported(node, "sourceBase=\"component\"", "put the file beside the .ssd file, in resources"))
        }
        _ => Ok(()),
    }
}

fn mapping_entries(node: Node, lines: &Lines) -> Result<Vec<MappingEntry>> {
    let entries = node.children().filter(|child| child.has_tag_name((namespace::SSM, "MappingEntry")));
    entries
        .map(|node| {
            for kind in ["Boolean", "Integer", "Enumeration"] {
                if let Some(table) = child(node, &format!("{kind}MappingTransformation")) {
                    let what = format!("the {kind}MappingTransformation of a parameter");
                    return Err(unsupported(table, &what, "write the value itself"));
                }
            }
            let linear = child(node, "LinearTransformation").map(|node| {
                Ok::<_, DocumentError>((number(node, "factor")?.unwrap_or(1.0), number(node, "offset")?.unwrap_or(0.0)))
            });
            Ok(MappingEntry {
                source: required(node, "source")?.to_owned(),
                target: required(node, "target")?.to_owned(),
                linear: linear.transpose()?,
                line: Line(lines.of_node(node)),
            })
        })
        .collect()
}

fn parameters(node: Node, lines: &Lines) -> Result<ParameterSet> {
    version(node)?;
    let enumeration = |node: Node| {
        let items = elements(node, "Item").map(|item| {
            Ok(Item { name: required(item, "name")?.to_owned(), value: needed(item, "value")?, description: None })
        });
        Ok((required(node, "name")?.to_owned(), items.collect::<Result<_>>()?))
    };
    Ok(ParameterSet {
        name: required(node, "name")?.to_owned(),
        description: optional(node, "description"),
        parameters: listed(node, "Parameters").map(|node| parameter(node, lines)).collect::<Result<_>>()?,
        enumerations: listed(node, "Enumerations").map(enumeration).collect::<Result<_>>()?,
        units: units(node)?,
        origin: origin(node),
    })
}

fn parameter(node: Node, lines: &Lines) -> Result<Parameter> {
    let typed = BaseType::ALL.iter().find_map(|base_type| Some((*base_type, child(node, base_type.name())?)));
    let Some((base_type, typed)) = typed else {
        return Err(match child(node, "Binary") {
            Some(binary) => {
                unsupported(binary, &named("the binary parameter", node), "FMI 2.0 has no binary variables")
            }
            None => missing(node, "a value (Real, Integer, Boolean, String or Enumeration)").into(),
        });
    };
    let text = required(typed, "value")?;
    let (value, refers_to) = match base_type {
        BaseType::Real => (Value::Real(needed(typed, "value")?), optional(typed, "unit").into()),
        BaseType::Integer => (Value::Integer(needed(typed, "value")?), Reference::Nothing),
        BaseType::Boolean => (Value::Boolean(truth(typed, "value")?.unwrap_or_default()), Reference::Nothing),
        BaseType::String => (Value::from(text), Reference::Nothing),
        BaseType::Enumeration => (Value::from(text), Reference::Enumeration(optional(typed, "name"))),
    };
    Ok(Parameter { name: required(node, "name")?.to_owned(), value, refers_to, line: Line(lines.of_node(node)) })
}

fn units(node: Node) -> Result<Vec<Unit>> {
    listed(node, "Units")
        .map(|node| {
            let base = child(node, "BaseUnit").ok_or_else(|| missing(node, "the child <BaseUnit>"))?;
            let mut exponents = [0; 8];
            for (exponent, symbol) in exponents.iter_mut().zip(BASE_UNITS) {
                *exponent = number(base, symbol)?.unwrap_or(0);
            }
            Ok(Unit {
                name: required(node, "name")?.to_owned(),
                exponents,
                factor: number(base, "factor")?.unwrap_or(1.0),
                offset: number(base, "offset")?.unwrap_or(0.0),
                has_base_unit: true,
                display_units: Vec::new(),
            })
        })
        .collect()
}

/// The step size that `libcosim`, or else `OMSimulator`, would use.
fn step(experiment: Option<Node>, system: Node) -> Result<Option<f64>> {
    match annotated(experiment, (namespace::OSP, "FixedStepAlgorithm"), "baseStepSize")? {
        Some(step) => Ok(Some(step)),
        None => annotated(Some(system), (namespace::OMS, "FixedStepMaster"), "stepSize"),
    }
}

/// A number of an element in the annotations.
fn annotated(node: Option<Node>, element: (&'static str, &'static str), attribute: &str) -> Result<Option<f64>> {
    let annotations = node.and_then(|node| child(node, "Annotations"));
    let found = annotations.and_then(|node| node.descendants().find(|node| node.has_tag_name(element)));
    Ok(found.map(|node| number(node, attribute)).transpose()?.flatten())
}

fn unsupported(node: Node, what: &str, instead: &'static str) -> DocumentError {
    DocumentError::Unsupported { what: what.to_owned(), instead, line: line(node) }
}

fn named(what: &str, node: Node) -> String {
    format!("{what} \"{}\"", node.attribute("name").unwrap_or_default())
}
