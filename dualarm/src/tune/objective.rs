//! The objective that a search minimises.
//!
//! Each case has a ratio. It is the time until all of (17) has settled over the larger one of the case's [physical
//! limit](grasp_merit::limit) and 0.1 s. If a case is judged by its error, it is the rms error over 2 % of the
//! target force, but at least 0.4, so that a search does not trade speed for less noise than necessary. A run that never
//! settles counts as the whole run times one plus its error in units of those 2 %. A violated limit multiplies the ratio by
//! one plus its excess in units of the limit. The objective is
//!
//! ```text
//! exp((1 − w) · mean(ln ratio) + w · max(ln ratio)),
//! ```
//!
//! the typical ratio, with an additional weight w for the worst case: 1 would be perfect in every case.
//!
//! A weighted mean cannot express a requirement; a [`Goal`] can. If a case misses its goal by the factor x > 1, its ratio
//! is multiplied by x^10, at most by that of x = 2. So a goal that is nearly reached counts ten times as much as speed, and
//! a goal that is out of reach for a controller does not determine all of its gains.

use crate::grasp::matrix::{Cell, Judged};
use grasp_merit::limit::BAND;

/// Faster than this, in s, no case has to be.
const FAST: f64 = 0.1;
/// Smallest useful error as a share of the band. Without it a search would give up a third of its speed for a millinewton
/// of noise.
const QUIET: f64 = 0.4;
/// The ratio of a run that fails, and the largest one.
const WORST: f64 = 1e6;
/// The smallest ratio, so that an error of nothing is no −∞.
const LEAST: f64 = 1e-3;

/// Limits of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Overshoot of the forces in %, where settling counts.
    pub overshoot: f64,
    /// Largest torque in N·m.
    pub torque: Option<f64>,
    /// Time at the actuators' limits in s.
    pub saturated: Option<f64>,
    /// Tension of a contact force in N.
    pub tension: Option<f64>,
}

/// How much more a missed goal counts than speed.
const URGE: i32 = 10;
/// Beyond this factor a goal is out of reach, and does not count more.
const REACH: f64 = 2.0;

/// The requirements of one case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Latest settling in s, or largest rms error in N, whichever judges the case.
    pub value: f64,
    /// Largest overshoot of the forces in %, instead of that of [`Limits`]; counts in every case that has one.
    pub overshoot: Option<f64>,
}

/// The function of the cells that is to be small.
#[derive(Debug, Clone, PartialEq)]
pub struct Objective {
    /// How much the worst case counts beside the mean of all, from 0 to 1.
    pub worst: f64,
    /// The limits of every run.
    pub limits: Limits,
    /// Goals of the cases, in their order; cases beyond its end have none.
    pub goals: Vec<Option<Goal>>,
}

impl Default for Objective {
    fn default() -> Self {
        Self {
            worst: 0.3,
            limits: Limits { overshoot: 2.0, torque: None, saturated: None, tension: None },
            goals: Vec::new(),
        }
    }
}

/// The factor of a ratio for a value above its limit.
fn excess(value: f64, limit: f64) -> f64 {
    1.0 + ((value - limit) / limit.max(1e-9)).max(0.0)
}

impl Objective {
    /// The objective for these cells, one per case; a run that failed is `None`.
    #[must_use]
    pub fn cost(&self, cells: &[Option<Cell>]) -> f64 {
        let logarithms: Vec<f64> = (0..)
            .zip(cells)
            .map(|(case, cell)| cell.as_ref().map_or_else(|| self.failed(case), |cell| self.ratio(case, cell)).ln())
            .collect();
        let mean = logarithms.iter().sum::<f64>() / logarithms.len().max(1) as f64;
        let worst = logarithms.iter().copied().fold(f64::MIN, f64::max);
        ((1.0 - self.worst) * mean + self.worst * worst).exp()
    }

    /// The goal of a case.
    #[must_use]
    pub fn goal(&self, case: usize) -> Option<Goal> {
        self.goals.get(case).copied().flatten()
    }

    /// The ratio of the case of this number.
    #[must_use]
    pub fn ratio(&self, case: usize, cell: &Cell) -> f64 {
        let ratio = match cell.judged {
            Judged::Settling => value(cell) / cell.limit.max(FAST),
            Judged::Error => (value(cell) / (BAND * cell.target.abs())).max(QUIET),
        };
        let Limits { torque, saturated, tension, .. } = self.limits;
        let optional = |value: f64, limit: Option<f64>| limit.map_or(1.0, |limit| excess(value, limit));
        let merit = &cell.merit;
        let factor = optional(merit.peak_torque, torque)
            * optional(merit.saturated, saturated)
            * optional(merit.tension, tension)
            * self.overshoot(case, cell);
        let ratio = ratio * factor;
        let ratio = if ratio.is_nan() { WORST } else { ratio.clamp(LEAST, WORST) };
        let missed = self.goal(case).map_or(1.0, |_| self.missed(case, cell).clamp(1.0, REACH));
        ratio * missed.powi(URGE)
    }

    /// The ratio of a run that failed.
    fn failed(&self, case: usize) -> f64 {
        WORST * self.goal(case).map_or(1.0, |_| REACH.powi(URGE))
    }

