//! One run of the comparison.

use super::{CSV_INTERVAL, ComparisonError, Setup};
use crate::grasp::matrix::Lab;
use crate::grasp::scenarios::BuiltIn;
use crate::grasp::{self, Controller, instruments};
use crate::report::figures::{self, PaperRun};
use crate::report::html::Packed;
use crate::report::html::rows::Rows;
use crate::report::parameters::ModelParameters;
use fmi2_cosim::files::{FileSet, NewFile};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Master, MasterError};
use fmi2_cosim::record::{CsvSink, Every, Follow};
use fmi2_cosim::scenario::ScenarioError;
use fmi2_import::Fmu;
use grasp_merit::metrics::{self, Metrics};

/// The results of a run, the rows of the page, and the components.
pub struct Made {
    pub run: PaperRun,
    pub rows: Packed,
    pub master: Master,
}

pub fn simulate(
    controller: &Controller,
    setup: &Setup,
    lab: &Lab,
    results: &FileSet,
    done: &(impl Fn(u64) + ?Sized),
) -> Result<Made, ComparisonError> {
    let grid = setup.grid;
    let scenario = BuiltIn::find(controller.key)?.scenario()?;
    let fmus = scenario.paths(setup.fmus)?.iter().map(|path| lab.fmu(path)).collect::<Result<Vec<_>, _>>();
    let mut system = scenario.system_of(&fmus.map_err(ScenarioError::from)?)?;
    instruments::put_into(&mut system, &setup.instruments, setup.fmus)?;
    // Instruments and actuators come after the component whose signals they take, so the plant stays the first.
    let controls = |(_, fmu): &(String, Fmu)| fmu.path().file_name().is_some_and(|name| name == controller.fmu);
    let place = system.components.iter().position(controls).unwrap_or(1);
    let mut master = system.master(setup.coupling)?;
    master.initialize(grid)?;
    let limits = grasp::actuator_limits(master.instance(0));
    let models = vec![ModelParameters::of(master.instance(0))?, ModelParameters::of(master.instance(place))?];
    let columns = master.record(|_| true);
    // Signals that are drawn and judged are recorded at every step, all others only as often as page and CSV file need them.
    // Pictures need no more than single precision.
    let mut drawn = Follow::new(&columns, |name| metrics::SIGNALS.contains(&name))
        .and_coarsely(&columns, |name| figures::SIGNALS.contains(&name))
        .with_room(points(grid));
    master.follow(&drawn.columns(columns.len()));
    let mut shown = Rows::new(grid, &columns);
    let csv = NewFile::create(setup.out.join(format!("{}.csv", controller.key)))?;
    let mut all = Every::new(CSV_INTERVAL, grid.stop(), CsvSink::new(csv, &columns)?);
    match master.run(grid, 0.0, &mut ((&mut drawn, &mut shown), &mut all), &mut |steps| done(steps)) {
        Err(MasterError::Record(error)) => return Err(all.sink.error(error).into()),
        result => result?,
    }
    results.add(all.sink.into_file()?)?;
    let rows = Packed::of(&shown.into_table(), &models);
    let (table, singles) = drawn.into_parts();
    let metrics = Metrics::of(&table, limits)
        .map_err(|source| ComparisonError::Metrics { controller: controller.fmu, source })?;
    let run = PaperRun { scenario: *controller, signals: figures::signals(table, singles), metrics, models };
    Ok(Made { run, rows, master })
}

/// How many communication points to expect, but no more than memory certainly has room for.
fn points(grid: &TimeGrid) -> usize {
    const MOST: u64 = 1 << 18;
    usize::try_from((grid.steps() + 1).min(MOST)).unwrap_or_default()
}
