//! From a package to what the master needs: wires between variables, and values for parameters.

use super::error::{DocumentError, SspError};
use super::package::{BoundSet, Package};
use super::parameters::{Parameter, Value};
use super::structure::{Component, Connection, Connector, End, Kind, Line};
use crate::names::closest;
use crate::settings::Setting;
use crate::system::Located;
use crate::wiring::{Terminal, Wire};
use fmi2_import::description::{BaseType, Unit};
use fmi2_import::{Causality, ModelDescription};

/// Connections and values.
#[derive(Debug, Clone, Default)]
pub struct Resolved {
    /// Connections between components.
    pub wires: Vec<Wire>,
    /// Parameters and start values, those that count more later.
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
    let resolver = Resolver { package, descriptions };
    let (wires, aliases) = resolver.connections().map_err(|error| package.error(error))?;
    let mut resolved = Resolved { wires, ..Resolved::default() };
    for (index, description) in descriptions.iter().enumerate() {
        for bound in package.component_sets(index) {
            resolver.apply(bound, &mut resolved, &|name| {
                description.index_of(name).map(|variable| vec![Terminal { component: index, variable }])
            })?;
        }
    }
    for bound in package.system_sets() {
        resolver.apply(bound, &mut resolved, &|name| resolver.hierarchical(name, &aliases))?;
    }
    Ok(resolved)
}

/// Factor and offset of a transformation, if there is one.
type Linear = Option<(f64, f64)>;

/// A connector of the system and the variable behind it.
type Alias<'a> = (&'a str, Terminal);

struct Resolver<'a> {
    package: &'a Package,
    descriptions: &'a [&'a ModelDescription],
}

type Result<T> = std::result::Result<T, DocumentError>;

