//! The buffers that signals pass through on their way from outputs to inputs.

// What reals need is short, and each function of it that is a call of its own costs half as much again: it saves and restores
// registers, and passes on a large result.
#![allow(clippy::inline_always)]

use std::collections::HashMap;

use fmi2_import::{CallError, Calls, ModelDescription, Status, ValueReference};

use super::batches::{self, Batches};
use crate::record::Kind;
use crate::units::Conversion;
use crate::wiring::{Terminal, Wire};

/// A type of value that can be wired.
pub(crate) trait Signal: Copy + Default {
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

/// All wires.
pub(crate) struct Buses {
    real: Bus<f64>,
    integer: Bus<i32>,
    boolean: Bus<bool>,
    /// Integers that are wanted as reals.
    crossings: Vec<Crossing>,
    /// Counts the reads.
    clock: u64,
    components: Vec<State>,
}

/// What is known of a component's inputs and outputs.
#[derive(Default)]
struct State {
    /// The components that drive its inputs.
    sources: Vec<usize>,
    /// When its outputs were last fetched.
    read_at: u64,
    /// When its inputs were last set; 0 if other code may have set them since.
    written_at: u64,
    /// Whether its wires carry only reals.
    is_real: bool,
    /// Whether nothing has happened to it since its outputs were last fetched.
    is_fresh: bool,
    /// Where the outputs that are followed are found among those that are fetched.
    tap: Option<Tap>,
}

/// Fetched outputs and their columns.
struct Tap {
    /// Signals of wires.
    wired: Vec<(usize, usize)>,
    /// The columns of those that are fetched without a wire.
    others: Vec<usize>,
}

struct Crossing {
    component: usize,
    integer: usize,
    real: usize,
}

impl Buses {
    pub(crate) fn new(descriptions: &[&ModelDescription], wires: &[Wire]) -> Self {
        let mut real = Bus::<f64>::new(descriptions, wires);
        let (mut integer, mut boolean) = (Bus::<i32>::new(descriptions, wires), Bus::<bool>::new(descriptions, wires));
        let is_crossing = |wire: &&Wire| {
            kind(descriptions, wire.from) == Some(Kind::Integer) && kind(descriptions, wire.to) == Some(Kind::Real)
        };
        let mut crossings: Vec<Crossing> = Vec::new();
        for wire in wires.iter().filter(is_crossing) {
            if !real.places.contains_key(&wire.from) {
                let signal = real.add_signal();
                real.places.insert(wire.from, signal);
                let integer = integer.places[&wire.from];
                crossings.push(Crossing { component: wire.from.component, integer, real: signal });
            }
        }
        for (component, description) in descriptions.iter().enumerate() {
            real.connect(description, component, &wires_to(descriptions, wires, component, Kind::Real));
            integer.connect(description, component, &wires_to(descriptions, wires, component, Kind::Integer));
            boolean.connect(description, component, &wires_to(descriptions, wires, component, Kind::Boolean));
        }
        let mut components: Vec<State> = descriptions.iter().map(|_| State::default()).collect();
        for wire in wires {
            let sources = &mut components[wire.to.component].sources;
            if !sources.contains(&wire.from.component) {
                sources.push(wire.from.component);
            }
        }
        for (index, state) in components.iter_mut().enumerate() {
            state.is_real = integer.is_idle(index) && boolean.is_idle(index);
        }
        Self { real, integer, boolean, crossings, clock: 0, components }
    }

    /// Forgets which outputs are followed.
    pub(crate) fn untap(&mut self) {
        for state in &mut self.components {
            state.tap = None;
        }
        for port in &mut self.real.ports {
            if port.offered.len() > port.signals {
                port.offered = port.offered.with(port.signals, []);
            }
            port.fetched.clear();
        }
    }

    /// Fetches these real outputs of a component together with those for its wires, so that [`Buses::take`] finds them. For
    /// components that nothing happens to between [`Buses::read`] and the communication point.
    pub(crate) fn tap(&mut self, component: usize, outputs: impl Iterator<Item = (ValueReference, usize)>) {
        let port = &mut self.real.ports[component];
        let mut tap = Tap { wired: Vec::new(), others: Vec::new() };
        let mut others: Vec<(ValueReference, usize)> = Vec::new();
        for (reference, column) in outputs {
            match port.offered.position(reference).filter(|index| *index < port.signals) {
                Some(index) => tap.wired.push((port.first_signal + index, column)),
                None => others.push((reference, column)),
            }
        }
        if !others.is_empty() {
            batches::arrange(&mut others, |(reference, _)| *reference);
            tap.others = others.iter().map(|(_, column)| *column).collect();
            port.offered = port.offered.with(port.signals, others.iter().map(|(reference, _)| *reference));
            port.fetched = vec![0.0; port.offered.len()];
        }
        let state = &mut self.components[component];
        (state.is_fresh, state.tap) = (false, Some(tap));
    }

