//! One cell: a contender in a case.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;

use super::{Case, Contender, Judged};
use crate::grasp::actuator_limits;
use crate::grasp::instruments::{self, INSTRUMENTS};
use crate::grasp::scenarios::{is_controller, says_which_law};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Master, check_steps};
use fmi2_cosim::record::{Column, Sink, Table};
use fmi2_cosim::run;
use fmi2_cosim::scenario::ScenarioError;
use fmi2_cosim::system::System;
use fmi2_import::{Fmu, FmuError, Value};
use grasp_merit::limit::{BAND, Body, shortest};
use grasp_merit::merit::{Merit, SIGNALS};
use grasp_merit::metrics::Limits;

/// Stop time of a case that does not define one.
const STOP: f64 = 6.0;
const STEP: f64 = 1e-3;

/// The result of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cell {
    /// The quantity that the row compares.
    pub judged: Judged,
    /// How good it was.
    pub merit: Merit,
    /// How often a tip came onto the object; `None` if the plant does not count.
    pub impacts: Option<i32>,
    /// The shortest possible settling time in s.
    pub limit: f64,
    /// The same where the arms add nothing and only go along, in s.
    pub own_limit: f64,
    /// The force to be reached, in N.
    pub target: f64,
    /// Length of the run in s.
    pub stop: f64,
}

impl Cell {
    /// The compared quantity: settling time in s or force error in N; `None` for never.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        match self.judged {
            Judged::Settling => self.merit.settling,
            Judged::Error => Some(self.merit.error_rms),
        }
    }
}

/// Why a cell is empty.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CellError {
    /// An FMU cannot be used.
    #[error("{0}; `dualarm package` makes the FMUs, --fmus says where they are")]
    Fmu(#[from] FmuError),
    /// The case has no controller that another one could replace.
    #[error("the case {0} uses none of the project's controllers, so there is none to replace")]
    NoController(String),
    /// The case's file has something that belongs elsewhere.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The run failed.
    #[error("{0}")]
    Run(String),
    /// A case cannot run with any controller, or a controller in no case.
    #[error("{0}")]
    Never(String),
}

/// Where runs are made: a folder of FMUs, each of which is opened once.
pub struct Lab {
    folder: PathBuf,
    /// Each behind a lock of its own: whoever wants another one need not wait.
    opened: Mutex<HashMap<PathBuf, Arc<Mutex<Option<Fmu>>>>>,
}

