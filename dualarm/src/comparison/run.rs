//! One run of the comparison.

use std::io;

use super::{CSV_INTERVAL, ComparisonError, Setup};
use crate::grasp::matrix::Lab;
use crate::grasp::scenarios::BuiltIn;

use crate::grasp::{Controller, GraspWatch, instruments};
use crate::report::figures;
use crate::report::html::Packed;
use crate::report::html::rows::Rows;
use crate::report::parameters::ModelParameters;
use fmi2_cosim::files::{FileSet, NewFile};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Master, MasterError};
use fmi2_cosim::record::{Column, CsvSink, Points, Single, Singles, Sink};
use fmi2_cosim::run::{Ended, Observer, Run};
use fmi2_cosim::scenario::ScenarioError;
use fmi2_import::Fmu;
use grasp_merit::metrics::Metrics;

/// The results of a run, the rows of the page, and the components.
pub struct Made {
    pub scenario: Controller,
    /// The signals of the figures.
    pub drawn: Vec<Single>,
    pub metrics: Metrics,
    pub models: Vec<ModelParameters>,
    pub rows: Packed,
    pub master: Master,
}

/// What is kept of a run: signals that are drawn and judged at every step, rows as often as the page needs them.
struct Watch {
    drawn: Singles,
    judged: GraspWatch,
    shown: Rows,
}

impl Observer for Watch {
    fn begin(&mut self, master: &mut Master, columns: &[Column]) -> Vec<String> {
        self.judged.begin(master, columns)
    }

    fn follows(&self, column: &Column) -> bool {
        figures::SIGNALS.contains(&column.name.as_str()) || self.judged.follows(column)
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        self.drawn.extend(points);
        self.judged.points(points)
    }

    fn rows(&mut self) -> Option<&mut dyn Sink> {
        Some(&mut self.shown)
    }

    fn conclude(&mut self) -> Vec<String> {
        Vec::new()
    }
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
    let columns = master.record(|_| true);
    let mut watch = Watch {
        drawn: Singles::new(&columns, |name| figures::SIGNALS.contains(&name), points(grid))
            .with_last_only(|name| figures::TARGETS.contains(&name)),
        judged: GraspWatch::default(),
        shown: Rows::new(grid, &columns),
    };
    let csv = NewFile::create(setup.out.join(format!("{}.csv", controller.key)))?;
    let mut all = CsvSink::new(csv, &columns)?;
    let run = Run { grid: *grid, coupling: setup.coupling, interval: CSV_INTERVAL };
    match run.execute(&system, &mut master, &columns, &mut all, &mut watch, &mut |steps| done(steps)) {
        Err(MasterError::Record(error)) => return Err(all.error(error).into()),
        result => {
            if let Some(Ended { time, component, source }) = result?.ended {
                return Err(MasterError::Ended { time, component, source }.into());
            }
        }
    }
    results.add(all.into_file()?)?;
    let models = vec![ModelParameters::of(master.instance(0))?, ModelParameters::of(master.instance(place))?];
    let Watch { drawn, judged, shown } = watch;
    let rows = Packed::of(&shown.into_table(), &models);
    let failed = |source| ComparisonError::Metrics { controller: controller.fmu, source };
    let metrics = judged.metrics().map_err(failed)?;
    Ok(Made { scenario: *controller, drawn: drawn.into_signals(), metrics, models, rows, master })
}

/// How many communication points to expect, but no more than memory certainly has room for.
fn points(grid: &TimeGrid) -> usize {
    const MOST: u64 = 1 << 18;
    usize::try_from((grid.steps() + 1).min(MOST)).unwrap_or_default()
}