    /// Writes the followed outputs of a component into a row, if they are known here.
    #[inline(always)]
    pub(crate) fn take(&self, component: usize, row: &mut [f64]) -> bool {
        let State { tap: Some(tap), is_fresh: true, .. } = &self.components[component] else { return false };
        for (signal, column) in &tap.wired {
            row[*column] = self.real.signals[*signal];
        }
        if !tap.others.is_empty() {
            let port = &self.real.ports[component];
            let mut fetched = port.fetched[port.signals..].iter();
            for column in &tap.others {
                let Some(value) = fetched.next() else { break };
                row[*column] = *value;
            }
        }
        true
    }

    /// Marks that a component has made a step.
    #[inline]
    pub(crate) fn moved(&mut self, component: usize) {
        self.components[component].is_fresh = false;
    }

    /// Fetches the outputs of a component.
    #[inline(always)]
    pub(crate) fn read(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.clock += 1;
        let state = &mut self.components[component];
        (state.read_at, state.is_fresh) = (self.clock, false);
        self.real.read(component, slave)?;
        if !state.is_real {
            return self.read_others(component, slave);
        }
        state.is_fresh = true;
        Ok(())
    }

    /// Fetches what is no real, after all that is.
    #[inline(never)]
    fn read_others(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.integer.read(component, slave)?;
        for crossing in self.crossings.iter().filter(|crossing| crossing.component == component) {
            self.real.signals[crossing.real] = f64::from(self.integer.signals[crossing.integer]);
        }
        self.boolean.read(component, slave)?;
        self.components[component].is_fresh = true;
        Ok(())
    }

    /// Sets the inputs of a component.
    #[inline(always)]
    pub(crate) fn write(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        let state = &mut self.components[component];
        (state.written_at, state.is_fresh) = (self.clock, false);
        self.real.write(component, slave)?;
        if state.is_real { Ok(()) } else { self.write_others(component, slave) }
    }

    /// Sets what is no real.
    #[inline(never)]
    fn write_others(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.integer.write(component, slave)?;
        self.boolean.write(component, slave)
    }

    /// Sets the inputs of a component, unless no outputs have been read since they were last set.
    #[inline(always)]
    pub(crate) fn refresh(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        let State { sources, written_at, .. } = &self.components[component];
        if sources.iter().any(|source| self.components[*source].read_at > *written_at) {
            self.write(component, slave)?;
        }
        Ok(())
    }

    /// Marks that other code may set the inputs of a component.
    pub(crate) fn forget(&mut self, component: usize) {
        let state = &mut self.components[component];
        (state.written_at, state.is_fresh) = (0, false);
    }

    /// The components that drive inputs of a component.
    pub(crate) fn sources(&self, component: usize) -> &[usize] {
        &self.components[component].sources
    }

    /// The present signals, for a later comparison.
    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot(self.real.signals.clone(), self.integer.signals.clone(), self.boolean.signals.clone())
    }

    /// Whether no signal has changed since then.
    pub(crate) fn agree_with(&self, before: &Snapshot) -> bool {
        agree(&before.0, &self.real.signals)
            && agree(&before.1, &self.integer.signals)
            && agree(&before.2, &self.boolean.signals)
    }
}

/// Signals at one moment.
pub(crate) struct Snapshot(Vec<f64>, Vec<i32>, Vec<bool>);

fn agree<T: Signal>(before: &[T], after: &[T]) -> bool {
    before.iter().zip(after).all(|(before, after)| before.agrees(*after))
}

fn kind(descriptions: &[&ModelDescription], terminal: Terminal) -> Option<Kind> {
    Kind::of(descriptions[terminal.component].variables[terminal.variable].base_type())
}

/// The wires to the inputs of one type and component.
fn wires_to<'a>(
    descriptions: &[&ModelDescription],
    wires: &'a [Wire],
    component: usize,
    wanted: Kind,
) -> Vec<&'a Wire> {
    let is_wanted = |wire: &&Wire| wire.to.component == component && kind(descriptions, wire.to) == Some(wanted);
    wires.iter().filter(is_wanted).collect()
}

