//! Connections between components: who offers a signal, who wants it, and the buffers it passes through.

use crate::record::Kind;
use fmi2_import::{CallError, Causality, Instance, ModelDescription, Status, ValueReference};

/// One connection, from an output to an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wire {
    /// The output.
    pub from: Terminal,
    /// The input.
    pub to: Terminal,
}

/// One variable of one component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Terminal {
    /// Index of the component.
    pub component: usize,
    /// Index of the variable in its description.
    pub variable: usize,
}

/// Two components offer what a third one wants.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("both {first} and {second} offer \"{name}\", which {wanting} wants; only one of them can be connected")]
pub struct AmbiguousWire {
    /// Name of the signal.
    pub name: String,
    /// One component that offers it.
    pub first: String,
    /// Another one.
    pub second: String,
    /// The component that wants it.
    pub wanting: String,
}

/// Connects every input to the output of the same name and base type of another component. Inputs without such an
/// output stay free; text signals are never connected.
///
/// # Errors
/// When two outputs could feed one input.
pub fn wire_by_name(components: &[(&str, &ModelDescription)]) -> Result<Vec<Wire>, AmbiguousWire> {
    let mut wires = Vec::new();
    for (to, (wanting, description)) in components.iter().enumerate() {
        for (input, variable) in description.variables.iter().enumerate() {
            if variable.causality != Causality::Input || Kind::of(variable.base_type()).is_none() {
                continue;
            }
            let mut offers = components.iter().enumerate().filter_map(|(from, (_, other))| {
                let index = other.index_of(&variable.name)?;
                let output = &other.variables[index];
                let fits =
                    from != to && output.causality == Causality::Output && output.base_type() == variable.base_type();
                fits.then_some(Terminal { component: from, variable: index })
            });
            let Some(from) = offers.next() else { continue };
            if let Some(second) = offers.next() {
                return Err(AmbiguousWire {
                    name: variable.name.clone(),
                    first: components[from.component].0.to_owned(),
                    second: components[second.component].0.to_owned(),
                    wanting: (*wanting).to_owned(),
                });
            }
            wires.push(Wire { from, to: Terminal { component: to, variable: input } });
        }
    }
    Ok(wires)
}

/// A type of value that can be wired.
pub(crate) trait Signal: Copy + Default {
    /// The types it carries.
    const KIND: Kind;
    fn get(instance: &mut Instance, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError>;
    fn set(instance: &mut Instance, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError>;
    /// Whether an iteration may stop between these two.
    fn agrees(self, other: Self) -> bool;
}

impl Signal for f64 {
    const KIND: Kind = Kind::Real;

    fn get(instance: &mut Instance, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError> {
        instance.get_real(references, values)
    }
    fn set(instance: &mut Instance, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError> {
        instance.set_real(references, values)
    }
    fn agrees(self, other: Self) -> bool {
        (self - other).abs() <= 1e-15 + 1e-13 * self.abs().max(other.abs())
    }
}

impl Signal for i32 {
    const KIND: Kind = Kind::Integer;

    fn get(instance: &mut Instance, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError> {
        instance.get_integer(references, values)
    }
    fn set(instance: &mut Instance, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError> {
        instance.set_integer(references, values)
    }
    fn agrees(self, other: Self) -> bool {
        self == other
    }
}

impl Signal for bool {
    const KIND: Kind = Kind::Boolean;

    fn get(instance: &mut Instance, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError> {
        instance.get_boolean(references, values)
    }
    fn set(instance: &mut Instance, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError> {
        instance.set_boolean(references, values)
    }
    fn agrees(self, other: Self) -> bool {
        self == other
    }
}

/// All wires of one type. The outputs of each component lie next to each other in `signals`, so one call fetches them.
pub(crate) struct Bus<T> {
    signals: Vec<T>,
    ports: Vec<Port<T>>,
}

/// One component's connections.
#[derive(Default)]
struct Port<T> {
    offered: Vec<ValueReference>,
    first_signal: usize,
    wanted: Vec<ValueReference>,
    sources: Vec<usize>,
    values: Vec<T>,
}

impl<T: Signal> Bus<T> {
    pub(crate) fn new(descriptions: &[&ModelDescription], wires: &[Wire]) -> Self {
        let variable = |terminal: Terminal| &descriptions[terminal.component].variables[terminal.variable];
        let mut ports: Vec<Port<T>> = descriptions.iter().map(|_| Port::default()).collect();
        let mut sources: Vec<Terminal> = Vec::new();
        for (component, port) in ports.iter_mut().enumerate() {
            port.first_signal = sources.len();
            for wire in wires.iter().filter(|wire| wire.from.component == component) {
                if Kind::of(variable(wire.from).base_type()) == Some(T::KIND) && !sources.contains(&wire.from) {
                    sources.push(wire.from);
                    port.offered.push(variable(wire.from).value_reference);
                }
            }
        }
        for wire in wires {
            if let Some(source) = sources.iter().position(|source| *source == wire.from) {
                let port = &mut ports[wire.to.component];
                port.wanted.push(variable(wire.to).value_reference);
                port.sources.push(source);
                port.values.push(T::default());
            }
        }
        Self { signals: vec![T::default(); sources.len()], ports }
    }

    /// Fetches the outputs of a component.
    #[inline]
    pub(crate) fn read(&mut self, component: usize, instance: &mut Instance) -> Result<(), CallError> {
        let port = &self.ports[component];
        let signals = &mut self.signals[port.first_signal..][..port.offered.len()];
        if !signals.is_empty() {
            T::get(instance, &port.offered, signals)?;
        }
        Ok(())
    }

    /// Hands a component its inputs.
    #[inline]
    pub(crate) fn write(&mut self, component: usize, instance: &mut Instance) -> Result<(), CallError> {
        let port = &mut self.ports[component];
        if !port.wanted.is_empty() {
            for (value, source) in port.values.iter_mut().zip(&port.sources) {
                *value = self.signals[*source];
            }
            T::set(instance, &port.wanted, &port.values)?;
        }
        Ok(())
    }

    pub(crate) fn signals(&self) -> &[T] {
        &self.signals
    }
}
