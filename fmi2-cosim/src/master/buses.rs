//! All wires, whatever their type, and which signals are newer than which inputs.

use fmi2_import::{CallError, Calls, ModelDescription, ValueReference};

use super::bus::{Bus, Port, kind, wires_to};
use crate::record::Kind;
use crate::wiring::Wire;

/// All wires.
pub(super) struct Buses {
    real: Bus<f64>,
    integer: Bus<i32>,
    boolean: Bus<bool>,
    /// Integers that are wanted as reals.
    crossings: Vec<Crossing>,
    /// Counts the reads.
    clock: u64,
    components: Vec<State>,
    /// Whether wires carry only reals.
    are_real: bool,
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
}

struct Crossing {
    component: usize,
    integer: usize,
    real: usize,
}

impl Buses {
    pub(super) fn new(descriptions: &[&ModelDescription], wires: &[Wire]) -> Self {
        Self::fetching(descriptions, wires, &[])
    }

    /// The same. From each component these reals are fetched with the outputs that have wires.
    fn fetching(descriptions: &[&ModelDescription], wires: &[Wire], others: &[Vec<ValueReference>]) -> Self {
        let mut real = Bus::<f64>::new(descriptions, wires, others);
        let mut integer = Bus::<i32>::new(descriptions, wires, &[]);
        let mut boolean = Bus::<bool>::new(descriptions, wires, &[]);
        let is_crossing = |wire: &&Wire| {
            kind(descriptions, wire.from) == Some(Kind::Integer) && kind(descriptions, wire.to) == Some(Kind::Real)
        };
        let mut crossings: Vec<Crossing> = Vec::new();
        for wire in wires.iter().filter(is_crossing) {
            if let (None, Some(integer)) = (real.place(wire.from), integer.place(wire.from)) {
                crossings.push(Crossing { component: wire.from.component, integer, real: real.add_place(wire.from) });
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
        let are_real = integer.is_idle() && boolean.is_idle();
        Self { real, integer, boolean, crossings, clock: 0, components, are_real }
    }

    /// From now on fetches these reals of each component, too: `settled` together with the outputs that have wires, `others` by
    /// [`Port::watch`]. `wires` are those with which it was made.
    pub(super) fn fetch(
        &mut self,
        descriptions: &[&ModelDescription],
        wires: &[Wire],
        settled: &[Vec<ValueReference>],
        others: Vec<Vec<ValueReference>>,
    ) {
        let mut new = Self::fetching(descriptions, wires, settled);
        for (component, references) in others.into_iter().enumerate().filter(|(_, references)| !references.is_empty()) {
            new.real.add_watched(component, references);
        }
        new.real.take_over(&self.real);
        new.integer.take_over(&self.integer);
        new.boolean.take_over(&self.boolean);
        let components = std::mem::take(&mut self.components);
        *self = Self { clock: self.clock, components, ..new };
    }

    /// Where the value of a real output is that is fetched from a component.
    pub(super) fn fetched(&self, component: usize, reference: ValueReference) -> Option<usize> {
        self.real.fetched(component, reference)
    }

    /// The reals, and the connections of each component by which they come and go, if all wires carry reals.
    #[inline]
    pub(super) fn only_reals(&mut self) -> Option<(&mut [f64], &[Port])> {
        self.are_real.then(|| self.real.parts())
    }

    /// Fetches the outputs of a component.
    pub(super) fn read(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.clock += 1;
        self.components[component].read_at = self.clock;
        self.real.read(component, slave)?;
        if self.are_real { Ok(()) } else { self.read_others(component, slave) }
    }

    /// Fetches what is no real, after all that is.
    fn read_others(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.integer.read(component, slave)?;
        for crossing in self.crossings.iter().filter(|crossing| crossing.component == component) {
            self.real.put(crossing.real, f64::from(self.integer.signals()[crossing.integer]));
        }
        self.boolean.read(component, slave)
    }

    /// Sets the inputs of a component.
    pub(super) fn write(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.components[component].written_at = self.clock;
        self.real.write(component, slave)?;
        if self.are_real { Ok(()) } else { self.write_others(component, slave) }
    }

    /// Marks that every component has got its inputs and given its outputs, one after the other.
    pub(super) fn have_stepped(&mut self) {
        for state in &mut self.components {
            state.written_at = self.clock;
            self.clock += 1;
            state.read_at = self.clock;
        }
    }

    /// Sets what is no real.
    fn write_others(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        self.integer.write(component, slave)?;
        self.boolean.write(component, slave)
    }

    /// Sets the inputs of a component, unless no outputs have been read since they were last set.
    pub(super) fn refresh(&mut self, component: usize, slave: &mut Calls) -> Result<(), CallError> {
        let State { sources, written_at, .. } = &self.components[component];
        if sources.iter().any(|source| self.components[*source].read_at > *written_at) {
            self.write(component, slave)?;
        }
        Ok(())
    }

    /// Marks that other code may set the inputs of a component.
    pub(super) fn forget(&mut self, component: usize) {
        self.components[component].written_at = 0;
    }

    /// The components that drive inputs of a component.
    pub(super) fn sources(&self, component: usize) -> &[usize] {
        &self.components[component].sources
    }

    /// The present signals, for a later comparison.
    pub(super) fn snapshot(&self) -> Snapshot {
        Snapshot(self.real.signals().to_vec(), self.integer.signals().to_vec(), self.boolean.signals().to_vec())
    }

    /// Whether no signal of a wire has changed since then.
    pub(super) fn agree_with(&self, before: &Snapshot) -> bool {
        self.real.agrees_with(&before.0) && self.integer.agrees_with(&before.1) && self.boolean.agrees_with(&before.2)
    }
}

/// Signals at one moment.
pub(super) struct Snapshot(Vec<f64>, Vec<i32>, Vec<bool>);
