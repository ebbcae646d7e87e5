//! Reads SSD, SSV and SSM documents from XML. A feature that this tool cannot run is an error that names the element and
//! its line.

mod parameters;
mod system;

use std::collections::HashSet;

use fmi2_import::document::{self, Lines};
use roxmltree::{Document, Node};

use super::error::DocumentError;
use super::namespace;
use super::parameters::ParameterSet;
use super::structure::{DefaultExperiment, Line, MappingEntry, Origin, SystemStructure};
use fmi2_import::description::{BASE_UNITS, Unit};
use fmi2_import::xml::{child, line, listed, missing, number, optional, required};

type Result<T> = std::result::Result<T, DocumentError>;

/// Reads an `.ssd` file.
///
/// # Errors
/// When it is not an SSD of SSP 1.0, or has features that this tool does not support, such as nested systems.
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
        system: system::read(system_node, lines)?,
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
/// When it is not a parameter set of SSP 1.0, or has values of a type that FMI 2.0 lacks.
pub fn parameter_set(bytes: &[u8]) -> Result<ParameterSet> {
    let text = text(bytes)?;
    let document = document::parse(text)?;
    parameters::set(root(&document, namespace::SSV, "ParameterSet")?, &Lines::of(text))
}

/// Reads an `.ssm` file.
///
/// # Errors
/// When it is not a parameter mapping of SSP 1.0, or transforms values by tables.
pub fn parameter_mapping(bytes: &[u8]) -> Result<Vec<MappingEntry>> {
    let text = text(bytes)?;
    let document = document::parse(text)?;
    parameters::mapping(root(&document, namespace::SSM, "ParameterMapping")?, &Lines::of(text))
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

fn units(node: Node) -> Result<Vec<Unit>> {
    let units = listed(node, "Units")
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
        .collect::<Result<Vec<_>>>()?;
    unique("units", units.iter().map(|unit| (unit.name.as_str(), Line(line(node)))))?;
    Ok(units)
}

/// Names by which others refer to these must be there once.
fn unique<'a>(what: &str, mut named: impl Iterator<Item = (&'a str, Line)>) -> Result<()> {
    let mut seen = HashSet::new();
    match named.find(|(name, _)| name.is_empty() || !seen.insert(*name)) {
        None => Ok(()),
        Some(("", line)) => {
            Err(DocumentError::Conflict { problem: format!("one of the {what} has an empty name"), line: line.0 })
        }
        Some((name, line)) => {
            let problem = format!("two {what} are called \"{name}\"");
            Err(DocumentError::Conflict { problem, line: line.0 })
        }
    }
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
