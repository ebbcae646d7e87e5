//! For how many steps nothing can leave the range of numbers.
//!
//! Whether a number is still usable need not be asked after every step: a step multiplies at most by what its matrices allow. If all
//! numbers of the state and all inputs are below [`CALM`], the next steps are refused by no test of their results, and the tests are left
//! out of as many.

use super::readings::Readings;
use super::step::Rigid;
use super::table::Table;
use crate::parameters::{Channel, Parameters};

/// The size of numbers that are far from being unusable.
pub(crate) const CALM: f64 = 1e40;

/// What coordinates may reach, so that signals and positions, sums of a hundred of them times [`FACTOR`], are still
/// [usable](crate::plant::all_usable).
const REACHED: f64 = 1e77;

/// By what signals, positions and forces may exceed coordinates and inputs.
const FACTOR: f64 = 1e20;

/// What the steps after a look at the state may [cost](cost) together.
pub(crate) const BUDGET: u32 = 4096;

/// The most steps in a row whose results are not looked at.
const MOST: u32 = 64;

/// How many times as large as commands and disturbances the forces on hubs and object can be, if these are large.
pub(super) fn gain(parameters: &Parameters) -> f64 {
    let of = |channel: &Channel| {
        let Channel { m_r, m_l, k_r, k_l, .. } = channel;
        1.0 + (1.0 + k_r.abs() + k_l.abs()) * (1.0 + m_r.abs() + m_l.abs())
    };
    of(&parameters.torque_channel).max(of(&parameters.force_channel))
}

/// What a step of this table costs of the [`BUDGET`], within which coordinates that were below [`CALM`] stay below [`REACHED`]; more than that
/// if it may lead further at once.
///
/// With m the largest coordinate and F the sum of the forces' sizes, a step leads to m' ≤ a (m + F), so m + F grows by at most 2a. If that many
/// times k times is within reach, a step costs a k-th of the budget; steps of several tables that cost all of it together multiply by no more.
/// Positions move by at most b (m' + F) / l.
#[inline(never)]
pub(super) fn cost(table: &Table, readings: &Readings, rigid: &Rigid, gain: f64, length: f64) -> u32 {
    let size = |numbers: &[f64]| numbers.iter().map(|number| number.abs()).sum::<f64>();
    let growth = 1.0 + (table.h * size(&rigid.gain)).max(table.largest_change());
    let (signal, position) = readings.largest_sums();
    let travel = position * growth + table.h * (rigid.velocity.abs() * growth + size(&rigid.drift));
    let factor = signal.max(4.0 * f64::from(MOST) * travel / length.min(1.0));
    // A number that is none is not below.
    let (mut steps, mut reached) = (0, 2.0 * gain * CALM);
    if factor < FACTOR && gain < FACTOR {
        while steps < MOST && reached * (2.0 * growth) < REACHED {
            reached *= 2.0 * growth;
            steps += 1;
        }
    }
    BUDGET.checked_div(steps).map_or(u32::MAX, |share| share + 1)
}
