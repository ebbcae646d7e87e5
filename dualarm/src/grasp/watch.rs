//! Observes a run of a grasp: computes metrics, and reports gains that are not used. (The plant itself reports actuators at
//! their limits.)

use std::io;

use super::{actuator_limits, unused_gains};
use fmi2_cosim::master::Master;
use fmi2_cosim::record::{Column, Follow, Sink};
use fmi2_cosim::run::Observer;
use grasp_merit::metrics::{CONTACT_FORCE, Limits, Metrics, MetricsObstacle, SIGNALS};

/// Collects the signals that metrics are made of, in a grasp those of every step.
#[derive(Debug)]
pub struct GraspWatch {
    measured: Follow,
    limits: [Option<Limits>; 3],
}

impl Default for GraspWatch {
    fn default() -> Self {
        Self { measured: Follow::new(&[], |_| false), limits: [None; 3] }
    }
}

impl GraspWatch {
    /// How good the grasp was.
    ///
    /// # Errors
    /// When the run was no grasp.
    pub fn metrics(&self) -> Result<Metrics, MetricsObstacle> {
        Metrics::of(self.measured.table(), self.limits)
    }
}

impl Observer for GraspWatch {
    fn begin(&mut self, master: &mut Master, columns: &[Column]) -> Vec<String> {
        self.measured = Follow::new(columns, |name| SIGNALS.contains(&name));
        let components = 0..master.names().count();
        let limits = components.map(|index| actuator_limits(master.instance(index)));
        let first = limits.reduce(|limits, others| if limits == [None; 3] { others } else { limits });
        self.limits = first.unwrap_or_default();
        unused_gains(master.settings())
    }

    fn follows(&self, column: &Column) -> bool {
        let signals = self.measured.table().columns();
        signals.iter().any(|column| column.name == CONTACT_FORCE) && signals.contains(column)
    }

    fn conclude(&mut self) -> Vec<String> {
        Vec::new()
    }
}

impl Sink for GraspWatch {
    fn wants(&mut self, time: f64) -> bool {
        self.measured.wants(time)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.measured.row(time, values)
    }

    fn between(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.measured.between(time, values)
    }

    fn end(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.measured.end(time, values)
    }
}
