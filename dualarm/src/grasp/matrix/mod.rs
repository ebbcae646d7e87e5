//! Controllers × cases: every [`Contender`] in every [`Case`], judged by [`Merit`](grasp_merit::merit::Merit) and, if the
//! actuators determine it, beside the [physical limit](grasp_merit::limit).
//!
//! A case is a scenario file (folder `scenarios/matrix`; of grasps that can open, `scenarios/contact`), so `dualarm simulate`
//! repeats every cell.

pub mod case;
pub mod contender;
mod run;

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use serde::Serialize;

pub use case::{CASES, Case};
pub use contender::{CONTENDERS, Contender};
pub use run::{Cell, CellError, Lab};

/// The quantity that a row of the matrix compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judged {
    /// When all of (17) has settled.
    Settling,
    /// The remaining force error, if sensors or a wrong model prevent settling.
    Error,
}

/// All cells; `cells[case][contender]`.
#[derive(Debug, Clone)]
pub struct Matrix {
    /// The rows.
    pub cases: Vec<Case>,
    /// The columns.
    pub contenders: Vec<Contender>,
    /// The results, or why there is none.
    pub cells: Vec<Vec<Result<Cell, String>>>,
}

/// The matrices of a comparison.
#[derive(Debug, Clone)]
pub struct Matrices {
    /// The requested cases; by default those whose tips never leave the object.
    pub closed: Matrix,
    /// Those of grasps that can open, where they are not among the others.
    pub contact: Option<Matrix>,
}

impl Matrix {
    /// Checks, from the FMUs' descriptions alone, that each case can run with one of the controllers at least, and each controller
    /// in one of several cases. What a case sets for a law that only some of the controllers have, fails in the cells of the others.
    ///
    /// # Errors
    /// The reason why one of them cannot run at all.
    pub fn check(lab: &Lab, cases: &[Case], contenders: &[Contender]) -> Result<(), CellError> {
        let width = contenders.len();
        let mut reasons = Vec::with_capacity(cases.len() * width);
        for checked in
            parallel(workers(), cases.len() * width, |job| lab.check(&cases[job / width], &contenders[job % width]))
        {
            reasons.push(match checked {
                Ok(()) => None,
                Err(CellError::Run(reason)) => Some(reason),
                Err(error) => return Err(error),
            });
        }
        for (case, row) in cases.iter().zip(reasons.chunks(width.max(1))) {
            if let (Some(Some(reason)), true) = (row.first(), row.iter().all(Option::is_some)) {
                let who = match contenders {
                    [one] => format!("{} cannot run in the case {}", one.key, case.key),
                    _ => format!("no controller can run in the case {}", case.key),
                };
                return Err(CellError::Never(format!("{who}: {reason}")));
            }
        }
        for (place, contender) in contenders.iter().enumerate().filter(|_| cases.len() > 1) {
            let mut column = reasons.iter().skip(place).step_by(width);
            if column.clone().all(Option::is_some)
                && let Some(Some(reason)) = column.next()
            {
                return Err(CellError::Never(format!("{} can run in no case: {reason}", contender.key)));
            }
        }
        Ok(())
    }

    /// What did not run at all: cases in which the run of every controller failed, and controllers that failed in each of several
    /// cases.
    #[must_use]
    pub fn failed(&self) -> Vec<&str> {
        let cases = self.cases.iter().zip(&self.cells).filter(|(_, row)| row.iter().all(Result::is_err));
        let several = self.cases.len() > 1;
        let is_lost = |place: usize| several && self.cells.iter().all(|row| row[place].is_err());
        let contenders = self.contenders.iter().enumerate().filter(|(place, _)| is_lost(*place));
        cases
            .map(|(case, _)| case.key.as_str())
            .chain(contenders.map(|(_, contender)| contender.key.as_str()))
            .collect()
    }

    /// Runs all cells on `workers` threads; `done` is called for each finished cell.
    ///
    /// # Errors
    /// When an FMU or a scenario cannot be used at all. The failure of a single run is stored in its cell.
    pub fn run(
        lab: &Lab,
        cases: Vec<Case>,
        contenders: Vec<Contender>,
        done: &(dyn Fn() + Sync),
    ) -> Result<Self, CellError> {
        let jobs: Vec<(usize, usize)> =
            (0..cases.len()).flat_map(|case| (0..contenders.len()).map(move |contender| (case, contender))).collect();
        let results = parallel(workers(), jobs.len(), |job| {
            let (case, contender) = jobs[job];
            let result = lab.cell(&cases[case], &contenders[contender]);
            done();
            result
        });
        let mut results = results.into_iter();
        let mut cells = Vec::with_capacity(cases.len());
        for _ in &cases {
            let mut row = Vec::with_capacity(contenders.len());
            for _ in &contenders {
                row.push(match results.next() {
                    Some(Ok(cell)) => Ok(cell),
                    Some(Err(CellError::Run(reason))) => Err(reason),
                    Some(Err(error)) => return Err(error),
                    None => unreachable!("one result for each job"),
                });
            }
            cells.push(row);
        }
        Ok(Self { cases, contenders, cells })
    }

    /// The quantity that a row compares; settling if no cell ran.
    #[must_use]
    pub fn judged(&self, case: usize) -> Judged {
        self.cells[case].iter().flatten().map(|cell| cell.judged).next().unwrap_or(Judged::Settling)
    }

    /// The physical limits of a row in s, with and without the help of the arms, if the row compares settling times.
    #[must_use]
    pub fn limits(&self, case: usize) -> Option<[f64; 2]> {
        let cell = self.cells[case].iter().flatten().next()?;
        (cell.judged == Judged::Settling).then_some([cell.limit, cell.own_limit])
    }

    /// The best value of a row.
    #[must_use]
    pub fn best(&self, case: usize) -> Option<f64> {
        self.cells[case].iter().flatten().filter_map(Cell::value).min_by(f64::total_cmp)
    }
}

/// As many workers as there are processors.
#[must_use]
pub fn workers() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// Results of the jobs `0..count` in their order, computed in several threads; the results do not depend on the number of
/// threads.
///
/// # Panics
/// When a job fails.
pub fn parallel<T: Send>(workers: usize, count: usize, job: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    thread::scope(|scope| {
        for _ in 0..workers.clamp(1, count.max(1)) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(place) = results.get(index) else { return };
                    *place.lock().unwrap_or_else(PoisonError::into_inner) = Some(job(index));
                }
            });
        }
    });
    let taken = results.into_iter().map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner));
    taken.map(|result| result.expect("every job was done")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_from_any_number_of_workers() {
        for workers in [1, 2, 7, 100] {
            assert_eq!(parallel(workers, 50, |index| index * index), (0..50).map(|i| i * i).collect::<Vec<_>>());
        }
        assert!(parallel(4, 0, |index| index).is_empty());
    }
}
