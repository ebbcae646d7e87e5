//! What a search makes small.
//!
//! Each case gives a ratio: the time until all of (17) has settled over the larger one of the case's
//! [physical limit](crate::grasp::matrix::limit) and 0.1 s; or, where a case is judged by its error, the rms error over
//! 2 % of the target force, but no less than 0.4: who is that quiet shall rather be faster. What never settles counts as the whole run times one plus its error in those 2 %. A broken
//! limit multiplies the ratio by one plus its excess in units of the limit. The objective is
//!
//! ```text
//! exp((1 − w) · mean(ln ratio) + w · max(ln ratio)),
//! ```
//!
//! the typical ratio, with the worst case counting w more: 1 would be perfect in every case.

use crate::grasp::matrix::limit::BAND;
use crate::grasp::matrix::{Cell, Judged};

/// Faster than this, in s, no case has to be.
const FAST: f64 = 0.1;
/// Quieter than this share of the band, no case has to be: else a search buys a millinewton of noise with a third of its speed.
const QUIET: f64 = 0.4;
/// The ratio of a run that fails, and the largest one.
const WORST: f64 = 1e6;
/// The smallest ratio, so that an error of nothing is no −∞.
const LEAST: f64 = 1e-3;

/// What may not be exceeded.
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

/// The function of the cells that is to be small.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Objective {
    /// How much the worst case counts beside the mean of all, from 0 to 1.
    pub worst: f64,
    /// What may not be exceeded.
    pub limits: Limits,
}

impl Default for Objective {
    fn default() -> Self {
        Self { worst: 0.3, limits: Limits { overshoot: 2.0, torque: None, saturated: None, tension: None } }
    }
}

impl Objective {
    /// The objective for these cells; a run that failed is `None`.
    #[must_use]
    pub fn cost(&self, cells: &[Option<Cell>]) -> f64 {
        let logarithms: Vec<f64> =
            cells.iter().map(|cell| cell.as_ref().map_or(WORST, |cell| self.ratio(cell)).ln()).collect();
        let mean = logarithms.iter().sum::<f64>() / logarithms.len().max(1) as f64;
        let worst = logarithms.iter().copied().fold(f64::MIN, f64::max);
        ((1.0 - self.worst) * mean + self.worst * worst).exp()
    }

    /// The ratio of one case.
    #[must_use]
    pub fn ratio(&self, cell: &Cell) -> f64 {
        let Cell { merit, target, .. } = cell;
        let ratio = match cell.judged {
            Judged::Settling => merit.time_or_worse(cell.stop, *target) / cell.limit.max(FAST),
            Judged::Error => (merit.error_rms / (BAND * target.abs())).max(QUIET),
        };
        let Limits { overshoot, torque, saturated, tension } = self.limits;
        let excess = |value: f64, limit: f64| 1.0 + ((value - limit) / limit.max(1e-9)).max(0.0);
        let optional = |value: f64, limit: Option<f64>| limit.map_or(1.0, |limit| excess(value, limit));
        let mut factor = optional(merit.peak_torque, torque)
            * optional(merit.saturated, saturated)
            * optional(merit.tension, tension);
        if cell.judged == Judged::Settling {
            factor *= excess(merit.overshoot, overshoot);
        }
        let ratio = ratio * factor;
        if ratio.is_nan() { WORST } else { ratio.clamp(LEAST, WORST) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::matrix::Merit;
    use crate::grasp::matrix::merit::Grip;

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
        let close = |cell: Cell, ratio: f64| assert!((objective.ratio(&cell) - ratio).abs() < 1e-12 * ratio);
        close(cell(Some(0.4), 1.0, 0.0), 2.0);
        close(cell(Some(0.4), 6.0, 0.0), 2.0 * 3.0);
        close(cell(None, 0.0, 0.02), 6.0 * 3.0 / 0.2);
        close(Cell { judged: Judged::Error, ..cell(None, 50.0, 0.02) }, 2.0);
        close(Cell { judged: Judged::Error, ..cell(None, 50.0, 0.001) }, 0.4);
        close(Cell { limit: 0.01, ..cell(Some(0.4), 0.0, 0.0) }, 4.0);
        let limited = Objective { limits: Limits { torque: Some(0.5), ..objective.limits }, ..objective };
        assert!((limited.ratio(&cell(Some(0.4), 0.0, 0.0)) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn the_worst_case_counts_more_and_a_failed_run_most() {
        let objective = Objective { worst: 0.5, ..Objective::default() };
        let (good, bad) = (Some(cell(Some(0.2), 0.0, 0.0)), Some(cell(Some(3.2), 0.0, 0.0)));
        // Ratios 1 and 16: their geometric mean is 4, and √(4·16) = 8.
        assert!((objective.cost(&[good, bad]) - 8.0).abs() < 1e-12);
        assert!(objective.cost(&[good, None]) > 1e3 * objective.cost(&[good, bad]));
    }
}