impl Lab {
    /// A lab with the FMUs of a folder.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), opened: Mutex::default() }
    }

    /// An FMU of the folder, or wherever its path leads.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn fmu(&self, file: &Path) -> Result<Fmu, FmuError> {
        let path = if file.is_file() { file.to_owned() } else { self.folder.join(file) };
        let place =
            Arc::clone(self.opened.lock().unwrap_or_else(PoisonError::into_inner).entry(path.clone()).or_default());
        let mut opened = place.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(fmu) = &*opened {
            return Ok(fmu.clone());
        }
        let fmu = Fmu::open(&path)?;
        *opened = Some(fmu.clone());
        Ok(fmu)
    }

    /// Runs a cell.
    ///
    /// # Errors
    /// When an FMU cannot be used, the case has no controller, or the run fails.
    pub fn cell(&self, case: &Case, contender: &Contender) -> Result<Cell, CellError> {
        let (system, controller) = self.system(case, contender)?;
        cell(&system, &controller, contender.step).map_err(CellError::Run)
    }

    /// Checks, from the FMUs' descriptions alone, that a cell can run.
    ///
    /// # Errors
    /// As [`Lab::cell`], but for what happens in a run.
    pub fn check(&self, case: &Case, contender: &Contender) -> Result<(), CellError> {
        let (system, _) = self.system(case, contender)?;
        let grid = grid(&system, contender.step).map_err(CellError::Run)?;
        let descriptions = system.components.iter().map(|(name, fmu)| (name.as_str(), fmu.description()));
        check_steps(descriptions, &grid).map_err(|error| CellError::Run(error.to_string()))?;
        system.check().map_err(|error| CellError::Run(error.to_string()))
    }

    /// Runs a cell for callers that need its rows. Returns the sink and the instances in their final state. The sink gets the rows
    /// that it wants, and at every step the outputs that are `followed`.
    ///
    /// # Errors
    /// As [`Lab::cell`].
    pub fn observe<S: Sink>(
        &self,
        case: &Case,
        contender: &Contender,
        followed: &[&str],
        sink: impl FnOnce(&TimeGrid, &[Column]) -> S,
    ) -> Result<(S, Master), CellError> {
        let (system, _) = self.system(case, contender)?;
        let failed = |error: &dyn std::fmt::Display| CellError::Run(error.to_string());
        let grid = grid(&system, contender.step).map_err(CellError::Run)?;
        let mut master =
            system.master(system.experiment.coupling.unwrap_or_default()).map_err(|error| failed(&error))?;
        master.initialize(&grid).map_err(|error| failed(&error))?;
        let columns = master.record(|_| true);
        master.follow(&columns.iter().map(|column| followed.contains(&column.name.as_str())).collect::<Vec<_>>());
        let mut sink = sink(&grid, &columns);
        master.run(&grid, 0.0, &mut sink, &mut |_| ()).map_err(|error| failed(&error))?;
        Ok((sink, master))
    }

    /// The case with the contender in its controller's place, which is the second part of the result.
    pub(crate) fn system(&self, case: &Case, contender: &Contender) -> Result<(System, String), CellError> {
        let scenario = &case.scenario;
        let replaced = scenario.fmus.iter().find(|file| is_controller(file));
        let replaced = replaced.ok_or_else(|| CellError::NoController(case.key.clone()))?;
        let open = |file: &PathBuf| self.fmu(if file == replaced { &contender.fmu } else { file });
        let fmus = scenario.fmus.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        let place = scenario.fmus.iter().position(|file| file == replaced).unwrap_or_default();
        let mut scenario = scenario.clone();
        scenario.settings.retain(|setting| !says_which_law(setting));
        let mut system = scenario.system_of(&fmus)?;
        let controller = system.components[place].0.clone();
        system.settings.splice(0..0, contender.settings_in(&controller));
        instruments::connect(&mut system).map_err(|error| CellError::Run(error.to_string()))?;
        Ok((system, controller))
    }
}

/// The communication points of a case; `step` is the step size of the contender.
fn grid(system: &System, step: Option<f64>) -> Result<TimeGrid, String> {
    let experiment = system.experiment;
    let start = experiment.start.unwrap_or(0.0);
    let stop = experiment.stop.unwrap_or(start + STOP);
    let step = step.or(experiment.step).unwrap_or(STEP);
    run::grid(start, stop, step).map_err(|error| error.to_string())
}

fn cell(system: &System, controller: &str, step: Option<f64>) -> Result<Cell, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let grid = grid(system, step)?;
    let mut master = system.master(system.experiment.coupling.unwrap_or_default()).map_err(|error| text(&error))?;
    master.initialize(&grid).map_err(|error| text(&error))?;
    let mut table = Table::new(master.record(|name| SIGNALS.contains(&name)));
    let result = master.run(&grid, 0.0, &mut table, &mut |_| ());
    result.map_err(|error| text(&error))?;
    let mut models = Models { master: &mut master, system };
    let limits = actuator_limits(models.master.instance(models.place("contact_force1").unwrap_or_default()));
    let merit = Merit::of(&table, limits).ok_or("the plant or the controller lacks outputs that are judged")?;
    let judged = if models.is_noisy() || models.is_misinformed(controller) { Judged::Error } else { Judged::Settling };
    let last = |name: &str| table.column(name).and_then(|values| values.last().copied()).unwrap_or_default();
    let first = |name: &str| table.column(name).and_then(|values| values.first().copied()).unwrap_or_default();
    let target = last("lambda2_d");
    let ways = ["theta1", "theta2", "y_object"].map(|name| last(&format!("{name}_d")) - first(name));
    let impacts = models.impacts();
    let [limit, own_limit] = models.limits(limits, ways, target);
    Ok(Cell { judged, merit, impacts, limit, own_limit, target, stop: grid.stop() - grid.start() })
}

