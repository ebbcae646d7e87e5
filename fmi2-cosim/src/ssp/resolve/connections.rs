//! The meaning of connections: the variables that they wire, and the variables behind the connectors of the system.

use std::collections::{HashMap, HashSet};

use super::{Resolver, Result};
use crate::names::best;
use crate::ssp::error::DocumentError;
use crate::ssp::structure::{Connection, Connector, End, Kind, Line};
use crate::wiring::{Doubt, Doubts, Misfit, Terminal, Wire, fit};
use fmi2_import::description::BaseType;
use fmi2_import::{Causality, Variable};

/// The resolved connections of a package.
#[derive(Default)]
pub(super) struct Connections<'a> {
    pub wires: Vec<Wire>,
    /// The variables behind each connector of the system.
    pub aliases: HashMap<&'a str, Vec<Terminal>>,
    pub doubts: Doubts,
}

impl<'a> Resolver<'a> {
    pub(super) fn connections(&self) -> Result<Connections<'a>> {
        let mut found = Connections::default();
        let mut driven = HashSet::new();
        for connection in &self.package.structure().system.connections {
            let (start, start_kind) = self.end(&connection.start, connection.line)?;
            let (end, end_kind) = self.end(&connection.end, connection.line)?;
            match (start, end) {
                (Some(start), Some(end)) => {
                    let (wire, doubt) = self.wire(connection, (start, start_kind), (end, end_kind))?;
                    if !driven.insert(wire.to) {
                        let problem = format!("{} has two sources", self.name(wire.to));
                        return Err(DocumentError::Conflict { problem, line: connection.line.0 });
                    }
                    found.wires.push(wire);
                    if let Some(doubt) = doubt {
                        found.doubts.add(doubt, &self.name(wire.from), &self.name(wire.to));
                    }
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

    /// The variable of a component's connector, which must agree with the connector.
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
    ) -> Result<(Wire, Option<Doubt>)> {
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
            Ok((conversion, doubt)) => {
                let conversion = conversion.filter(|_| !connection.suppress_unit_conversion);
                let doubt = doubt.filter(|_| !connection.suppress_unit_conversion);
                Ok((Wire { from, to, conversion }, doubt))
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
}

/// Whether a connector of this type fits a variable. As with connections, integers and items of enumerations
/// are the same numbers.
fn is_of_type(variable: &Variable, base_type: BaseType) -> bool {
    let is_integer = |base_type| matches!(base_type, BaseType::Integer | BaseType::Enumeration);
    let own = variable.base_type();
    own == base_type || (is_integer(own) && is_integer(base_type))
}

fn shown(end: &End) -> String {
    match &end.element {
        Some(element) => format!("{element}.{}", end.connector),
        None => format!("{} of the system", end.connector),
    }
}
