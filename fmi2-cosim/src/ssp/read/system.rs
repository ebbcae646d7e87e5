//! `<System>` of an SSD: components, connectors, connections and bindings.

use fmi2_import::document::Lines;
use roxmltree::Node;

use super::{Result, named, parameters, unique, unsupported};
use crate::ssp::structure::{
    Binding, ComponentElement, Connection, Connector, End, Extent, Kind, Line, Mapping, Point, SystemElement, Values,
};
use fmi2_import::description::BaseType;
use fmi2_import::xml::{child, listed, missing, needed, optional, required, wrong};

const FMU_TYPE: &str = "application/x-fmu-sharedlibrary";

pub(super) fn read(node: Node, lines: &Lines) -> Result<SystemElement> {
    if let Some(dictionary) = child(node, "SignalDictionaries") {
        return Err(unsupported(dictionary, "signal dictionaries", "connect the components directly"));
    }
    let components = listed(node, "Elements").map(|node| component(node, lines)).collect::<Result<Vec<_>>>()?;
    unique("components", components.iter().map(|component| (component.name.as_str(), component.line)))?;
    Ok(SystemElement {
        name: required(node, "name")?.to_owned(),
        description: optional(node, "description"),
        connectors: connectors(node, lines)?,
        bindings: listed(node, "ParameterBindings").map(|node| binding(node, lines)).collect::<Result<_>>()?,
        components,
        connections: listed(node, "Connections").map(|node| connection(node, lines)).collect::<Result<_>>()?,
        canvas: child(node, "SystemGeometry").map(extent).transpose()?,
    })
}

fn component(node: Node, lines: &Lines) -> Result<ComponentElement> {
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
    Ok(ComponentElement {
        name: required(node, "name")?.to_owned(),
        description: optional(node, "description"),
        source: required(node, "source")?.to_owned(),
        connectors: connectors(node, lines)?,
        extent: child(node, "ElementGeometry").map(extent).transpose()?,
        bindings: listed(node, "ParameterBindings").map(|node| binding(node, lines)).collect::<Result<_>>()?,
        line: Line(lines.of_node(node)),
    })
}

fn connectors(node: Node, lines: &Lines) -> Result<Vec<Connector>> {
    let connectors = listed(node, "Connectors").map(|node| connector(node, lines)).collect::<Result<Vec<_>>>()?;
    unique("connectors of one element", connectors.iter().map(|connector| (connector.name.as_str(), connector.line)))?;
    Ok(connectors)
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
        Values::Inline(parameters::set(set, lines)?)
    };
    let mapping = child(node, "ParameterMapping").map(|node| {
        no_component_base(node)?;
        if let Some(source) = optional(node, "source") {
            return Ok(Mapping::File(source));
        }
        let inside = child(node, "ParameterMapping");
        let inside = inside.ok_or_else(|| missing(node, "the attribute \"source\" or a <ParameterMapping>"))?;
        parameters::mapping(inside, lines).map(Mapping::Inline)
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