    /// The factor of a case by which it misses its goal in time, error or overshoot, whichever it misses most, 1 or less where it
    /// holds it; 0 without a goal.
    #[must_use]
    pub fn missed(&self, case: usize, cell: &Cell) -> f64 {
        let Some(goal) = self.goal(case) else { return 0.0 };
        let reached = value(cell) / goal.value;
        if reached.is_nan() {
            return f64::INFINITY;
        }
        match self.overshoot(case, cell) {
            held if held <= 1.0 => reached,
            missed => reached.max(missed),
        }
    }

    fn overshoot(&self, case: usize, cell: &Cell) -> f64 {
        let usual = (cell.judged == Judged::Settling).then_some(self.limits.overshoot);
        let limit = self.goal(case).and_then(|goal| goal.overshoot).or(usual);
        limit.map_or(1.0, |limit| excess(cell.merit.overshoot, limit))
    }
}

/// The value by which a case is judged: the time in s, or the error in N.
fn value(cell: &Cell) -> f64 {
    match cell.judged {
        Judged::Settling => cell.merit.time_or_worse(cell.stop, cell.target),
        Judged::Error => cell.merit.error_rms,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_merit::merit::Grip;
    use grasp_merit::merit::Merit;

    fn cell(settling: Option<f64>, overshoot: f64, error_rms: f64) -> Cell {
        let merit = Merit {
            settling,
            settling_forces: settling,
            settling_angles: settling,
            settling_position: settling,
            overshoot,
            steady_error: 0.0,
            error_rms,
            peak_torque: 1.0,
            peak_force: 0.3,
            saturated: 0.0,
            tension: 0.0,
            grip: Grip { held_from: Some(0.0), lost: 0.0, drops: 0, peak: 0.5 },
        };
        Cell { judged: Judged::Settling, merit, impacts: None, limit: 0.2, own_limit: 0.3, target: 0.5, stop: 6.0 }
    }

    #[test]
    fn ratios_are_as_written() {
        let objective = Objective::default();
        let close = |cell: Cell, ratio: f64| assert!((objective.ratio(0, &cell) - ratio).abs() < 1e-12 * ratio);
        close(cell(Some(0.4), 1.0, 0.0), 2.0);
        close(cell(Some(0.4), 6.0, 0.0), 2.0 * 3.0);
        close(cell(None, 0.0, 0.02), 6.0 * 3.0 / 0.2);
        close(Cell { judged: Judged::Error, ..cell(None, 50.0, 0.02) }, 2.0);
        close(Cell { judged: Judged::Error, ..cell(None, 50.0, 0.001) }, 0.4);
        close(Cell { limit: 0.01, ..cell(Some(0.4), 0.0, 0.0) }, 4.0);
        let limited = Objective { limits: Limits { torque: Some(0.5), ..objective.limits }, ..objective };
        assert!((limited.ratio(0, &cell(Some(0.4), 0.0, 0.0)) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn the_worst_case_counts_more_and_a_failed_run_most() {
        let objective = Objective { worst: 0.5, ..Objective::default() };
        let (good, bad) = (Some(cell(Some(0.2), 0.0, 0.0)), Some(cell(Some(3.2), 0.0, 0.0)));
        // Ratios 1 and 16: their geometric mean is 4, and √(4·16) = 8.
        assert!((objective.cost(&[good, bad]) - 8.0).abs() < 1e-12);
        assert!(objective.cost(&[good, None]) > 1e3 * objective.cost(&[good, bad]));
    }
    #[test]
    fn a_missed_goal_counts_ten_times_until_it_is_out_of_reach() {
        let goal =
            |value, overshoot| Objective { goals: vec![None, Some(Goal { value, overshoot })], ..Objective::default() };
        let ratio = |objective: &Objective, cell: Cell| objective.ratio(1, &cell) / objective.ratio(0, &cell);
        let settled = |time: f64, overshoot: f64| cell(Some(time), overshoot, 0.0);
        let close = |is: f64, wanted: f64| assert!((is / wanted - 1.0).abs() < 1e-12, "{is} instead of {wanted}");
        // Held, missed by a fifth, out of reach.
        close(ratio(&goal(0.5, None), settled(0.4, 1.0)), 1.0);
        close(ratio(&goal(0.5, None), settled(0.6, 1.0)), 1.2_f64.powi(10));
        close(ratio(&goal(0.1, None), settled(0.4, 1.0)), 1024.0);
        close(ratio(&goal(0.1, None), cell(None, 0.0, 1e6)), 1024.0);
        // A case's own overshoot: 9 % exceed 6 by half, however early it settles, and do not exceed 10.
        close(goal(0.5, Some(6.0)).missed(1, &settled(0.5, 9.0)), 1.5);
        close(goal(0.5, Some(6.0)).missed(1, &settled(0.1, 9.0)), 1.5);
        close(goal(0.5, Some(10.0)).missed(1, &settled(0.5, 9.0)), 1.0);
        close(goal(0.5, Some(10.0)).ratio(1, &settled(0.4, 9.0)), 2.0);
        // If a case is judged by its error, overshoot counts only if the goal has one.
        let noisy = Cell { judged: Judged::Error, ..cell(None, 9.0, 0.012) };
        close(goal(0.01, None).missed(1, &noisy), 1.2);
        close(goal(0.01, Some(6.0)).missed(1, &noisy), 1.5);
        assert_eq!(goal(0.01, None).missed(0, &noisy), 0.0);
    }
}
