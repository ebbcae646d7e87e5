//! The outputs that a row holds, and how they are read from the components.

use std::collections::HashSet;

use super::followed::Followed;
use crate::names::free_name;
use crate::record::{Column, Kind};
use fmi2_import::{CallError, Calls, Causality, Instance, ModelDescription, Status, ValueReference, Variable};

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
pub(super) struct Port {
    real: Outputs<f64>,
    integer: Outputs<i32>,
    boolean: Outputs<bool>,
}

/// Those of one type, which one call reads.
#[derive(Default)]
struct Outputs<T> {
    references: Vec<ValueReference>,
    /// Their places in a row.
    columns: Vec<usize>,
    values: Vec<T>,
}

impl<T: Copy + Default> Outputs<T> {
    fn push(&mut self, reference: ValueReference, column: usize) {
        self.references.push(reference);
        self.columns.push(column);
        self.values.push(T::default());
    }

    fn only(&self, columns: &[bool]) -> Self {
        let mut some = Self::default();
        for (reference, column) in self.references.iter().zip(&self.columns).filter(|(_, column)| columns[**column]) {
            some.push(*reference, *column);
        }
        some
    }

    fn read(
        &mut self,
        row: &mut [f64],
        get: impl FnOnce(&[ValueReference], &mut [T]) -> Result<Status, CallError>,
        number: impl Fn(T) -> f64,
    ) -> Result<(), CallError> {
        if !self.references.is_empty() {
            get(&self.references, &mut self.values)?;
            let mut values = self.values.iter();
            for column in &self.columns {
                let Some(value) = values.next() else { break };
                row[*column] = number(*value);
            }
        }
        Ok(())
    }
}

impl Port {
    fn push(&mut self, kind: Kind, reference: ValueReference, column: usize) {
        match kind {
            Kind::Real => self.real.push(reference, column),
            Kind::Integer => self.integer.push(reference, column),
            Kind::Boolean => self.boolean.push(reference, column),
        }
    }

    fn only(&self, columns: &[bool]) -> Self {
        Self { real: self.real.only(columns), integer: self.integer.only(columns), boolean: self.boolean.only(columns) }
    }

    /// The references and columns of the outputs, if all of them are reals.
    pub(super) fn only_reals(&self) -> Option<impl Iterator<Item = (ValueReference, usize)> + use<'_>> {
        let Self { real, integer, boolean } = self;
        let are_only = integer.references.is_empty() && boolean.references.is_empty();
        are_only.then(|| real.references.iter().copied().zip(real.columns.iter().copied()))
    }

    /// Reads the outputs into a row.
    pub(super) fn read(&mut self, slave: &mut Calls, row: &mut [f64]) -> Result<(), CallError> {
        self.real.read(row, |references, values| slave.get_real(references, values), |value| value)?;
        self.integer.read(row, |references, values| slave.get_integer(references, values), f64::from)?;
        let number = |value| f64::from(u8::from(value));
        self.boolean.read(row, |references, values| slave.get_boolean(references, values), number)
    }
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
            let mut port = Port::default();
            for kind in [Kind::Real, Kind::Integer, Kind::Boolean] {
                for variable in outputs.iter().filter(|variable| Kind::of(variable.base_type()) == Some(kind)) {
                    let name = column_name(components, index, &variable.name);
                    // One component's variable may be called like another one's with its component.
                    let name = free_name(&name, |name| taken.contains(name));
                    taken.insert(name.clone());
                    port.push(kind, variable.value_reference, columns.len());
                    columns.push(Column { name, unit: variable.unit().map(str::to_owned), kind });
                }
            }
            ports.push(port);
        }
        (Self { names: taken, ports, values: vec![0.0; columns.len()] }, columns)
    }

    /// Those of these columns that are followed, if there are any.
    pub(super) fn followed(&self, columns: &[bool]) -> Option<Followed> {
        assert_eq!(columns.len(), self.values.len(), "one truth value for each column");
        let ports = || self.ports.iter().map(|port| port.only(columns)).collect();
        columns.contains(&true).then(|| Followed::new(ports(), columns))
    }

    /// The name of an output that is no column, among those that are.
    pub(crate) fn free_name(&self, name: &str, others: &HashSet<String>) -> String {
        free_name(name, |name| self.names.contains(name) || others.contains(name))
    }

    /// The row that was read last.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// The same, for columns that are read by themselves.
    pub(super) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// The row for the present state of the components, which come in the order of their descriptions.
    pub(crate) fn read<'a>(&mut self, instances: impl Iterator<Item = &'a mut Instance>) -> Result<&[f64], CallError> {
        for (port, instance) in self.ports.iter_mut().zip(instances) {
            instance.together(|slave| port.read(slave, &mut self.values))?;
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
