//! From a package to what the master needs: wires between variables, and values for parameters.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::error::{DocumentError, SspError};
use super::package::{BoundSet, Package};
use super::parameters::Parameter;
use super::structure::{Component, Connection, Connector, End, Kind, Line};
use crate::names::best;
use crate::settings::Setting;
use crate::system::Located;
use crate::units::{Conversion, Units};
use crate::wiring::{Misfit, Terminal, Wire, fit};
use fmi2_import::description::BaseType;
use fmi2_import::{Causality, ModelDescription, Value, Variable, VariableType};

/// Parameters that the bindings of a package may apply, each counted as often as it is bound.
const MAX_APPLIED: usize = 10_000_000;

/// Connections and values.
#[derive(Debug, Clone, Default)]
pub struct Resolved {
    /// Connections between components.
    pub wires: Vec<Wire>,
    /// Parameters and start values, each variable once.
    pub settings: Vec<Located<Setting>>,
    /// Parameters that no variable is named after: the standard says to ignore them, their author may want to know.
    pub remarks: Vec<String>,
}

/// Finds the variables that a package's connections and parameters mean. `descriptions` belong to its components, in
/// their order.
///
/// # Errors
/// When a connection or a connector does not fit the FMUs, or needs something this tool does not support.
pub fn resolve(package: &Package, descriptions: &[&ModelDescription]) -> std::result::Result<Resolved, SspError> {
    let units: Vec<_> = descriptions.iter().map(|description| Units::of(description)).collect();
    let resolver = Resolver::new(package, descriptions, &units);
    let connections = resolver.connections().map_err(|error| package.error(error))?;
    let mut values = Values { driven: connections.wires.iter().map(|wire| wire.to).collect(), ..Values::default() };
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
    let remarks = connections.remarks.into_iter().chain(values.remarks).collect();
    Ok(Resolved { wires: connections.wires, settings: values.settings.into_iter().flatten().collect(), remarks })
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

/// Factor and offset of a transformation, if there is one.
type Linear = Option<(f64, f64)>;

/// What the connections of a package mean.
#[derive(Default)]
struct Connections<'a> {
    wires: Vec<Wire>,
    /// The variables behind each connector of the system.
    aliases: HashMap<&'a str, Vec<Terminal>>,
    remarks: Vec<String>,
}

/// What the parameters of a package mean. The later of two values for one variable holds.
#[derive(Default)]
struct Values {
    driven: HashSet<Terminal>,
    settings: Vec<Option<Located<Setting>>>,
    latest: HashMap<Terminal, usize>,
    remarks: Vec<String>,
    remarked: HashSet<(String, u32)>,
    applied: usize,
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

