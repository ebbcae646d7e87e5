//! The buffers that signals pass through on their way from outputs to inputs.

use std::collections::HashMap;

use fmi2_import::{CallError, Instance, ModelDescription, Status, ValueReference};

use crate::record::Kind;
use crate::units::Conversion;
use crate::wiring::{Terminal, Wire};

/// A type of value that can be wired.
pub(crate) trait Signal: Copy + Default {
    /// The types it carries.
    const KIND: Kind;
    fn get(instance: &mut Instance, references: &[ValueReference], values: &mut [Self]) -> Result<Status, CallError>;
    fn set(instance: &mut Instance, references: &[ValueReference], values: &[Self]) -> Result<Status, CallError>;
    /// Whether an iteration may stop between these two.
    fn agrees(self, other: Self) -> bool;
    /// The value in another unit; only reals have units.
    fn converted(self, _: &Conversion) -> Self {
        self
    }
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
    fn converted(self, conversion: &Conversion) -> Self {
        conversion.apply(self)
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

/// All wires.
pub(crate) struct Buses {
    real: Bus<f64>,
    integer: Bus<i32>,
    boolean: Bus<bool>,
    /// Integers that are wanted as reals.
    crossings: Vec<Crossing>,
    /// For each component, the components that drive its inputs.
    sources: Vec<Vec<usize>>,
    /// Counts the reads.
    clock: u64,
    /// For each component, when its outputs were last fetched.
    read_at: Vec<u64>,
    /// For each component, when its inputs were last set; 0 if other code may have set them since.
    written_at: Vec<u64>,
    /// For each component, whether its wires carry only reals.
    are_real: Vec<bool>,
    /// For each component, whether nothing has happened to it since its outputs were last fetched.
    is_fresh: Vec<bool>,
    /// For each component, where the outputs that are followed are found among those that are fetched.
    taps: Vec<Option<Tap>>,
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
        let (mut real, integer) = (Bus::<f64>::new(descriptions, wires), Bus::<i32>::new(descriptions, wires));
        let is_crossing = |wire: &&Wire| {
            kind(descriptions, wire.from) == Some(Kind::Integer) && kind(descriptions, wire.to) == Some(Kind::Real)
        };
        let mut crossings: Vec<Crossing> = Vec::new();
        let mut known: HashMap<Terminal, usize> = HashMap::new();
        for wire in wires.iter().filter(is_crossing) {
            let signal = *known.entry(wire.from).or_insert_with(|| {
                let signal = real.add_signal();
                let integer = integer.places[&wire.from];
                crossings.push(Crossing { component: wire.from.component, integer, real: signal });
                signal
            });
            real.add_wire(descriptions, wire, signal);
        }
        let count = descriptions.len();
        let mut sources = vec![Vec::new(); count];
        for wire in wires {
            if !sources[wire.to.component].contains(&wire.from.component) {
                sources[wire.to.component].push(wire.from.component);
            }
        }
        let boolean = Bus::new(descriptions, wires);
        let (read_at, written_at, is_fresh) = (vec![0; count], vec![0; count], vec![false; count]);
        let taps = (0..count).map(|_| None).collect();
        let are_real = (0..count).map(|index| integer.is_idle(index) && boolean.is_idle(index)).collect();
        Self { real, integer, boolean, crossings, sources, clock: 0, read_at, written_at, are_real, is_fresh, taps }
    }

    /// Forgets which outputs are followed.
    pub(crate) fn untap(&mut self) {
        self.taps.fill_with(|| None);
        for port in &mut self.real.ports {
            port.offered.truncate(port.signals);
            port.fetched.clear();
        }
    }

    /// Fetches these real outputs of a component together with those for its wires, so that [`Buses::take`] finds them. For
    /// components that nothing happens to between [`Buses::read`] and the communication point.
    pub(crate) fn tap(&mut self, component: usize, outputs: impl Iterator<Item = (ValueReference, usize)>) {
        let port = &mut self.real.ports[component];
        let mut tap = Tap { wired: Vec::new(), others: Vec::new() };
        for (reference, column) in outputs {
            if let Some(index) = port.offered[..port.signals].iter().position(|offered| *offered == reference) {
                tap.wired.push((port.first_signal + index, column));
            } else {
                port.offered.push(reference);
                tap.others.push(column);
            }
        }
        if !tap.others.is_empty() {
            port.fetched = vec![0.0; port.offered.len()];
        }
        self.is_fresh[component] = false;
        self.taps[component] = Some(tap);
    }

    /// Writes the followed outputs of a component into a row, if they are known here.
    #[inline]
    pub(crate) fn take(&self, component: usize, row: &mut [f64]) -> bool {
        let Some(Some(tap)) = self.taps.get(component) else { return false };
        if !self.is_fresh[component] {
            return false;
        }
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
        self.is_fresh[component] = false;
    }

    /// Fetches the outputs of a component.
    #[inline]
    pub(crate) fn read(&mut self, component: usize, instance: &mut Instance) -> Result<(), CallError> {
        self.clock += 1;
        self.read_at[component] = self.clock;
        self.real.read(component, instance)?;
        if self.are_real[component] {
            self.is_fresh[component] = true;
            return Ok(());
        }
        self.integer.read(component, instance)?;
        for crossing in &self.crossings {
            if crossing.component == component {
                self.real.signals[crossing.real] = f64::from(self.integer.signals[crossing.integer]);
            }
        }
        self.boolean.read(component, instance)?;
        self.is_fresh[component] = true;
        Ok(())
    }

    /// Sets the inputs of a component.
    #[inline]
    pub(crate) fn write(&mut self, component: usize, instance: &mut Instance) -> Result<(), CallError> {
        self.written_at[component] = self.clock;
        self.is_fresh[component] = false;
        self.real.write(component, instance)?;
        if self.are_real[component] {
            return Ok(());
        }
        self.integer.write(component, instance)?;
        self.boolean.write(component, instance)
    }

    /// Sets the inputs of a component, unless no outputs have been read since they were last set.
    #[inline]
    pub(crate) fn refresh(&mut self, component: usize, instance: &mut Instance) -> Result<(), CallError> {
        let since = self.written_at[component];
        if self.sources[component].iter().any(|source| self.read_at[*source] > since) {
            self.write(component, instance)?;
        }
        Ok(())
    }

    /// Marks that other code may set the inputs of a component.
    pub(crate) fn forget(&mut self, component: usize) {
        self.written_at[component] = 0;
        self.is_fresh[component] = false;
    }

    /// The components that drive inputs of a component.
    pub(crate) fn sources(&self, component: usize) -> &[usize] {
        &self.sources[component]
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
    offered: Vec<ValueReference>,
    first_signal: usize,
    signals: usize,
    /// The values of all these outputs, if there are others.
    fetched: Vec<T>,
    wanted: Vec<ValueReference>,
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
        let mut sources: Vec<Vec<Terminal>> = vec![Vec::new(); descriptions.len()];
        for wire in wires.iter().filter(|wire| kind(descriptions, wire.from) == Some(T::KIND)) {
            sources[wire.from.component].push(wire.from);
        }
        for (component, sources) in sources.into_iter().enumerate() {
            bus.ports[component].first_signal = bus.signals.len();
            for source in sources {
                if !bus.places.contains_key(&source) {
                    let signal = bus.add_signal();
                    bus.places.insert(source, signal);
                    let reference = descriptions[component].variables[source.variable].value_reference;
                    bus.ports[component].offered.push(reference);
                }
            }
            bus.ports[component].signals = bus.ports[component].offered.len();
        }
        for wire in wires.iter().filter(|wire| kind(descriptions, wire.to) == Some(T::KIND)) {
            if let Some(source) = bus.places.get(&wire.from) {
                bus.add_wire(descriptions, wire, *source);
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

    fn add_wire(&mut self, descriptions: &[&ModelDescription], wire: &Wire, source: usize) {
        let port = &mut self.ports[wire.to.component];
        port.conversions.extend(wire.conversion.map(|conversion| (port.wanted.len(), conversion)));
        port.wanted.push(descriptions[wire.to.component].variables[wire.to.variable].value_reference);
        port.sources.push(source);
        port.values.push(T::default());
        port.in_line = port.is_in_line();
    }

    #[inline]
    fn read(&mut self, component: usize, instance: &mut Instance) -> Result<(), CallError> {
        let port = &mut self.ports[component];
        if port.offered.is_empty() {
            return Ok(());
        }
        let signals = &mut self.signals[port.first_signal..][..port.signals];
        if port.fetched.is_empty() {
            T::get(instance, &port.offered, signals)?;
        } else {
            T::get(instance, &port.offered, &mut port.fetched)?;
            signals.copy_from_slice(&port.fetched[..port.signals]);
        }
        Ok(())
    }

    #[inline]
    fn write(&mut self, component: usize, instance: &mut Instance) -> Result<(), CallError> {
        let Self { signals, ports, .. } = self;
        let port = &mut ports[component];
        if let Some(first) = port.in_line {
            T::set(instance, &port.wanted, &signals[first..][..port.wanted.len()])?;
        } else if !port.wanted.is_empty() {
            // Two iterators in one would be put together by a call, at every step.
            let mut sources = port.sources.iter();
            for value in &mut port.values {
                let Some(source) = sources.next() else { break };
                *value = signals[*source];
            }
            for (index, conversion) in &port.conversions {
                port.values[*index] = port.values[*index].converted(conversion);
            }
            T::set(instance, &port.wanted, &port.values)?;
        }
        Ok(())
    }
}
