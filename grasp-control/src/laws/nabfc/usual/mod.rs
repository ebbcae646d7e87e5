//! The usual step: inputs that are held, networks that learn, are plain and have no ball, a low-pass. It leaves the commands that follow it
//! behind. Commands that are asked for before it are found in the same way.
//!
//! Lanes are the three loops, so whatever all of them do is done once: hub 1, hub 2, and the object in the last one. Inputs of
//! networks come as one row for each component and are turned into one column for each network; the star's last inputs, which the shear rates
//! move, as one row for each component with the points of the step in its lanes. Activations are in registers only. Number by number these are the
//! operations of the [general way](super::kernel) in the same order, so the same bits.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]
// It is for wide registers, which other processors than x86-64 have not: narrow ones are too few for it.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]

mod keep;
mod shared;
mod signals;
mod table;
#[cfg(test)]
mod tests;

pub(super) use keep::{Keep, Known};

use super::Nabfc;
use super::estimator::Learner;
use crate::blocks::exponential::powers;
use crate::blocks::four::{Four, LANES};
use crate::blocks::lowpass::LowPass;
use crate::blocks::rbf::{GRID, STAR, grid_output, learn_grid, learn_star, star_output, still_output};
use crate::signals::{Commands, Inputs};
use signals::Signals;
use table::Table;

/// Hubs: the first lanes.
const HUBS: usize = 2;

/// The lane of the object.
const OBJECT: usize = LANES - 1;

/// What a step changes.
struct State<'a> {
    hubs: [Learner<'a, GRID>; HUBS],
    object: Learner<'a, STAR>,
    filters: &'a mut LowPass,
}

/// The step, and the commands that follow it.
#[inline(always)]
fn step<V: Four>(table: &Table, state: State<'_>, inputs: &Inputs) -> Commands {
    let State { hubs: [hub1, hub2], object, filters } = state;
    let signals = Signals::<V>::of(table, inputs);
    let Signals { s, regressor, exponents: [z1, z2, still], .. } = signals;
    let rests = filters.state() == inputs.measured.tip_shear_dot;
    let learning = &table.learning[usize::from(rests)];

    // (55), with the outputs of the networks afterwards. The star follows when these are done, and not before: the compiler takes constants before
    // it stores weights, and would have to put those aside that it needs later.
    let mut of_grids = [V::splat(0.0); HUBS];
    let surfaces = s.lanes();
    // Of both before the weights of the first: these are as many instructions as a processor looks ahead.
    let of_z = powers([z1, z2]);
    for (hub, w) in [hub1.weights, hub2.weights].into_iter().enumerate() {
        let [decay, weight] = table.grid_weights[hub];
        let step = (decay, weight * surfaces[hub]);
        of_grids[hub] = learn_grid(w, &table.grid_heights[hub], table.least[hub], of_z[hub], step);
    }

    // The low-pass, and what it moves, at the nodes of the step and at its end.
    let follow = V::load(&table.follow);
    let [state1, state2] = filters.state();
    let [rate1, rate2] = inputs.measured.tip_shear_dot;
    let first = V::splat(state1) + V::splat(rate1 - state1) * follow;
    let second = V::splat(state2) + V::splat(rate2 - state2) * follow;
    filters.settle([first.lanes()[2], second.lanes()[2]]);
    let ([x1, x2, x3, _], regressors) = signals.moving(table, inputs, [first, second]);

    // (37).
    let [decay, weight1, weight2, _] = learning.star_weights;
    let object_s = s.last();
    let least = table.least[HUBS];
    let [of_still, of_first, of_second] = powers([still, x1, x2]);
    let shares = [weight1 * object_s, weight2 * object_s];
    let still =
        learn_star(object.weights, &table.star_heights, least, (of_still, [of_first, of_second]), (decay, shares));
    let [of_end] = powers([x3]);
    let of_star = star_output(object.weights, &table.star_heights[1], least, of_end, still);
    let [a, b, c, d] = V::columns([of_grids[0], of_grids[1], V::splat(0.0), of_star]);
    let outputs = (a + b) + (c + d);

    // (38), (39), (56) and (57).
    let [regressor1, regressor2, regressor3, _] = regressors.lanes();
    let tanh = signals.tanh(table);
    let drive = s * tanh;
    let bounds = V::load(&[*hub1.bound, *hub2.bound, 0.0, *object.bound]);
    let bounds = learning.bounds.step(bounds, [drive, drive]);
    let drives = [s * regressor.with_last(regressor1), s * regressor.with_last(regressor2)];
    let inertias = V::load(&[*hub1.inertia, *hub2.inertia, 0.0, *object.inertia]);
    let inertias = learning.inertias.step(inertias, drives);
    [*hub1.bound, *hub2.bound, _, *object.bound] = bounds.lanes();
    [*hub1.inertia, *hub2.inertia, _, *object.inertia] = inertias.lanes();
    signals.commands(table, inputs, tanh, regressor3, [outputs, bounds, inertias])
}

