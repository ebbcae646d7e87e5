//! The meaning of parameters: a value for each variable, in the variable's unit.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::{Resolver, Result};
use crate::names::best;
use crate::ssp::error::{DocumentError, SspError};
use crate::ssp::package::BoundSet;
use crate::ssp::parameters::ParameterValue;
use crate::ssp::structure::MappingEntry;
use crate::system::Located;
use crate::units::{Conversion, Units};
use crate::wiring::{Terminal, Wire};
use fmi2_import::{Value, VariableType};

/// Parameters that the bindings of a package may apply, each counted as often as it is bound.
const MAX_APPLIED: usize = 4_000_000;

/// Factor and offset of a transformation, if there is one.
type Linear = Option<(f64, f64)>;

/// The resolved parameters of a package. Of two values for one variable the later one applies.
#[derive(Default)]
pub(super) struct Values {
    driven: HashSet<Terminal>,
    pub found: Vec<Option<Located<(Terminal, Value)>>>,
    /// The index of the latest value per component and variable; an empty list for a component without values.
    latest: Vec<Vec<Option<u32>>>,
    pub remarks: Vec<String>,
    /// Documents, by the addresses of their names, and lines.
    remarked: HashSet<(*const str, u32)>,
    applied: usize,
}

impl Values {
    /// No values yet, in a system of this many components whose wires drive these inputs.
    pub fn of(components: usize, wires: &[Wire]) -> Self {
        Self {
            driven: wires.iter().map(|wire| wire.to).collect(),
            latest: vec![Vec::new(); components],
            ..Self::default()
        }
    }
}

impl Resolver<'_> {
    /// The variables that a name in a parameter set of the system means.
    pub(super) fn hierarchical(&self, name: &str, aliases: &HashMap<&str, Vec<Terminal>>) -> Option<Vec<Terminal>> {
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

    /// Adds the settings of one parameter set; `find` returns the variables of a name.
    pub(super) fn apply(
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
                if values.remarked.insert((Arc::as_ptr(&bound.place), parameter.line.0)) {
                    let place = bound.line(parameter);
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
                let latest = &mut values.latest[terminal.component];
                if latest.is_empty() {
                    latest.resize(self.descriptions[terminal.component].variables.len(), None);
                }
                // There are at most MAX_APPLIED of them.
                let next = u32::try_from(values.found.len()).unwrap_or(u32::MAX);
                if let Some(former) = latest[terminal.variable].replace(next) {
                    values.found[former as usize] = None;
                }
                values.found.push(Some(Located { item: (terminal, value), place: Some(bound.line(parameter)) }));
            }
        }
        Ok(())
    }

    /// A parameter's value in the unit of the variable.
    fn value(&self, parameter: &ParameterValue, linear: Linear, units: &Units, terminal: Terminal) -> Result<Value> {
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

/// The parameters of a set under the names they are applied to, with the transformation of the mapping.
fn mapped(bound: &BoundSet) -> Vec<(Cow<'_, str>, &ParameterValue, Linear)> {
    let parameters = &bound.set.parameters;
    let Some(entries) = &bound.mapping else {
        return parameters.iter().map(|parameter| (bound.prefixed(&parameter.name), parameter, None)).collect();
    };
    let by_name: HashMap<_, _> = parameters.iter().map(|parameter| (parameter.name.as_str(), parameter)).collect();
    let source = |entry: &MappingEntry| by_name.get(entry.source.strip_prefix(&bound.prefix)?).copied();
    let mapped = entries.iter().filter_map(|entry| Some((entry.target.as_str().into(), source(entry)?, entry.linear)));
    mapped.collect()
}