    fn components(&self) -> &'a [Component] {
        &self.package.structure().system.components
    }

    fn connections(&self) -> Result<Connections<'a>> {
        let mut found = Connections::default();
        let mut driven = HashSet::new();
        for connection in &self.package.structure().system.connections {
            let (start, start_kind) = self.end(&connection.start, connection.line)?;
            let (end, end_kind) = self.end(&connection.end, connection.line)?;
            match (start, end) {
                (Some(start), Some(end)) => {
                    let (wire, remark) = self.wire(connection, (start, start_kind), (end, end_kind))?;
                    if !driven.insert(wire.to) {
                        let problem = format!("{} has two sources", self.name(wire.to));
                        return Err(DocumentError::Conflict { problem, line: connection.line.0 });
                    }
                    found.wires.push(wire);
                    found.remarks.extend(remark);
                }
                (None, Some(inside)) | (Some(inside), None) if start_kind == end_kind => {
                    let outside = if start.is_none() { &connection.start } else { &connection.end };
                    found.aliases.entry(&outside.connector).or_default().push(inside);
                }
                (None, Some(_)) | (Some(_), None) => {
                    let problem = format!(
                        "{} and {} are of different kinds; between a system and its component they must be equal",
                        shown(&connection.start),
                        shown(&connection.end)
                    );
                    return Err(DocumentError::Conflict { problem, line: connection.line.0 });
                }
                (None, None) => {
                    return Err(DocumentError::Unsupported {
                        what: "a connection of the system with itself".into(),
                        instead: "connect components",
                        line: connection.line.0,
                    });
                }
            }
        }
        Ok(found)
    }

    /// The variable behind one end of a connection (`None` for a connector of the system) and its kind.
    fn end(&self, end: &'a End, line: Line) -> Result<(Option<Terminal>, Kind)> {
        let Some(element) = &end.element else {
            let connector = self.connector(self.components().len(), &end.connector, "the system", line)?;
            return Ok((None, connector.kind));
        };
        let Some(&index) = self.indices.get(element.as_str()) else {
            return Err(DocumentError::Unknown {
                what: format!("component \"{element}\""),
                similar: best(element, self.components().iter().map(|component| component.name.as_str())),
                line: line.0,
            });
        };
        let connector = self.connector(index, &end.connector, &format!("\"{element}\""), line)?;
        let variable = self.variable(index, connector)?;
        Ok((Some(Terminal { component: index, variable }), connector.kind))
    }

    fn connector(&self, element: usize, name: &str, owner: &str, line: Line) -> Result<&'a Connector> {
        self.connectors[element].get(name).copied().ok_or_else(|| DocumentError::Unknown {
            what: format!("connector \"{name}\" of {owner}"),
            similar: best(name, self.connectors[element].keys().copied()),
            line: line.0,
        })
    }

    /// The variable of a component's connector, which must be as the connector says.
    fn variable(&self, component: usize, connector: &Connector) -> Result<usize> {
        let description = self.descriptions[component];
        let line = connector.line.0;
        let Some(index) = description.index_of(&connector.name) else {
            let names = description.variables.iter().map(|variable| variable.name.as_str());
            return Err(DocumentError::Unknown {
                what: format!("variable \"{}\" in {}", connector.name, description.model_name),
                similar: best(&connector.name, names),
                line,
            });
        };
        let variable = &description.variables[index];
        let fits = match connector.kind {
            Kind::Input => variable.causality == Causality::Input,
            Kind::Output => variable.causality == Causality::Output,
            Kind::Parameter => variable.causality == Causality::Parameter,
            Kind::CalculatedParameter => variable.causality == Causality::CalculatedParameter,
        };
        if !fits || connector.base_type.is_some_and(|base_type| !is_of_type(variable, base_type)) {
            let problem = format!(
                "the connector \"{}\" differs from the FMU's variable in kind or type ({:?} {:?})",
                connector.name,
                variable.causality,
                variable.base_type()
            );
            return Err(DocumentError::Conflict { problem, line });
        }
        Ok(index)
    }

    /// A wire from the output to the input, whichever of the two is the start.
    fn wire(
        &self,
        connection: &Connection,
        start: (Terminal, Kind),
        end: (Terminal, Kind),
    ) -> Result<(Wire, Option<String>)> {
        let line = connection.line.0;
        let (from, to) = match (start.1, end.1) {
            (Kind::Output, Kind::Input) => (start.0, end.0),
            (Kind::Input, Kind::Output) => (end.0, start.0),
            (Kind::CalculatedParameter, Kind::Parameter) | (Kind::Parameter, Kind::CalculatedParameter) => {
                return Err(DocumentError::Unsupported {
                    what: format!("the connection of parameters {} and {}", self.name(start.0), self.name(end.0)),
                    instead: "set the parameters by a parameter set",
                    line,
                });
            }
            _ => {
                let problem = format!(
                    "{} and {} cannot be connected; one must be an output, the other an input",
                    self.name(start.0),
                    self.name(end.0)
                );
                return Err(DocumentError::Conflict { problem, line });
            }
        };
        let in_units = |terminal: Terminal| (self.described(terminal), &self.units[terminal.component]);
        match fit(in_units(from), in_units(to)) {
            Ok((conversion, remark)) => {
                let conversion = conversion.filter(|_| !connection.suppress_unit_conversion);
                let remark = remark.filter(|_| !connection.suppress_unit_conversion);
                let remark = remark.map(|remark| format!("{} → {}: {remark}", self.name(from), self.name(to)));
                Ok((Wire { from, to, conversion }, remark))
            }
            Err(Misfit::Units(_)) if connection.suppress_unit_conversion => {
                Ok((Wire { from, to, conversion: None }, None))
            }
            Err(Misfit::Text) => Err(DocumentError::Unsupported {
                what: format!("the connection of text from {}", self.name(from)),
                instead: "connect numbers or Booleans",
                line,
            }),
            Err(misfit) => {
                let problem = format!("{} cannot feed {}: {misfit}", self.name(from), self.name(to));
                Err(DocumentError::Conflict { problem, line })
            }
        }
    }

    fn described(&self, terminal: Terminal) -> &'a Variable {
        &self.descriptions[terminal.component].variables[terminal.variable]
    }

    /// `component.variable`.
    fn name(&self, terminal: Terminal) -> String {
        format!("{}.{}", self.components()[terminal.component].name, self.described(terminal).name)
    }

    /// What a name in a parameter set of the system means.
    fn hierarchical(&self, name: &str, aliases: &HashMap<&str, Vec<Terminal>>) -> Option<Vec<Terminal>> {
        let mut meant = aliases.get(name).cloned().unwrap_or_default();
        // A component's name may have dots, and so may a variable's.
        let dots = name.bytes().take(self.longest_name + 1).enumerate().filter(|(_, byte)| *byte == b'.');
        for (at, _) in dots {
            let Some(&component) = self.indices.get(&name[..at]) else { continue };
            let variable = self.descriptions[component].index_of(&name[at + 1..]);
            meant.extend(variable.map(|variable| Terminal { component, variable }));
        }
        (!meant.is_empty()).then_some(meant)
    }

    /// Adds the settings of one parameter set; `find` knows what a name means.
    fn apply(
        &self,
        bound: &BoundSet,
        values: &mut Values,
        find: &dyn Fn(&str) -> Option<Vec<Terminal>>,
    ) -> std::result::Result<(), SspError> {
        let units = Units::among(&bound.set.units);
        let parameters = mapped(bound);
        values.applied += parameters.len();
        if let Some((_, parameter, _)) = parameters.first().filter(|_| values.applied > MAX_APPLIED) {
            let error = DocumentError::TooMany { most: MAX_APPLIED, line: parameter.line.0 };
            return Err(self.package.error_in(&bound.document, error));
        }
        for (name, parameter, linear) in parameters {
            let Some(meant) = find(&name) else {
                if values.remarked.insert((bound.document.clone(), parameter.line.0)) {
                    let place = self.package.place(&bound.document, parameter.line);
                    values.remarks.push(format!("{place}: \"{name}\" names no variable; it is ignored"));
                }
                continue;
            };
            for terminal in meant {
                // A start value of a connected input lasts until the first exchange.
                if values.driven.contains(&terminal) {
                    continue;
                }
                let value = self
                    .value(parameter, linear, &units, terminal)
                    .map_err(|error| self.package.error_in(&bound.document, error))?;
                let place = Some(self.package.place(&bound.document, parameter.line));
                let setting = Located { item: Setting::new(self.name(terminal), value), place };
                if let Some(former) = values.latest.insert(terminal, values.settings.len()) {
                    values.settings[former] = None;
                }
                values.settings.push(Some(setting));
            }
        }
        Ok(())
    }

    /// A parameter's value in the unit of the variable.
    fn value(&self, parameter: &Parameter, linear: Linear, units: &Units, terminal: Terminal) -> Result<Value> {
        let mut number = match (&parameter.value, linear) {
            (Value::Real(number), _) => *number,
            (Value::Integer(number), Some(_)) => f64::from(*number),
            (whole_or_no_number, _) => return Ok(whole_or_no_number.clone()),
        };
        let unit = parameter.refers_to.unit();
        let line = parameter.line.0;
        let variable = self.described(terminal);
        let wanted = variable.unit().and_then(|name| self.units[terminal.component].named(name));
        if let (Some(name), Some(wanted)) = (unit, wanted)
            && name != wanted.name
        {
            let Some(given) = units.named(name) else {
                let what = format!("unit \"{name}\" in the document");
                return Err(DocumentError::Unknown { what, similar: best(name, units.names()), line });
            };
            let is_difference = matches!(&variable.kind, VariableType::Real(real) if real.relative_quantity);
            let conversion = Conversion::between(given, wanted, (is_difference, is_difference)).map_err(|error| {
                DocumentError::Conflict { problem: format!("{}: {error}", self.name(terminal)), line }
            })?;
            number = conversion.map_or(number, |conversion| conversion.apply(number));
        }
        if let Some((factor, offset)) = linear {
            number = factor * number + offset;
        }
        Ok(Value::Real(number))
    }
}