/// Commands before a step.
#[inline(always)]
fn look<V: Four>(table: &Table, state: State<'_>, inputs: &Inputs) -> Commands {
    let State { hubs: [hub1, hub2], object, filters } = state;
    let signals = Signals::<V>::of(table, inputs);
    let [z1, z2, of_still] = powers(signals.exponents);
    let of_grids: [V; HUBS] = std::array::from_fn(|hub| {
        let w: &[_; GRID] = [&*hub1.weights, &*hub2.weights][hub];
        grid_output(w, &table.grid_heights[hub], table.least[hub], [z1, z2][hub])
    });
    let ([x, ..], regressors) = signals.moving(table, inputs, filters.state().map(V::splat));
    let [of_x] = powers([x]);
    let still = still_output::<V>(object.weights, &table.star_heights[0], of_still);
    let of_star = star_output(object.weights, &table.star_heights[1], table.least[HUBS], of_x, still);
    let [a, b, c, d] = V::columns([of_grids[0], of_grids[1], V::splat(0.0), of_star]);
    let outputs = (a + b) + (c + d);
    let bounds = V::load(&[*hub1.bound, *hub2.bound, 0.0, *object.bound]);
    let inertias = V::load(&[*hub1.inertia, *hub2.inertia, 0.0, *object.inertia]);
    let regressor = regressors.lanes()[0];
    signals.commands(table, inputs, signals.tanh(table), regressor, [outputs, bounds, inertias])
}

impl Nabfc {
    /// Makes a usual step, if it is one; it is then one without a fault.
    #[inline(always)]
    pub(super) fn usual_step<V: Four>(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> bool {
        let Self { keep, object, posture: [arm1, arm2], shear_rate, .. } = self;
        let Some(table) = keep.table(h) else { return false };
        if !(rates.are_zeros() && inputs.are_surely_usable::<V>()) {
            return false;
        }
        let learners = (arm1.estimator.learner(), arm2.estimator.learner(), object.estimator.learner());
        let (Some(hub1), Some(hub2), Some(object)) = learners else { return false };
        let state = State { hubs: [hub1, hub2], object, filters: shear_rate };
        let commands = step::<V>(table, state, inputs);
        keep.put(inputs, commands);
        true
    }

    /// The commands, if there is a table for usual steps.
    #[inline(always)]
    pub(super) fn usual_commands<V: Four>(&mut self, inputs: &Inputs) -> Option<Commands> {
        let Self { keep, object, posture: [arm1, arm2], shear_rate, .. } = self;
        let table = keep.any_table()?;
        if !inputs.are_surely_usable::<V>() {
            return None;
        }
        let hubs = [arm1.estimator.learner()?, arm2.estimator.learner()?];
        let state = State { hubs, object: object.estimator.learner()?, filters: shear_rate };
        let commands = look::<V>(table, state, inputs);
        keep.put(inputs, commands);
        Some(commands)
    }
}
