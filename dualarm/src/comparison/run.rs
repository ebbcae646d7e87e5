//! One run of the comparison.

use super::{CSV_INTERVAL, ComparisonError, Setup};
use crate::grasp::metrics::Metrics;
use crate::grasp::scenarios::BuiltIn;
use crate::grasp::{self, Controller, instruments};
use crate::report::figures::{self, PaperRun};
use crate::report::html::rows::Rows;
use crate::report::parameters::ModelParameters;
use fmi2_cosim::files::{FileSet, NewFile};
use fmi2_cosim::master::Master;
use fmi2_cosim::record::{Every, Pick, Table};
use fmi2_import::Fmu;

/// The results of a run, the rows of the page, and the components.
pub struct Made {
    pub run: PaperRun,
    pub rows: Table,
    pub master: Master,
}

pub fn simulate(
    controller: &Controller,
    setup: &Setup,
    results: &FileSet,
    done: &(impl Fn(u64) + ?Sized),
) -> Result<Made, ComparisonError> {
    let grid = setup.grid;
    let mut system = BuiltIn::find(controller.key)?.scenario()?.system(setup.fmus)?;
    instruments::put_into(&mut system, &setup.instruments, setup.fmus)?;
    // Instruments and actuators come after the component whose signals they take, so the plant stays the first.
    let controls = |(_, fmu): &(String, Fmu)| fmu.path().file_name().is_some_and(|name| name == controller.fmu);
    let place = system.components.iter().position(controls).unwrap_or(1);
    let mut master = system.master(setup.coupling)?;
    master.initialize(grid)?;
    let limits = grasp::actuator_limits(master.instance(0));
    let models = [ModelParameters::of(master.instance(0))?, ModelParameters::of(master.instance(place))?].into();
    let columns = master.record(|_| true);
    // Signals that are drawn and judged are recorded at every step, all others only as often as the CSV file needs them.
    let mut drawn = Pick::new(&columns, |name| figures::SIGNALS.contains(&name));
    let mut shown = Rows::new(grid, &columns);
    let mut all = Every::new(CSV_INTERVAL, grid.stop(), Table::new(columns));
    master.run(grid, 0.0, &mut ((&mut drawn, &mut shown), &mut all), &mut |steps| done(steps))?;

    let rows = NewFile::create(setup.out.join(format!("{}.csv", controller.key)))?;
    results.add(all.sink.to_csv(rows)?)?;
    let metrics = Metrics::of(&drawn.sink, limits)
        .map_err(|source| ComparisonError::Metrics { controller: controller.fmu, source })?;
    let run = PaperRun { scenario: *controller, table: drawn.sink, metrics, models };
    Ok(Made { run, rows: shown.into_table(), master })
}
