//! The outputs that a row holds, and how they are read from the components.

use std::collections::HashSet;

use crate::names::free_name;
use crate::record::{Column, Kind};
use fmi2_import::{CallError, Causality, Instance, ModelDescription, ValueReference, Variable};

/// The outputs that are recorded; one row holds component after component, reals, integers, Booleans.
#[derive(Default)]
pub(crate) struct Recording {
    /// Names of the columns, and of the times.
    names: HashSet<String>,
    ports: Vec<Port>,
    values: Vec<f64>,
}

/// The recorded outputs of one component.
#[derive(Default)]
struct Port {
    real: Vec<ValueReference>,
    integer: Vec<ValueReference>,
    boolean: Vec<ValueReference>,
    integers: Vec<i32>,
    booleans: Vec<bool>,
}

impl Recording {
    /// The outputs whose names `wanted` accepts, of components with these names and descriptions; and their columns.
    pub(crate) fn of(components: &[(&str, &ModelDescription)], wanted: impl Fn(&str) -> bool) -> (Self, Vec<Column>) {
        let mut taken = HashSet::from([TIME.to_owned()]);
        let mut columns = Vec::new();
        let mut ports = Vec::new();
        for (index, (_, description)) in components.iter().enumerate() {
            let outputs: Vec<&Variable> =
                description.with_causality(Causality::Output).filter(|variable| wanted(&variable.name)).collect();
            let mut of = |kind: Kind| -> Vec<ValueReference> {
                let chosen = outputs.iter().filter(|variable| Kind::of(variable.base_type()) == Some(kind));
                chosen
                    .map(|variable| {
                        let name = column_name(components, index, &variable.name);
                        // One component's variable may be called like another one's with its component.
                        let name = free_name(&name, |name| taken.contains(name));
                        taken.insert(name.clone());
                        columns.push(Column { name, unit: variable.unit().map(str::to_owned), kind });
                        variable.value_reference
                    })
                    .collect()
            };
            let [real, integer, boolean] = [Kind::Real, Kind::Integer, Kind::Boolean].map(&mut of);
            let (integers, booleans) = (vec![0; integer.len()], vec![false; boolean.len()]);
            ports.push(Port { real, integer, boolean, integers, booleans });
        }
        (Self { names: taken, ports, values: vec![0.0; columns.len()] }, columns)
    }

    /// The name of an output that is no column, among those that are.
    pub(crate) fn free_name(&self, name: &str, others: &HashSet<String>) -> String {
        free_name(name, |name| self.names.contains(name) || others.contains(name))
    }

    /// The row that was read last.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// The row as the components stand, which come in the order of their descriptions.
    pub(crate) fn read<'a>(&mut self, instances: impl Iterator<Item = &'a mut Instance>) -> Result<&[f64], CallError> {
        let mut rest = self.values.as_mut_slice();
        for (port, instance) in self.ports.iter_mut().zip(instances) {
            let (real, after) = rest.split_at_mut(port.real.len());
            instance.get_real(&port.real, real)?;
            let (integer, after) = after.split_at_mut(port.integer.len());
            instance.get_integer(&port.integer, &mut port.integers)?;
            for (value, source) in integer.iter_mut().zip(&port.integers) {
                *value = f64::from(*source);
            }
            let (boolean, after) = after.split_at_mut(port.boolean.len());
            instance.get_boolean(&port.boolean, &mut port.booleans)?;
            for (value, source) in boolean.iter_mut().zip(&port.booleans) {
                *value = f64::from(u8::from(*source));
            }
            rest = after;
        }
        Ok(&self.values)
    }
}

/// Name of the column of times, the first one of every table.
const TIME: &str = "time";

/// The name of a component's output among those of all components.
pub(crate) fn column_name(components: &[(&str, &ModelDescription)], component: usize, name: &str) -> String {
    let has_it = |description: &ModelDescription| {
        description.variable(name).is_some_and(|variable| variable.causality == Causality::Output)
    };
    let is_shared = components.iter().filter(|(_, description)| has_it(description)).count() > 1;
    if is_shared || name == TIME { format!("{}.{name}", components[component].0) } else { name.to_owned() }
}