impl<'a> Resolver<'a> {
    fn components(&self) -> &'a [Component] {
        &self.package.structure().system.components
    }

    fn connections(&self) -> Result<(Vec<Wire>, Vec<Alias<'a>>)> {
        let mut wires: Vec<Wire> = Vec::new();
        let mut aliases = Vec::new();
        for connection in &self.package.structure().system.connections {
            let (start, start_kind) = self.end(&connection.start, connection.line)?;
            let (end, end_kind) = self.end(&connection.end, connection.line)?;
            match (start, end) {
                (Some(start), Some(end)) => {
                    let wire = self.wire(connection, (start, start_kind), (end, end_kind))?;
                    if wires.iter().any(|other| other.to == wire.to) {
                        let problem = format!("{} has two sources", self.name(wire.to));
                        return Err(DocumentError::Conflict { problem, line: connection.line.0 });
                    }
                    wires.push(wire);
                }
                (None, Some(inside)) | (Some(inside), None) if start_kind == end_kind => {
                    let outside = if start.is_none() { &connection.start } else { &connection.end };
                    aliases.push((outside.connector.as_str(), inside));
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
        Ok((wires, aliases))
    }

    /// The variable behind one end of a connection (`None` for a connector of the system) and its kind.
    fn end(&self, end: &'a End, line: Line) -> Result<(Option<Terminal>, Kind)> {
        let Some(element) = &end.element else {
            let connectors = &self.package.structure().system.connectors;
            let connector = find_connector(connectors, &end.connector, "the system", line)?;
            return Ok((None, connector.kind));
        };
        let components = self.components();
        let Some(index) = components.iter().position(|component| component.name == *element) else {
            return Err(DocumentError::Unknown {
                what: format!("component \"{element}\""),
                similar: best(element, components.iter().map(|component| component.name.as_str())),
                line: line.0,
            });
        };
        let connector = find_connector(&components[index].connectors, &end.connector, &format!("\"{element}\""), line)?;
        let variable = self.variable(index, connector)?;
        Ok((Some(Terminal { component: index, variable }), connector.kind))
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
        if !fits || connector.base_type.is_some_and(|base_type| base_type != variable.base_type()) {
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
    fn wire(&self, connection: &Connection, start: (Terminal, Kind), end: (Terminal, Kind)) -> Result<Wire> {
        let line = connection.line.0;
        let wire = match (start.1, end.1) {
            (Kind::Output, Kind::Input) => Wire { from: start.0, to: end.0 },
            (Kind::Input, Kind::Output) => Wire { from: end.0, to: start.0 },
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
        let type_of = |terminal: Terminal| -> BaseType {
            self.descriptions[terminal.component].variables[terminal.variable].base_type()
        };
        if type_of(wire.from) != type_of(wire.to) {
            let problem = format!(
                "{} is {:?}, {} is {:?}",
                self.name(wire.from),
                type_of(wire.from),
                self.name(wire.to),
                type_of(wire.to)
            );
            return Err(DocumentError::Conflict { problem, line });
        }
        if type_of(wire.from) == BaseType::String {
            return Err(DocumentError::Unsupported {
                what: format!("the connection of text from {}", self.name(wire.from)),
                instead: "connect numbers or Booleans",
                line,
            });
        }
        if !connection.suppress_unit_conversion
            && let (Some(from), Some(to)) = (self.unit(wire.from), self.unit(wire.to))
            && !same_scale(from, to)
        {
            return Err(DocumentError::Unsupported {
                what: format!(
                    "the conversion from {} in {} to {} in {}",
                    self.name(wire.from),
                    from.name,
                    self.name(wire.to),
                    to.name
                ),
                instead: "use equal units, or suppressUnitConversion=\"true\"",
                line,
            });
        }
        Ok(wire)
    }

    fn unit(&self, terminal: Terminal) -> Option<&'a Unit> {
        let description = self.descriptions[terminal.component];
        let name = description.variables[terminal.variable].unit()?;
        description.units.iter().find(|unit| unit.name == name && unit.has_base_unit)
    }

    /// `component.variable`.
    fn name(&self, terminal: Terminal) -> String {
        let component = &self.components()[terminal.component].name;
        let variable = &self.descriptions[terminal.component].variables[terminal.variable].name;
        format!("{component}.{variable}")
    }

    /// What a name in a parameter set of the system means.
    fn hierarchical(&self, name: &str, aliases: &[Alias<'_>]) -> Option<Vec<Terminal>> {
        let mut meant: Vec<_> =
            aliases.iter().filter(|(alias, _)| *alias == name).map(|(_, terminal)| *terminal).collect();
        for (index, component) in self.components().iter().enumerate() {
            let local = name.strip_prefix(&component.name).and_then(|rest| rest.strip_prefix('.'));
            let variable = local.and_then(|local| self.descriptions[index].index_of(local));
            meant.extend(variable.map(|variable| Terminal { component: index, variable }));
        }
        (!meant.is_empty()).then_some(meant)
    }

    /// Adds the settings of one parameter set; `find` knows what a name means.
    fn apply(
        &self,
        bound: &BoundSet,
        resolved: &mut Resolved,
        find: &dyn Fn(&str) -> Option<Vec<Terminal>>,
    ) -> std::result::Result<(), SspError> {
        for (name, parameter, linear) in mapped(bound) {
            let Some(meant) = find(&name) else {
                let place = self.package.place(&bound.document, parameter.line);
                resolved.remarks.push(format!("{place}: \"{name}\" names no variable; it is ignored"));
                continue;
            };
            for terminal in meant {
                // A start value of a connected input lasts until the first exchange.
                if resolved.wires.iter().any(|wire| wire.to == terminal) {
                    continue;
                }
                let value = self
                    .value(parameter, linear, &bound.set.units, terminal)
                    .map_err(|error| self.package.error_in(&bound.document, error))?;
                let place = Some(self.package.place(&bound.document, parameter.line));
                resolved.settings.push(Located { item: Setting::new(self.name(terminal), value), place });
            }
        }
        Ok(())
    }

    /// A parameter's value as text, in the unit of the variable.
    fn value(&self, parameter: &Parameter, linear: Linear, units: &[Unit], terminal: Terminal) -> Result<String> {
        let (number, unit) = match (&parameter.value, linear) {
            (Value::Real(number, unit), _) => (*number, unit.as_deref()),
            (Value::Integer(number), Some(_)) => (f64::from(*number), None),
            (Value::Integer(number), None) => return Ok(number.to_string()),
            (Value::Boolean(value), _) => return Ok(value.to_string()),
            (Value::String(text) | Value::Enumeration(text, _), _) => return Ok(text.clone()),
        };
        let line = parameter.line.0;
        let mut number = number;
        let wanted = self.unit(terminal);
        if let (Some(name), Some(wanted)) = (unit, wanted)
            && name != wanted.name
        {
            let Some(given) = units.iter().find(|unit| unit.name == name) else {
                let names = units.iter().map(|unit| unit.name.as_str());
                let what = format!("unit \"{name}\" in the document");
                return Err(DocumentError::Unknown { what, similar: best(name, names), line });
            };
            if given.exponents != wanted.exponents {
                let target = self.name(terminal);
                let problem = format!("{target} is in {}, which {name} cannot be converted to", wanted.name);
                return Err(DocumentError::Conflict { problem, line });
            }
            number = (given.factor * number + given.offset - wanted.offset) / wanted.factor;
        }
        if let Some((factor, offset)) = linear {
            number = factor * number + offset;
        }
        let is_real = self.descriptions[terminal.component].variables[terminal.variable].base_type() == BaseType::Real;
        Ok(if is_real { format!("{number:?}") } else { number.to_string() })
    }
}

/// The parameters of a set under the names they are applied to, with the transformation of the mapping.
fn mapped(bound: &BoundSet) -> Vec<(String, &Parameter, Linear)> {
    let prefixed = |name: &str| format!("{}{name}", bound.prefix);
    match &bound.mapping {
        None => bound.set.parameters.iter().map(|parameter| (prefixed(&parameter.name), parameter, None)).collect(),
        Some(entries) => entries
            .iter()
            .filter_map(|entry| {
                let parameter = bound.set.parameters.iter().find(|parameter| prefixed(&parameter.name) == entry.source);
                Some((entry.target.clone(), parameter?, entry.linear))
            })
            .collect(),
    }
}

/// The name that comes closest, if one does.
fn best<'n>(wanted: &str, names: impl Iterator<Item = &'n str>) -> Option<String> {
    closest(wanted, names).first().map(ToString::to_string)
}

fn find_connector<'c>(connectors: &'c [Connector], name: &str, owner: &str, line: Line) -> Result<&'c Connector> {
    connectors.iter().find(|connector| connector.name == name).ok_or_else(|| DocumentError::Unknown {
        what: format!("connector \"{name}\" of {owner}"),
        similar: best(name, connectors.iter().map(|connector| connector.name.as_str())),
        line: line.0,
    })
}

fn shown(end: &End) -> String {
    match &end.element {
        Some(element) => format!("{element}.{}", end.connector),
        None => format!("{} of the system", end.connector),
    }
}

fn same_scale(a: &Unit, b: &Unit) -> bool {
    a.exponents == b.exponents && a.factor == b.factor && a.offset == b.offset
}
