//! Converts a package to the master's input: wires between variables ([`connections`]), and values for parameters
//! ([`values`]).

mod connections;
mod values;

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::error::{DocumentError, SspError};
use super::package::{BoundSet, Package};
use super::structure::{ComponentElement, Connector};
use crate::system::Located;
use crate::units::Units;
use crate::wiring::{Terminal, Wire};
use fmi2_import::{ModelDescription, Value, Variable};
use values::Values;

/// Connections and values.
#[derive(Debug, Clone, Default)]
pub struct Resolved {
    /// Connections between components.
    pub wires: Vec<Wire>,
    /// Parameters and start values, each variable once.
    pub values: Vec<Located<(Terminal, Value)>>,
    /// Remarks on parameters without a variable of their name. The standard says to ignore such parameters; the author may
    /// want to know of them.
    pub remarks: Vec<String>,
}

/// Finds the variables that a package's connections and parameters mean. `descriptions` are those of its components, in
/// the same order.
///
/// # Errors
/// When a connection or a connector does not fit the FMUs, or needs features that this tool does not support.
pub fn resolve(package: &Package, descriptions: &[&ModelDescription]) -> std::result::Result<Resolved, SspError> {
    let units: Vec<_> = descriptions.iter().map(|description| Units::of(description)).collect();
    let resolver = Resolver::new(package, descriptions, &units);
    let connections = resolver.connections().map_err(|error| package.error(error))?;
    let mut values = Values::of(descriptions.len(), &connections.wires);
    for (index, description) in descriptions.iter().enumerate() {
        for bound in once_each(package.component_sets(index)) {
            resolver.apply(bound, &mut values, &|name| {
                description.index_of(name).map(|variable| vec![Terminal { component: index, variable }])
            })?;
        }
    }
    for bound in once_each(package.system_sets()) {
        resolver.apply(bound, &mut values, &|name| resolver.hierarchical(name, &connections.aliases))?;
    }
    let remarks = connections.doubts.into_remarks().into_iter().chain(values.remarks).collect();
    Ok(Resolved { wires: connections.wires, values: values.found.into_iter().flatten().collect(), remarks })
}

/// The bindings without those that a later one repeats.
fn once_each(bound: &[BoundSet]) -> Vec<&BoundSet> {
    let mut seen = HashSet::new();
    let mut kept: Vec<_> = bound
        .iter()
        .rev()
        .filter(|bound| {
            seen.insert((Arc::as_ptr(&bound.set), bound.mapping.as_ref().map(Arc::as_ptr), bound.prefix.as_str()))
        })
        .collect();
    kept.reverse();
    kept
}

struct Resolver<'a> {
    package: &'a Package,
    descriptions: &'a [&'a ModelDescription],
    units: &'a [Units<'a>],
    /// Indices of the components by their names.
    indices: HashMap<&'a str, usize>,
    longest_name: usize,
    /// The connectors of each component by their names, those of the system last.
    connectors: Vec<HashMap<&'a str, &'a Connector>>,
}

type Result<T> = std::result::Result<T, DocumentError>;

impl<'a> Resolver<'a> {
    fn new(package: &'a Package, descriptions: &'a [&'a ModelDescription], units: &'a [Units<'a>]) -> Self {
        let system = &package.structure().system;
        let by_name = |connectors: &'a [Connector]| {
            connectors.iter().rev().map(|connector| (connector.name.as_str(), connector)).collect()
        };
        let lists = system.components.iter().map(|component| component.connectors.as_slice());
        let names = || system.components.iter().map(|component| component.name.as_str());
        Self {
            package,
            descriptions,
            units,
            indices: names().zip(0..).collect(),
            longest_name: names().map(str::len).max().unwrap_or(0),
            connectors: lists.chain([system.connectors.as_slice()]).map(by_name).collect(),
        }
    }

    fn components(&self) -> &'a [ComponentElement] {
        &self.package.structure().system.components
    }

    fn described(&self, terminal: Terminal) -> &'a Variable {
        &self.descriptions[terminal.component].variables[terminal.variable]
    }

    /// `component.variable`.
    fn name(&self, terminal: Terminal) -> String {
        format!("{}.{}", self.components()[terminal.component].name, self.described(terminal).name)
    }
}
