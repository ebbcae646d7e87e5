//! The buffer that signals of one type pass through on their way from outputs to inputs.

// What reals need is short, and each function of it that is a call of its own costs half as much again: it saves and restores
// registers, and passes on a large result.
#![allow(clippy::inline_always)]

use std::collections::HashMap;

use fmi2_import::{CallError, Calls, ModelDescription, Status, ValueReference};

use super::batches::{self, Call};
use crate::record::Kind;
use crate::units::Conversion;
use crate::wiring::{Terminal, Wire};

/// A type of value that can be wired.
pub(super) trait Signal: Copy + Default {
    /// The types it carries.
    const KIND: Kind;
    fn get(slave: &mut Calls, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError>;
    fn set(slave: &mut Calls, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError>;
    /// Whether an iteration may stop between these two.
    fn agrees(self, other: Self) -> bool;
    /// The value in another unit; only reals have units.
    fn converted(self, _: &Conversion) -> Self {
        self
    }
}

impl Signal for f64 {
    const KIND: Kind = Kind::Real;

    #[inline]
    fn get(slave: &mut Calls, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError> {
        slave.get_real(references, values)
    }
    #[inline]
    fn set(slave: &mut Calls, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError> {
        slave.set_real(references, values)
    }
    fn agrees(self, other: Self) -> bool {
        (self - other).abs() <= 1e-15 + 1e-13 * self.abs().max(other.abs())
    }
    fn converted(self, conversion: &Conversion) -> Self {
        conversion.apply(self)
    }
}

impl Signal for i32 {
    const KIND: Kind = Kind::Integer;

    #[inline]
    fn get(slave: &mut Calls, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError> {
        slave.get_integer(references, values)
    }
    #[inline]
    fn set(slave: &mut Calls, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError> {
        slave.set_integer(references, values)
    }
    fn agrees(self, other: Self) -> bool {
        self == other
    }
}

impl Signal for bool {
    const KIND: Kind = Kind::Boolean;

    #[inline]
    fn get(slave: &mut Calls, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError> {
        slave.get_boolean(references, values)
    }
    #[inline]
    fn set(slave: &mut Calls, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError> {
        slave.set_boolean(references, values)
    }
    fn agrees(self, other: Self) -> bool {
        self == other
    }
}

/// All wires to inputs of one type, and outputs of that type that are fetched besides. The values of each component's outputs are
/// neighbours in `signals`.
pub(super) struct Bus<T> {
    signals: Vec<T>,
    /// Where each output with a wire lies.
    places: HashMap<Terminal, usize>,
    ports: Vec<Port>,
}

/// One component's connections.
#[derive(Default)]
pub(super) struct Port {
    /// Fetches the outputs after a step.
    offered: Vec<Call>,
    /// Fetches others, which depend on inputs that are set after the step.
    watched: Vec<Call>,
    /// Sets the inputs.
    wanted: Vec<Call>,
    /// What has to be copied before: from where, and where to. Inputs that are neighbours like their signals take these as they are.
    gathered: Vec<(usize, usize)>,
    /// What has to be converted then.
    conversions: Vec<(usize, Conversion)>,
}

impl<T: Signal> Bus<T> {
    /// The bus for these wires. From each component `others` are fetched with the outputs that have wires.
    pub(super) fn new(descriptions: &[&ModelDescription], wires: &[Wire], others: &[Vec<ValueReference>]) -> Self {
        let ports = descriptions.iter().map(|_| Port::default()).collect();
        let mut bus = Self { signals: Vec::new(), places: HashMap::new(), ports };
        let mut sources: Vec<Vec<(ValueReference, Option<Terminal>)>> = vec![Vec::new(); descriptions.len()];
        for wire in wires.iter().filter(|wire| kind(descriptions, wire.from) == Some(T::KIND)) {
            let Terminal { component, variable } = wire.from;
            if !sources[component].iter().any(|(_, known)| *known == Some(wire.from)) {
                sources[component].push((descriptions[component].variables[variable].value_reference, Some(wire.from)));
            }
        }
        for (component, mut sources) in sources.into_iter().enumerate() {
            for reference in others.get(component).into_iter().flatten() {
                if !sources.iter().any(|(known, _)| known == reference) {
                    sources.push((*reference, None));
                }
            }
            batches::arrange(&mut sources, |(reference, _)| *reference);
            let references: Vec<_> = sources.iter().map(|(reference, _)| *reference).collect();
            bus.ports[component].offered = batches::calls(&references, bus.signals.len());
            for (_, terminal) in sources {
                let place = bus.add_signal();
                if let Some(terminal) = terminal {
                    bus.places.insert(terminal, place);
                }
            }
        }
        bus
    }

    /// Whether there is no wire of this type.
    pub(super) fn is_idle(&self) -> bool {
        self.ports.iter().all(|port| port.offered.is_empty() && port.wanted.is_empty())
    }

    fn add_signal(&mut self) -> usize {
        self.signals.push(T::default());
        self.signals.len() - 1
    }

    /// Where a wired output lies, if it has this type.
    pub(super) fn place(&self, output: Terminal) -> Option<usize> {
        self.places.get(&output).copied()
    }

    /// Gives a wired output a place.
    pub(super) fn add_place(&mut self, output: Terminal) -> usize {
        let place = self.add_signal();
        self.places.insert(output, place);
        place
    }

    /// Connects the inputs of a component by these wires to them.
    pub(super) fn connect(&mut self, description: &ModelDescription, component: usize, wires: &[&Wire]) {
        let connected = wires.iter().filter_map(|wire| Some((*wire, *self.places.get(&wire.from)?)));
        let mut wires: Vec<(&Wire, usize)> = connected.collect();
        let reference = |wire: &Wire| description.variables[wire.to.variable].value_reference;
        batches::arrange(&mut wires, |(wire, _)| reference(wire));
        let references: Vec<_> = wires.iter().map(|(wire, _)| reference(wire)).collect();
        let mut port = std::mem::take(&mut self.ports[component]);
        port.wanted = batches::calls(&references, 0);
        for call in &mut port.wanted {
            let these = &wires[call.places()];
            let first = these[0].1;
            let are_neighbours = these.iter().zip(first..).all(|((_, signal), place)| *signal == place);
            if are_neighbours && these.iter().all(|(wire, _)| wire.conversion.is_none()) {
                call.move_to(first);
                continue;
            }
            call.move_to(self.signals.len());
            for (wire, signal) in these {
                let place = self.add_signal();
                port.gathered.push((*signal, place));
                port.conversions.extend(wire.conversion.map(|conversion| (place, conversion)));
            }
        }
        self.ports[component] = port;
    }

    /// Fetches these outputs of a component with [`Port::watch`].
    pub(super) fn add_watched(&mut self, component: usize, mut references: Vec<ValueReference>) {
        batches::arrange(&mut references, |reference| *reference);
        self.ports[component].watched = batches::calls(&references, self.signals.len());
        self.signals.resize(self.signals.len() + references.len(), T::default());
    }

    /// Where the value of an output is that is fetched from a component.
    pub(super) fn fetched(&self, component: usize, reference: ValueReference) -> Option<usize> {
        let Port { offered, watched, .. } = &self.ports[component];
        // What is watched has been fetched later.
        watched.iter().chain(offered).find_map(|call| call.place(reference))
    }

    /// Takes the values of wired outputs over from another bus with the same wires.
    pub(super) fn take_over(&mut self, old: &Self) {
        for (output, place) in &self.places {
            self.signals[*place] = old.signals[old.places[output]];
        }
    }

    /// All values.
    #[inline]
    pub(super) fn signals(&self) -> &[T] {
        &self.signals
    }

    /// All values, and the connections of each component.
    #[inline]
    pub(super) fn parts(&mut self) -> (&mut [T], &[Port]) {
        (&mut self.signals, &self.ports)
    }

    /// Puts a value at a place.
    pub(super) fn put(&mut self, place: usize, value: T) {
        self.signals[place] = value;
    }

    /// Whether no signal of a wire has changed since its values were `before`.
    pub(super) fn agrees_with(&self, before: &[T]) -> bool {
        self.places.values().all(|place| before[*place].agrees(self.signals[*place]))
    }

    /// Fetches the outputs of a component.
    pub(super) fn read(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.ports[component].read(&mut self.signals, slave)
    }

    /// Sets the inputs of a component.
    pub(super) fn write(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.ports[component].write(&mut self.signals, slave)
    }
}

impl Port {
    /// Fetches the outputs.
    #[inline(always)]
    pub(super) fn read<T: Signal>(&self, signals: &mut [T], slave: &mut Calls) -> Result<(), CallError> {
        for call in &self.offered {
            call.get(slave, signals)?;
        }
        Ok(())
    }

    /// Fetches what [`Bus::add_watched`] has added.
    #[inline(always)]
    pub(super) fn watch<T: Signal>(&self, signals: &mut [T], slave: &mut Calls) -> Result<(), CallError> {
        for call in &self.watched {
            call.get(slave, signals)?;
        }
        Ok(())
    }

    /// Sets the inputs.
    #[inline(always)]
    pub(super) fn write<T: Signal>(&self, signals: &mut [T], slave: &mut Calls) -> Result<(), CallError> {
        for (from, to) in &self.gathered {
            signals[*to] = signals[*from];
        }
        for (place, conversion) in &self.conversions {
            signals[*place] = signals[*place].converted(conversion);
        }
        for call in &self.wanted {
            call.set(slave, signals)?;
        }
        Ok(())
    }
}

pub(super) fn kind(descriptions: &[&ModelDescription], terminal: Terminal) -> Option<Kind> {
    Kind::of(descriptions[terminal.component].variables[terminal.variable].base_type())
}

/// The wires to the inputs of one type and component.
pub(super) fn wires_to<'a>(
    descriptions: &[&ModelDescription],
    wires: &'a [Wire],
    component: usize,
    wanted: Kind,
) -> Vec<&'a Wire> {
    let is_wanted = |wire: &&Wire| wire.to.component == component && kind(descriptions, wire.to) == Some(wanted);
    wires.iter().filter(is_wanted).collect()
}
