//! The options of a run. Options that are not on the command line come from the system, then from its first FMU.

use super::Arguments;
use crate::cli::Failure;
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::Coupling;
use fmi2_cosim::run::{self, Run};
use fmi2_cosim::system::{RunOptions, System};

/// Completes the user's options with those of the system.
pub fn run(arguments: &Arguments, system: &System) -> Result<Run, Failure> {
    let suggested = system.experiment;
    let wanted = RunOptions {
        start: arguments.start.or(suggested.start),
        stop: arguments.stop.or(suggested.stop),
        step: arguments.step.or(suggested.step),
        tolerance: arguments.tolerance.or(suggested.tolerance),
        coupling: arguments.coupling.map(Coupling::from).or(suggested.coupling),
        interval: arguments.interval.or(suggested.interval),
    };
    Run::of(&wanted, system).map_err(Failure::usage)
}

/// The communication points a user asks for.
pub fn grid(start: f64, stop: f64, step: f64) -> Result<TimeGrid, Failure> {
    run::grid(start, stop, step).map_err(Failure::usage)
}
