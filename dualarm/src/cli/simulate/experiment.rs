//! How to run: what the command line leaves open comes from the system, then from its first FMU.

use super::Arguments;
use crate::cli::Failure;
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Coupling, Master};
use fmi2_cosim::system::System;

/// Settings of a run that are complete.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    /// The communication points.
    pub grid: TimeGrid,
    /// How signals are exchanged.
    pub coupling: Coupling,
    /// Time in s between two rows of the output; 0 for every step.
    pub interval: f64,
}

impl Run {
    /// Completes what the user wants with what the system suggests.
    pub fn of(arguments: &Arguments, system: &System) -> Result<Self, Failure> {
        let wanted = system.experiment;
        let suggested =
            system.components.first().map(|(_, fmu)| fmu.description().default_experiment).unwrap_or_default();
        let start = arguments.start.or(wanted.start).or(suggested.start_time).unwrap_or(0.0);
        let stop = arguments.stop.or(wanted.stop).or(suggested.stop_time).unwrap_or(start + 5.0);
        let step = arguments.step.or(wanted.step).or(suggested.step_size).unwrap_or(1e-4);
        let grid = grid(start, stop, step)?;
        let interval = arguments.interval.or(wanted.interval).unwrap_or(1e-3);
        if !(interval >= 0.0 && interval.is_finite()) {
            return Err(Failure::usage(format!("the interval must be 0 or more seconds, not {interval}")));
        }
        let coupling = arguments.coupling.map(Coupling::from).or(wanted.coupling).unwrap_or_default();
        Ok(Self { grid, coupling, interval })
    }

    /// What may not be as the user expects.
    pub fn remarks(&self, master: &Master) -> Vec<String> {
        let mut remarks: Vec<_> = master.warnings().to_vec();
        remarks.extend(self.uneven_rows());
        remarks.extend(unconnected(master));
        remarks.extend(crate::grasp::unused_gains(master.settings()));
        remarks
    }

    /// Rows are taken at communication points only.
    fn uneven_rows(&self) -> Option<String> {
        let (interval, step) = (self.interval, self.grid.step());
        let steps = interval / step;
        let is_multiple = (steps - steps.round()).abs() <= 1e-6 * steps.max(1.0);
        // An interval shorter than the step means every step, and nobody misses anything.
        (steps > 1.0 && !is_multiple).then(|| {
            format!(
                "the interval of {interval} s is no multiple of the step of {step} s: rows come at the first communication \
                 point after each multiple, not equally spaced"
            )
        })
    }
}

/// The communication points a user asks for.
pub fn grid(start: f64, stop: f64, step: f64) -> Result<TimeGrid, Failure> {
    let grid = TimeGrid::new(start, stop, step).map_err(Failure::usage)?;
    if step > (stop - start) * (1.0 + 1e-9) {
        let message = format!("a step of {step} s is longer than the run from {start} s to {stop} s");
        return Err(Failure::usage(message));
    }
    Ok(grid)
}

/// FMUs that were given together but have nothing to say to each other.
fn unconnected(master: &Master) -> Vec<String> {
    let names: Vec<_> = master.names().collect();
    if names.len() < 2 {
        return Vec::new();
    }
    let is_alone =
        |index: usize| !master.wires().iter().any(|wire| wire.from.component == index || wire.to.component == index);
    let alone = names.iter().enumerate().filter(|(index, _)| is_alone(*index));
    alone
        .map(|(_, name)| format!("{name} shares no signal with the other FMUs: no output has an input's name"))
        .collect()
}
