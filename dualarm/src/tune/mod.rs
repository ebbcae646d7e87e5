//! `dualarm tune`: the best gains of a controller FMU over a set of cases.
//!
//! The search is the same for every controller: the same [cases](crate::grasp::matrix::Case), [objective](Objective),
//! method ([`search`]), budget and seed. It does not depend on the number of workers. A [`journal`] of its evaluations lets
//! it continue after an interruption, with the same result.

pub mod dimension;
pub mod journal;
pub mod objective;
pub mod preset;
pub mod search;
pub mod start;

use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::grasp::matrix::{Case, Cell, CellError, Contender, Lab, Matrix, parallel};
use dimension::{Dimension, DimensionError};
use fmi2_cosim::settings::Setting;
use journal::Journal;
pub use objective::{Goal, Limits, Objective};

/// The task of a search.
#[derive(Debug, Clone)]
pub struct Task {
    /// The controller with its fixed settings.
    pub contender: Contender,
    /// The varied parameters.
    pub dimensions: Vec<Dimension>,
    /// The cases in which it is judged.
    pub cases: Vec<Case>,
    /// The objective.
    pub objective: Objective,
    /// Evaluations of the objective, each of which runs every case.
    pub evaluations: usize,
    /// Of the search's random numbers.
    pub seed: u64,
}

/// The best that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// One value per dimension.
    pub values: Vec<f64>,
    /// The objective there.
    pub cost: f64,
    /// The evaluation that found it, from 1.
    pub evaluation: usize,
}

/// Why a search ends early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TuneError {
    /// A case cannot be run.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// A parameter cannot be varied so.
    #[error(transparent)]
    Dimension(#[from] DimensionError),
    /// The state file cannot be used.
    #[error("cannot use the state {}: {source}", path.display())]
    State {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The state belongs to another search.
    #[error(
        "{} belongs to another search: its {what} differs; delete it to begin anew, or name another one with --state",
        path.display()
    )]
    OtherSearch {
        /// The file.
        path: PathBuf,
        /// The difference.
        what: String,
    },
    /// The method gave up.
    #[error("the search stopped: {0}")]
    Search(String),
}

impl Task {
    /// The controller with these values.
    #[must_use]
    pub fn with(&self, values: &[f64]) -> Contender {
        let varied =
            self.dimensions.iter().zip(values).flat_map(|(dimension, value)| {
                dimension.names.iter().map(move |name| Setting::new(name.clone(), *value))
            });
        let mut contender = self.contender.clone();
        contender.settings.extend(varied);
        contender
    }

    /// The results at these values, case by case; cells whose runs failed are `None`.
    ///
    /// # Errors
    /// When an FMU cannot be used.
    pub fn cells(&self, lab: &Lab, values: &[f64], workers: usize) -> Result<Vec<Option<Cell>>, CellError> {
        let contender = self.with(values);
        // A case that counts several times runs once.
        let first = |case: usize| {
            self.cases
                .iter()
                .position(|other| (&other.key, &other.text) == (&self.cases[case].key, &self.cases[case].text))
                .unwrap_or(case)
        };
        let once: Vec<usize> = (0..self.cases.len()).filter(|case| first(*case) == *case).collect();
        let cells = parallel(workers, once.len(), |job| match lab.cell(&self.cases[once[job]], &contender) {
            Err(CellError::Run(_)) => Ok(None),
            cell => cell.map(Some),
        });
        let cells: Vec<Option<Cell>> = cells.into_iter().collect::<Result<_, _>>()?;
        let cell = |case| once.iter().position(|other| *other == first(case)).and_then(|job| cells[job]);
        Ok((0..self.cases.len()).map(cell).collect())
    }

    /// Checks that the controller can run with its start values.
    ///
    /// # Errors
    /// The reason why it cannot run in one of the cases, if it is known before, or fails in each of them.
    pub fn check(&self, lab: &Lab) -> Result<(), TuneError> {
        let start: Vec<f64> = self.dimensions.iter().map(|dimension| dimension.start).collect();
        let contender = self.with(&start);
        Matrix::check(lab, &self.cases, std::slice::from_ref(&contender))?;
        let mut failure = None;
        for case in &self.cases {
            match lab.cell(case, &contender) {
                Ok(_) => return Ok(()),
                Err(error) => failure = Some(error),
            }
        }
        failure.map_or(Ok(()), |error| Err(error.into()))
    }

    /// Runs the search. `heard` is called with each evaluation's number and the best so far.
    ///
    /// # Errors
    /// When an FMU or the state file cannot be used.
    pub fn run(
        &self,
        lab: &Lab,
        state: &Path,
        workers: usize,
        heard: &mut dyn FnMut(usize, &Best),
    ) -> Result<Best, TuneError> {
        let mut journal = Journal::open(state, &self.fingerprint(lab)?)?;
        let start: Vec<f64> = self.dimensions.iter().map(Dimension::start_coordinate).collect();
        let mut best: Option<Best> = None;
        let mut evaluation = 0;
        search::minimise(&start, self.seed, self.evaluations, &mut |point| {
            let values: Vec<f64> =
                self.dimensions.iter().zip(point).map(|(dimension, at)| dimension.value(*at)).collect();
            let cost = if let Some(cost) = journal.next(&values)? {
                cost
            } else {
                let cost = self.objective.cost(&self.cells(lab, &values, workers)?);
                journal.add(&values, cost)?;
                cost
            };
            evaluation += 1;
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Best { values, cost, evaluation });
            }
            if let Some(best) = &best {
                heard(evaluation, best);
            }
            Ok(cost)
        })?;
        best.ok_or_else(|| TuneError::Search("no evaluation was made".into()))
    }

    /// The fingerprint of the search: all of its parts except the budget, so that a search can be continued with a larger
    /// one.
    fn fingerprint(&self, lab: &Lab) -> Result<Value, TuneError> {
        let guid = lab.fmu(&self.contender.fmu).map_err(CellError::from)?.description().guid.clone();
        let plant = lab.fmu(Path::new(crate::grasp::PLANT)).map_err(CellError::from)?.description().guid.clone();
        let settings: Vec<_> = self.contender.settings.iter().map(ToString::to_string).collect();
        let dimensions: Vec<_> = self.dimensions.iter().map(ToString::to_string).collect();
        let cases: Vec<_> =
            self.cases.iter().map(|case| json!([case.key, case.text, case.scenario.experiment.stop])).collect();
        Ok(json!({
            "controller": self.contender.fmu.file_name().map(|name| name.to_string_lossy()),
            "guid": guid,
            "plant": plant,
            "settings": settings,
            "step": self.contender.step.map(|step| step.to_string()),
            "parameters": dimensions,
            "cases": cases,
            "objective": format!("{:?}", self.objective),
            "seed": self.seed,
        }))
    }
}
