//! The method: CMA-ES in the unit cube, restarted with twice the population after each convergence, until the budget is
//! used up.
//!
//! Reference: N. Hansen, *The CMA evolution strategy: a tutorial*, arXiv:1604.00772; restarts: A. Auger and N. Hansen, *A
//! restart CMA evolution strategy with increasing population size*, CEC 2005, doi:10.1109/CEC.2005.1554902.
//!
//! It compares costs and does not use the size of their differences (except for points outside the cube). So jumps, such as
//! from settled to never, do no harm.

use std::cell::RefCell;

use basin::{
    BoundedCmaEs, BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints, CostFunction,
    DenseMatrix, Executor, PopulationProgress,
};

use super::TuneError;

/// Standard deviation of the first generation, in the unit cube.
const SIGMA: f64 = 0.2;
/// Converged when no axis of the distribution is longer.
const CONVERGED: f64 = 1e-3;

/// Evaluates a point of the unit cube.
type Cost<'a> = &'a mut dyn FnMut(&[f64]) -> Result<f64, TuneError>;

/// Why an evaluation does not give a cost.
#[derive(Debug, thiserror::Error)]
enum Stop {
    #[error("the budget is spent")]
    Spent,
    #[error(transparent)]
    Failed(TuneError),
}

struct Problem<'a, 'b> {
    low: Vec<f64>,
    high: Vec<f64>,
    cost: &'b RefCell<Cost<'a>>,
    left: &'b RefCell<usize>,
}

impl CostFunction for Problem<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Stop;

    fn cost(&self, point: &Vec<f64>) -> Result<f64, Stop> {
        let left = self.left.borrow().checked_sub(1).ok_or(Stop::Spent)?;
        *self.left.borrow_mut() = left;
        (self.cost.borrow_mut())(point).map_err(Stop::Failed)
    }
}

impl Constraints for Problem<'_, '_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.low), Some(&self.high)))
    }
}

/// Evaluates `cost` at `evaluations` points of the unit cube, beginning at `start`. The points depend on `start`, `seed` and
/// the costs only, and the first n points do not depend on how many follow.
///
/// # Errors
/// The error of `cost`, or when the method cannot continue.
pub fn minimise(start: &[f64], seed: u64, evaluations: usize, cost: Cost<'_>) -> Result<(), TuneError> {
    let dimensions = start.len();
    let left = RefCell::new(evaluations);
    let cost = RefCell::new(cost);
    let problem = || Problem { low: vec![0.0; dimensions], high: vec![1.0; dimensions], cost: &cost, left: &left };
    let end = |stop| match stop {
        Stop::Spent => Ok(()),
        Stop::Failed(error) => Err(error),
    };
    if let Err(stop) = problem().cost(&start.to_vec()) {
        return end(stop);
    }
    let mut population = BoundedCmaEs::<Vec<f64>, DenseMatrix>::default_lambda(dimensions);
    for restart in 0_u64.. {
        let mean = if restart == 0 { start.to_vec() } else { vec![0.5; dimensions] };
        let solver = BoundedCmaEs::<_, DenseMatrix>::new(seed.wrapping_add(restart), SIGMA)
            .with_lambda(population)
            .with_absolute_distribution_size_tolerance(CONVERGED);
        let run = Executor::new(problem(), solver, PopulationProgress::from_point(mean)).max_iter(u64::MAX).run();
        match run {
            Ok(_) => {}
            Err(ConstraintSolveError::Evaluation(stop)) => return end(stop),
            Err(error) => return Err(TuneError::Search(error.to_string())),
        }
        population *= 2;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(evaluations: usize, seed: u64, cost: impl Fn(&[f64]) -> f64) -> Vec<(Vec<f64>, f64)> {
        let mut points = Vec::new();
        minimise(&[0.5, 0.5, 0.5], seed, evaluations, &mut |point| {
            points.push((point.to_vec(), cost(point)));
            Ok(cost(point))
        })
        .unwrap();
        points
    }

    /// An ellipsoid whose axes differ by a factor of 100, with its minimum at (0.2, 0.7, 1): the last coordinate is on the
    /// edge of the cube.
    fn ellipsoid(x: &[f64]) -> f64 {
        (x[0] - 0.2).powi(2) + 100.0 * (x[1] - 0.7).powi(2) + (x[2] - 1.3).powi(2)
    }

    #[test]
    fn the_lowest_point_is_found_also_on_the_edge() {
        let points = points(600, 1, ellipsoid);
        assert_eq!(points.len(), 600);
        let best = points.iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        // Converged means axes of 1e-3; the flattest direction may be off by a few of them.
        for (found, exact) in best.0.iter().zip([0.2, 0.7, 1.0]) {
            assert!((found - exact).abs() < 5e-3, "{:?}", best.0);
        }
        assert!(points.iter().all(|(point, _)| point.iter().all(|at| (0.0..=1.0).contains(at))));
    }

    #[test]
    fn points_depend_on_the_seed_and_not_on_the_budget() {
        let long = points(300, 7, ellipsoid);
        assert_eq!(points(90, 7, ellipsoid), long[..90]);
        assert_ne!(points(90, 8, ellipsoid), long[..90]);
    }
}
