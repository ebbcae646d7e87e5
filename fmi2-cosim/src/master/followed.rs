//! The columns that are read at every communication point, and the blocks in which they are passed on.

use std::io;

use super::buses::Buses;
use super::recording::Port;
use crate::record::{Points, Sink};
use fmi2_import::{CallError, Calls, ValueReference};

/// The columns that are read at every communication point.
pub(super) struct Followed {
    /// The columns of each component.
    ports: Vec<Port>,
    /// The points that have not been passed on yet.
    points: Points,
    /// How they are read after a step in which one component came after the other, if all of them are reals.
    usual: Option<Usual>,
}

/// Reads columns from the signals on their way.
struct Usual {
    /// The components whose outputs have to be fetched when their inputs have been set.
    watched: Vec<usize>,
    /// Where each column is among the signals.
    places: Vec<usize>,
}

impl Followed {
    /// Those of `columns` that are true, which these ports read.
    pub fn new(ports: Vec<Port>, columns: &[bool]) -> Self {
        let places = (0..columns.len()).filter(|place| columns[*place]).collect();
        Self { ports, points: Points::new(places), usual: None }
    }

    /// The outputs of each component, if all of them are reals.
    pub fn reals(&self) -> Option<Vec<Vec<ValueReference>>> {
        self.ports.iter().map(|port| Some(port.only_reals()?.map(|(reference, _)| reference).collect())).collect()
    }

    /// From now on reads them from the signals, which are fetched from these components when their inputs have been set, and from all
    /// others after their step.
    pub fn take_from(&mut self, buses: &Buses, watched: Vec<usize>) {
        let mut places = Vec::new();
        for (component, port) in self.ports.iter().enumerate() {
            let Some(reals) = port.only_reals() else { return };
            for (reference, column) in reals {
                let Some(place) = buses.fetched(component, reference) else { return };
                places.push((column, place));
            }
        }
        places.sort_unstable();
        self.usual = Some(Usual { watched, places: places.into_iter().map(|(_, place)| place).collect() });
    }

    /// The components of which outputs are fetched by [`watch`](super::turns::watch) at the communication point, if the signals have
    /// all columns then.
    #[inline]
    pub fn watched(&self) -> Option<&[usize]> {
        Some(&self.usual.as_ref()?.watched)
    }

    /// Takes the next point from the signals. True when all points have to be passed on.
    #[inline]
    pub fn take(&mut self, time: f64, signals: &[f64]) -> bool {
        self.usual.as_ref().is_some_and(|usual| self.points.push_from(time, signals, &usual.places))
    }

    /// Reads the columns of a component into a row.
    pub fn read(&mut self, component: usize, slave: &mut Calls, row: &mut [f64]) -> Result<(), CallError> {
        self.ports.get_mut(component).map_or(Ok(()), |port| port.read(slave, row))
    }

    /// Takes the next point from a row. True when all points have to be passed on.
    pub fn take_row(&mut self, time: f64, row: &[f64]) -> bool {
        self.points.push(time, row)
    }

    /// Passes on the points that have not been passed on yet.
    pub fn pass_on(&mut self, sink: &mut dyn Sink) -> io::Result<()> {
        if self.points.is_empty() {
            return Ok(());
        }
        let result = sink.points(&self.points);
        self.points.clear();
        result
    }

    /// Forgets the points of an earlier run.
    pub fn begin(&mut self) {
        self.points.clear();
    }
}