/// Whether a connector of this type can stand for a variable: as with connections, integers and items of enumerations
/// are the same numbers.
fn is_of_type(variable: &Variable, base_type: BaseType) -> bool {
    let is_integer = |base_type| matches!(base_type, BaseType::Integer | BaseType::Enumeration);
    let own = variable.base_type();
    own == base_type || (is_integer(own) && is_integer(base_type))
}

/// The parameters of a set under the names they are applied to, with the transformation of the mapping.
fn mapped(bound: &BoundSet) -> Vec<(String, &Parameter, Linear)> {
    let prefixed = |name: &str| format!("{}{name}", bound.prefix);
    let Some(entries) = &bound.mapping else {
        return bound.set.parameters.iter().map(|parameter| (prefixed(&parameter.name), parameter, None)).collect();
    };
    let parameters: HashMap<_, _> =
        bound.set.parameters.iter().rev().map(|parameter| (prefixed(&parameter.name), parameter)).collect();
    entries
        .iter()
        .filter_map(|entry| Some((entry.target.clone(), *parameters.get(&entry.source)?, entry.linear)))
        .collect()
}

fn shown(end: &End) -> String {
    match &end.element {
        Some(element) => format!("{element}.{}", end.connector),
        None => format!("{} of the system", end.connector),
    }
}
