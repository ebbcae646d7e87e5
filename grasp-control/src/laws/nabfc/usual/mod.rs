//! The usual step: inputs that are held and for which the loops are not evaluated already, networks that learn, are plain and have no ball, a
//! low-pass in motion. It leaves the commands that follow it behind.
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
mod table;
#[cfg(test)]
mod tests;

pub(super) use keep::{Keep, Known};

use super::Nabfc;
use super::estimator::Learner;
use crate::blocks::exponential::{LARGEST, powers, tanh_of};
use crate::blocks::four::{Four, LANES};
use crate::blocks::lowpass::LowPass;
use crate::blocks::rbf::{GRID, STAR, learn_grid, learn_star, star_output};
use crate::signals::{Commands, Inputs};
use table::Table;

/// Hubs: the first lanes.
const HUBS: usize = 2;

/// The lane of the object.
const OBJECT: usize = LANES - 1;

/// Clamped.
#[inline(always)]
fn within<V: Four>(x: V, (least, most): (V, V)) -> V {
    most.smaller(least.larger(x))
}

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
    let (measured, reference) = (&inputs.measured, &inputs.reference);
    let (shear, lambda1) = (measured.tip_shear, reference.lambda1_ref);

    // (16), (33) and (51).
    let [by_theta1, by_lambda1, rest] = &table.targets;
    let targets = V::load(by_theta1) * V::splat(reference.theta1_ref) + V::load(by_lambda1) * V::splat(lambda1);
    let position = V::pairs(measured.theta, [0.0, measured.y_object]);
    let error = position - (targets + V::load(rest));
    let velocity = V::pairs(measured.theta_dot, [0.0, measured.y_object_dot]);
    let slope = V::load(&table.slope);
    let [c1, c2] = table.compliance;
    let shear_error = (shear[0] - lambda1) * c1 + (shear[1] + lambda1) * c2;
    let s = slope * error + velocity;
    let s = s.with_last(s.last() + shear_error);
    let regressor = velocity * slope;

    // The networks' inputs but for those that the shear rates move: clamped, squared, exponents of two, by component.
    let reach = (V::load(&table.reach[0]), V::load(&table.reach[1]));
    let [of_error, of_surface, of_alpha] = &table.scales;
    let x = [
        error * V::load(of_error),
        s * V::load(of_surface),
        ((V::load(&table.alpha) * velocity) * V::load(of_alpha)).with_last(shear[0] * c1 * table.shear[0]),
        V::splat(0.0).with_last(shear[1] * c2 * table.shear[1]),
    ];
    let [a, b, c, d] = [within(x[0], reach), within(x[1], reach), within(x[2], reach), within(x[3], reach)];
    let norm2 = (a * a + b * b) + (c * c + d * d);
    let step = V::load(&table.step);
    let common = (norm2 * V::load(&table.common)).larger(V::splat(-LARGEST));
    let [z1, z2, _, still] = V::columns([a * step, b * step, c * step, d * step + common]);
    let still_norm2 = norm2.last();

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
    let [rate1, rate2] = measured.tip_shear_dot;
    let first = V::splat(state1) + V::splat(rate1 - state1) * follow;
    let second = V::splat(state2) + V::splat(rate2 - state2) * follow;
    filters.settle([first.lanes()[2], second.lanes()[2]]);
    let [[alpha1, regressor1], [alpha2, regressor2]] = table.by_rate;
    let object_velocity = V::splat(measured.y_object_dot);
    let alpha =
        object_velocity * V::splat(table.by_velocity[0]) + (first * V::splat(alpha1) + second * V::splat(alpha2));
    let regressors = object_velocity * V::splat(table.by_velocity[1])
        + (first * V::splat(regressor1) + second * V::splat(regressor2));
    let [star_reach, star_step, star_common] = table.star;
    let a = alpha.within(star_reach);
    let b = (first * V::splat(table.by_own_rate[0])).within(star_reach);
    let c = (second * V::splat(table.by_own_rate[1])).within(star_reach);
    let norm2 = V::splat(still_norm2) + ((a * a + b * b) + c * c);
    let common = (norm2 * V::splat(star_common)).larger(V::splat(-LARGEST));
    let step = V::splat(star_step);
    let [x1, x2, x3, _] = V::columns([a * step, b * step, c * step, common]);

    // (37).
    let [decay, weight1, weight2] = table.star_weights;
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
    let tanh = tanh_of(s / V::load(&table.width));
    let drive = s * tanh;
    let bounds = V::load(&[*hub1.bound, *hub2.bound, 0.0, *object.bound]);
    let bounds = table.bounds.step(bounds, [drive, drive]);
    let drives = [s * regressor.with_last(regressor1), s * regressor.with_last(regressor2)];
    let inertias = V::load(&[*hub1.inertia, *hub2.inertia, 0.0, *object.inertia]);
    let inertias = table.inertias.step(inertias, drives);
    [*hub1.bound, *hub2.bound, _, *object.bound] = bounds.lanes();
    [*hub1.inertia, *hub2.inertia, _, *object.inertia] = inertias.lanes();

    // (36) and (54).
    let of_s = V::load(&table.switching) * s.within(table.limit) - V::load(&table.k) * s - error;
    let of_inertias = inertias * regressor.with_last(regressor3);
    let loads = V::pairs(measured.root_moment, [0.0, shear[1]]);
    let with_loads = of_s - of_inertias.with_last(-shear[0]) + loads;
    let [tau1, tau2, _, u] = (with_loads - outputs - bounds * tanh).lanes();
    Commands { tau: [tau1, tau2], u: u - of_inertias.last() }
}

impl Nabfc {
    /// Makes a usual step, if it is one; it is then one without a fault.
    #[inline(always)]
    pub(super) fn usual_step<V: Four>(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> bool {
        let Self { keep, object, posture: [arm1, arm2], shear_rate, .. } = self;
        let Some(table) = keep.table(h) else { return false };
        let is_usual = !(keep.knows_loops() && keep.seen.has_bits_of(inputs))
            && shear_rate.state() != inputs.measured.tip_shear_dot
            && rates.are_zeros()
            && inputs.are_surely_usable::<V>();
        if !is_usual {
            return false;
        }
        let learners = (arm1.estimator.learner(), arm2.estimator.learner(), object.estimator.learner());
        let (Some(hub1), Some(hub2), Some(object)) = learners else { return false };
        let commands = step::<V>(table, State { hubs: [hub1, hub2], object, filters: shear_rate }, inputs);
        keep.put(inputs, commands);
        true
    }
}