/// The instances of a run, for reading values.
struct Models<'a> {
    master: &'a mut Master,
    system: &'a System,
}

impl Models<'_> {
    /// The first component that has this variable.
    fn place(&self, variable: &str) -> Option<usize> {
        self.system.components.iter().position(|(_, fmu)| fmu.description().variable(variable).is_some())
    }

    fn real(&mut self, place: usize, name: &str) -> Option<f64> {
        let instance = self.master.instance(place);
        let reference = instance.description().variable(name)?.value_reference;
        let mut value = [0.0];
        instance.get_real(&[reference], &mut value).ok()?;
        Some(value[0])
    }

    /// How often a tip has come onto the object.
    fn impacts(&mut self) -> Option<i32> {
        let instance = self.master.instance(self.place("impacts1")?);
        let mut count = |name: &str| match instance.get(&instance.description().variable(name)?.clone()) {
            Ok(Value::Integer(impacts)) => Some(impacts),
            _ => None,
        };
        Some(count("impacts1")?.saturating_add(count("impacts2")?))
    }

    /// Whether sensors are noisy or coarse: not as they are by themselves.
    fn is_noisy(&mut self) -> bool {
        let Some(place) = self.system.components.iter().position(|(_, fmu)| INSTRUMENTS.is(fmu)) else { return false };
        let instance = self.master.instance(place);
        let Some(variable) = instance.description().variable("sensor_profile").cloned() else { return false };
        let is_plain = |value: &Value| {
            variable
                .items()
                .iter()
                .any(|item| ["parameters", "off"].contains(&item.name.as_str()) && *value == Value::Integer(item.value))
        };
        instance.get(&variable).is_ok_and(|value| !is_plain(&value))
    }

    /// Whether the controller has other arms in mind than the plant has.
    fn is_misinformed(&mut self, controller: &str) -> bool {
        let plant = self.place("contact_force1");
        let controller = self.system.components.iter().position(|(name, _)| name == controller);
        let (Some(plant), Some(controller)) = (plant, controller) else { return false };
        ["EI1", "EI2", "l", "L"].into_iter().any(|name| {
            let values = (self.real(plant, name), self.real(controller, name));
            matches!(values, (Some(one), Some(other)) if one != other)
        })
    }

    /// The [limits](grasp_merit::limit) of this plant on these ways: with all that the arms may add, and without.
    fn limits(&mut self, limits: [Option<Limits>; 3], ways: [f64; 3], target: f64) -> [f64; 2] {
        let Some(plant) = self.place("contact_force1") else { return [0.0; 2] };
        let mut real = |name: &str| self.real(plant, name).unwrap_or_default();
        let contact = (1.0 + BAND) * target.abs();
        let thrust = |limits: Option<Limits>, more: f64| limits.map(|limits| limits.high.max(-limits.low) + more);
        let (moment, disturbance) = (contact * real("l"), real("delta_F").abs());
        let hubs = [
            Body { inertia: real("J1"), way: ways[0], thrust: thrust(limits[0], moment + real("delta_f1").abs()) },
            Body { inertia: real("J2"), way: ways[1], thrust: thrust(limits[1], moment + real("delta_f2").abs()) },
        ];
        let hubs = hubs.into_iter().map(shortest).fold(0.0, f64::max);
        let pushed = Body { inertia: real("M"), way: ways[2], thrust: thrust(limits[2], contact + disturbance) };
        let mass = real("M") + real("m1") + real("m2");
        let alone = Body { inertia: mass, way: ways[2], thrust: thrust(limits[2], disturbance) };
        [pushed, alone].map(|object| shortest(object).max(hubs))
    }
}
