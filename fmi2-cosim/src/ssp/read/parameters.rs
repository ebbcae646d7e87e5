//! Parameter sets and their mappings: SSV, SSM and the same elements inside an SSD.

use fmi2_import::document::Lines;
use roxmltree::Node;

use super::{Result, named, origin, unique, units, unsupported, version};
use crate::ssp::error::DocumentError;
use crate::ssp::namespace;
use crate::ssp::parameters::{ParameterSet, ParameterValue, Reference};
use crate::ssp::structure::{Line, MappingEntry};
use fmi2_import::Value;
use fmi2_import::description::{BaseType, Item};
use fmi2_import::xml::{child, elements, listed, missing, needed, number, optional, required, truth};

pub(super) fn set(node: Node, lines: &Lines) -> Result<ParameterSet> {
    version(node)?;
    let enumeration = |node: Node| {
        let items = elements(node, "Item").map(|item| {
            Ok(Item { name: required(item, "name")?.to_owned(), value: needed(item, "value")?, description: None })
        });
        Ok((required(node, "name")?.to_owned(), items.collect::<Result<_>>()?))
    };
    let parameters = listed(node, "Parameters").map(|node| parameter(node, lines)).collect::<Result<Vec<_>>>()?;
    unique("parameters of one set", parameters.iter().map(|parameter| (parameter.name.as_str(), parameter.line)))?;
    Ok(ParameterSet {
        name: required(node, "name")?.to_owned(),
        description: optional(node, "description"),
        parameters,
        enumerations: listed(node, "Enumerations").map(enumeration).collect::<Result<_>>()?,
        units: units(node)?,
        origin: origin(node),
    })
}

fn parameter(node: Node, lines: &Lines) -> Result<ParameterValue> {
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
    Ok(ParameterValue { name: required(node, "name")?.to_owned(), value, refers_to, line: Line(lines.of_node(node)) })
}

pub(super) fn mapping(node: Node, lines: &Lines) -> Result<Vec<MappingEntry>> {
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