/// All wires to inputs of one type. The outputs of each component are contiguous in `signals`, so one call
/// fetches them.
struct Bus<T> {
    signals: Vec<T>,
    /// Where each output lies.
    places: HashMap<Terminal, usize>,
    ports: Vec<Port<T>>,
}

/// One component's connections.
#[derive(Default)]
struct Port<T> {
    /// Outputs with wires, one signal each, and others that are followed.
    offered: Batches,
    first_signal: usize,
    signals: usize,
    /// The values of all these outputs, if there are others.
    fetched: Vec<T>,
    wanted: Batches,
    /// The signal for each of them.
    sources: Vec<usize>,
    /// The inputs take the signals as they are, one after the other from this one on.
    in_line: Option<usize>,
    conversions: Vec<(usize, Conversion)>,
    values: Vec<T>,
}

impl<T> Port<T> {
    fn is_in_line(&self) -> Option<usize> {
        let first = *self.sources.first()?;
        let are_neighbours = self.sources.iter().zip(first..).all(|(source, place)| *source == place);
        (are_neighbours && self.conversions.is_empty()).then_some(first)
    }
}

impl<T: Signal> Bus<T> {
    fn new(descriptions: &[&ModelDescription], wires: &[Wire]) -> Self {
        let ports = descriptions.iter().map(|_| Port::default()).collect();
        let mut bus = Self { signals: Vec::new(), places: HashMap::new(), ports };
        let mut sources: Vec<Vec<(ValueReference, Terminal)>> = vec![Vec::new(); descriptions.len()];
        for wire in wires.iter().filter(|wire| kind(descriptions, wire.from) == Some(T::KIND)) {
            let Terminal { component, variable } = wire.from;
            if !sources[component].iter().any(|(_, known)| *known == wire.from) {
                sources[component].push((descriptions[component].variables[variable].value_reference, wire.from));
            }
        }
        for (mut sources, port) in sources.into_iter().zip(&mut bus.ports) {
            batches::arrange(&mut sources, |(reference, _)| *reference);
            (port.first_signal, port.signals) = (bus.signals.len(), sources.len());
            port.offered = sources.iter().map(|(reference, _)| *reference).collect();
            for (_, source) in sources {
                bus.places.insert(source, bus.signals.len());
                bus.signals.push(T::default());
            }
        }
        bus
    }

    /// Whether no wire of this type begins or ends at a component.
    fn is_idle(&self, component: usize) -> bool {
        self.ports[component].offered.is_empty() && self.ports[component].wanted.is_empty()
    }

    fn add_signal(&mut self) -> usize {
        self.signals.push(T::default());
        self.signals.len() - 1
    }

    /// Connects the inputs of a component by these wires to them.
    fn connect(&mut self, description: &ModelDescription, component: usize, wires: &[&Wire]) {
        let connected = wires.iter().filter_map(|wire| Some((*wire, *self.places.get(&wire.from)?)));
        let mut wires: Vec<(&Wire, usize)> = connected.collect();
        let reference = |wire: &Wire| description.variables[wire.to.variable].value_reference;
        batches::arrange(&mut wires, |(wire, _)| reference(wire));
        let port = &mut self.ports[component];
        port.wanted = wires.iter().map(|(wire, _)| reference(wire)).collect();
        port.sources = wires.iter().map(|(_, signal)| *signal).collect();
        let conversions = wires.iter().enumerate();
        port.conversions = conversions.filter_map(|(place, (wire, _))| Some((place, wire.conversion?))).collect();
        port.values = vec![T::default(); wires.len()];
        port.in_line = port.is_in_line();
    }

    #[inline(always)]
    fn read(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        let port = &mut self.ports[component];
        if port.offered.is_empty() {
            return Ok(());
        }
        let signals = &mut self.signals[port.first_signal..][..port.signals];
        if port.fetched.is_empty() {
            port.offered.get(slave, signals)?;
        } else {
            port.offered.get(slave, &mut port.fetched)?;
            signals.copy_from_slice(&port.fetched[..port.signals]);
        }
        Ok(())
    }

    #[inline(always)]
    fn write(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        let Self { signals, ports, .. } = self;
        let port = &mut ports[component];
        if let Some(first) = port.in_line {
            return port.wanted.set(slave, &signals[first..][..port.values.len()]);
        }
        // Two iterators in one would be put together by a call, at every step.
        let mut sources = port.sources.iter();
        for value in &mut port.values {
            let Some(source) = sources.next() else { break };
            *value = signals[*source];
        }
        for (index, conversion) in &port.conversions {
            port.values[*index] = port.values[*index].converted(conversion);
        }
        port.wanted.set(slave, &port.values)
    }
}
