//! Observes a run of a grasp: computes metrics, and reports gains that are not used. (The plant itself reports actuators at
//! their limits.)

use std::io;

use super::{actuator_limits, unused_gains};
use fmi2_cosim::master::Master;
use fmi2_cosim::record::{Column, Points};
use fmi2_cosim::run::Observer;
use grasp_merit::metrics::{CONTACT_FORCE, Metrics, MetricsObstacle, SIGNALS};
use grasp_merit::running::Running;

/// Follows the signals that metrics are made of, in a grasp those of every step.
#[derive(Debug, Default)]
pub struct GraspWatch {
    /// Where the columns of these signals are.
    places: [Option<usize>; SIGNALS.len()],
    running: Running,
}

impl GraspWatch {
    /// How good the grasp was.
    ///
    /// # Errors
    /// When the run was no grasp.
    pub fn metrics(&self) -> Result<Metrics, MetricsObstacle> {
        let missing: Vec<_> = SIGNALS.into_iter().zip(self.places).filter(|(_, place)| place.is_none()).collect();
        if !missing.is_empty() {
            return Err(MetricsObstacle::Missing(missing.into_iter().map(|(name, _)| name).collect()));
        }
        self.running.metrics().ok_or(MetricsObstacle::Empty)
    }
}

impl Observer for GraspWatch {
    fn begin(&mut self, master: &mut Master, columns: &[Column]) -> Vec<String> {
        self.places = SIGNALS.map(|name| columns.iter().position(|column| column.name == name));
        let components = 0..master.names().count();
        let limits = components.map(|index| actuator_limits(master.instance(index)));
        let first = limits.reduce(|limits, others| if limits == [None; 3] { others } else { limits });
        self.running = Running::new(first.unwrap_or_default());
        unused_gains(master.settings())
    }

    fn follows(&self, column: &Column) -> bool {
        let is_grasp = SIGNALS.iter().zip(&self.places).any(|(name, place)| *name == CONTACT_FORCE && place.is_some());
        is_grasp && SIGNALS.contains(&column.name.as_str())
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        // Without one of the signals there are no metrics.
        if let [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f)] =
            self.places.map(|place| place.and_then(|place| points.column(place)))
        {
            self.running.extend(points.times(), [a, b, c, d, e, f]);
        }
        Ok(())
    }

    fn conclude(&mut self) -> Vec<String> {
        Vec::new()
    }
}
